"""What cannot be is refused before the first tick, with what was wrong and what would work; nothing is left open."""

from __future__ import annotations

import math
import re

import pytest
from game_table import GAMES

from simcore.errors import ConfigError, EngineError, FieldMeshError, NonFiniteError, UnknownNameError
from simcore.match.game import Auto, Game, RobotEntry
from simcore.match.match import Match
from simcore.match.runner import play_auto
from simcore.match.scripted import ScriptedRobot
from simcore.telemetry.sinks import MemorySink

INSIDE = {
    "rebuilt": (4.6, 4.0, 0.0),
    "reefscape": (4.5, 4.0, 0.0),
    "crates": (0.3, 5.0, 0.0),
}
"""A start inside of an element: the hub, the reef, the dock."""


@pytest.mark.parametrize("seed", [None, -1, 1.5, True, "3"])
def test_a_seed_is_a_whole_number(game, seed):
    with pytest.raises(ConfigError, match=rf"seed must be a whole number >= 0, got {seed!r}"):
        Match(game, seed=seed)
    if seed is not None:  # in a reset None is the same seed again
        with Match(game, robots=(RobotEntry(preload=0),)) as match, pytest.raises(ConfigError, match="seed must be"):
            match.reset(seed=seed)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"practice": "no"}, "practice must be True or False, got 'no'"),
        ({"sinks": [5]}, "sinks must be TelemetrySinks, with due, write and close, got 5"),
        ({"engine": 5}, "engine must be None, 'bullet' or 'mujoco', or an Engine, got 5"),
    ],
)
def test_settings_of_another_kind_are_refused(game, settings, said):
    with pytest.raises(ConfigError, match=re.escape(said)):
        Match(game, **settings)


def test_a_refused_sink_or_clock_leaves_a_match_as_it_was(game):
    sink = MemorySink()
    with Match(game, sinks=[sink]) as match:
        match.tick()
        with pytest.raises(ConfigError, match="sinks must be"):
            match.reset(sinks=[5])
        with pytest.raises(NonFiniteError, match="network time must be a finite number"):
            match.set_network_time(math.nan)
        match.tick()
        assert match.ticks == 2 and match.sinks == [sink]


def test_an_unknown_option_offers_the_known_ones(game):
    with pytest.raises(UnknownNameError, match=rf"option of {game.name}"):
        Match(game, options=("no such option",))
    for option in game.options:
        with pytest.raises(UnknownNameError, match=rf"option of {game.name}.*Did you mean '{option.name}'"):
            Match(game, options=(option.name[:-1],))


def refused(game: Game, *robots: RobotEntry) -> str:
    with pytest.raises(ConfigError) as caught:
        Match(game, robots=robots)
    return str(caught.value)


def test_robots_that_cannot_start_are_refused(game):
    length, width = game.field.size
    for x, y in ((-1.0, 2.0), (length + 1.0, 2.0), (2.0, width + 3.0)):
        assert "starts outside of the field" in refused(game, RobotEntry(start=(x, y, 0.0)))
    assert "starts inside of a field element" in refused(game, RobotEntry(start=INSIDE[game.name]))
    start = game.starts[0]
    assert "starts inside of robot 0" in refused(game, RobotEntry(start=start), RobotEntry(start=start))
    many = [RobotEntry(start=(1.0 + i, 1.5, 0.0), preload=0) for i in range(game.robots + 1)]
    assert f"at most {game.robots} robots, got {game.robots + 1}" in refused(game, *many)
    assert f"preload must be 0..{game.preload}" in refused(game, RobotEntry(preload=game.preload + 1))
    if len(game.starts) < game.robots:
        alike = [RobotEntry() for _ in range(len(game.starts) + 1)]
        assert f"{len(game.starts)} starts an alliance" in refused(game, *alike)


def test_a_red_robots_start_is_checked_where_it_stands(game):
    """Its entry has the start as blue, so the text says both places."""
    x, y, _ = INSIDE[game.name]
    said = refused(game, RobotEntry(alliance="red", start=INSIDE[game.name]))
    there = game.field.symmetry.flip_point(x, y)
    assert (
        f"starts inside of a field element, at ({there[0]:.2f}, {there[1]:.2f}) m, as blue ({x:.2f}, {y:.2f}) m" in said
    )
    *_, as_blue = re.findall(r"as blue \(([-.\d]+), ([-.\d]+)\) m is free", said)
    Match(game, robots=(RobotEntry(alliance="red", start=(float(as_blue[0]), float(as_blue[1]), 0.0)),)).close()


def test_a_robot_is_carried_only_to_where_it_can_stand(game):
    with Match(game, robots=(RobotEntry(preload=0),)) as match:
        before = match.robots[0].chassis.pose
        for number, pose, said in (
            (0, (100.0, 50.0, 0.0), "outside of the field"),
            (0, INSIDE[game.name], r"inside of a field element.* m is free"),
            (0, (2.0, math.nan, 0.0), r"pose\[1\] must be a number"),
            (0, None, "pose must be 3 numbers"),
            (1, (2.0, 2.0, 0.0), "there are robots 0 to 0, got 1"),
        ):
            with pytest.raises(ConfigError, match=said):
                match.carry_to(number, pose)
        with pytest.raises(ConfigError, match=r"pose\[0\] must be a number from -100 to 100 m"):
            match.robots[0].reset((1e6, 0.0, 0.0))
        assert match.robots[0].chassis.pose == before


def test_entries_that_cannot_be_are_refused():
    for bad, words in (
        ({"alliance": "green"}, "alliance must be 'blue' or 'red'"),
        ({"start": (1.0, math.nan, 0.0)}, r"start\[1\] must be a number from -100 to 100 m, got nan"),
        ({"start": (1.0, 2.0)}, r"start must be 3 numbers \(m, m, rad\), got \(1.0, 2.0\)"),
        ({"preload": -1}, "preload must be a whole number"),
        ({"preload": 1.5}, "preload must be a whole number"),
    ):
        with pytest.raises(ConfigError, match=words):
            RobotEntry(**bad)


def test_a_preload_beyond_the_robots_room_is_refused(game):
    from dataclasses import replace

    robot = game.robot()
    small = replace(robot, storage=replace(robot.storage, capacity=1))
    if game.preload > 1:
        assert "holds 1 pieces, got a preload of 2" in refused(game, RobotEntry(preload=2, config=small))
    with Match(game, robots=(RobotEntry(config=small),)) as match:
        assert match.count.held == 1, "with no number given it takes what fits"
        assert match.count.is_conserved


def test_more_controllers_than_robots_and_a_robot_that_is_not_there_are_refused(game):
    with pytest.raises(ConfigError, match="2 controllers for 1 robots"):
        Match(game, controllers=[None, None])
    with Match(game) as match, pytest.raises(ConfigError, match="there are robots 0 to 0, got 1"):
        match.set_controller(1, None)


def test_a_missing_mesh_ends_the_build(game, tmp_path):
    with pytest.raises(FieldMeshError, match=r"none\.obj"):
        Match(game, field_mesh=tmp_path / "none.obj")


@pytest.mark.parametrize("seconds", [0.0, -1.0, math.nan, math.inf])
def test_an_auto_takes_a_finite_time(game, seconds):
    with pytest.raises(ConfigError, match="seconds must be a number above 0"):
        play_auto(game, seconds=seconds)


def test_an_unknown_auto_offers_the_nearest(game):
    name = next(iter(game.autos))
    with pytest.raises(UnknownNameError, match=f"Did you mean '{name}'"):
        play_auto(game, name[:-1] + "x")


def test_a_script_with_a_bug_passes_its_error_on_and_leaves_nothing_open(game):
    def script(robot):
        yield from robot.wait(0.1)
        raise RuntimeError("student bug")

    sink, seen = MemorySink(), []
    auto = Auto(name="bug", summary="", start=game.starts[0], controller=lambda m, a: ScriptedRobot(script, m, a))
    with pytest.raises(RuntimeError, match="student bug"):
        play_auto(game, auto, seconds=1.0, sinks=[sink], on_tick=seen.append)
    assert len(sink.snapshots) == 5, "the log goes up to the bug"
    assert sink.closed
    with pytest.raises(EngineError, match="closed"):
        seen[0].world.step(0.02)


def test_a_sink_that_cannot_be_closed_keeps_nobody_else_open(game):
    class Full(MemorySink):
        def close(self):
            raise OSError("disk full")

    other = MemorySink()
    match = Match(game, sinks=[Full(), other])
    with pytest.raises(OSError, match="disk full"):
        match.close()
    assert other.closed
    with pytest.raises(EngineError, match="closed"):
        match.tick()


def test_a_game_that_cannot_be_is_refused():
    from dataclasses import replace

    crates = GAMES["crates"]
    for change, words in (
        ({"name": "my game"}, "letters, digits"),
        ({"starts": ()}, "starts must have at least one place"),
        ({"pieces": crates.pieces[:1] * 2}, "kinds of pieces must differ"),
    ):
        with pytest.raises(ConfigError, match=words):
            replace(crates, **change)
    with pytest.raises(ConfigError, match="either a mesh or elements"):
        replace(crates.field, elements=())
    with pytest.raises(ConfigError, match="symmetry is of a field of"):
        replace(crates.field, size=(10.0, 6.0))
