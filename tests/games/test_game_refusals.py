"""Invalid input is refused before the first tick, with the problem and what would work; nothing is left open."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import pytest
from game_table import GAMES

from simcore.errors import ConfigError, EngineError, FieldMeshError, UnknownNameError
from simcore.match.game import Auto, RobotEntry
from simcore.match.match import Match
from simcore.match.runner import play_auto
from simcore.match.scripted import ScriptedRobot
from simcore.telemetry.sinks import MemorySink

CRATES = GAMES["crates"]
INSIDE = {"rebuilt": (4.6, 4.0, 0.0), "reefscape": (4.5, 4.0, 0.0), "crates": (0.3, 5.0, 0.0)}
"""Start inside an element: the hub, the reef, the dock."""


def of_game(game):
    """Yield calls that every game refuses, with error and message."""
    length, width = game.field.size
    start, auto = game.starts[0], next(iter(game.autos))
    small = replace(game.robot(), storage=replace(game.robot().storage, capacity=1))

    def robots(*entries):
        return lambda: Match(game, robots=entries)

    many = [RobotEntry(start=(1.0 + i, 1.5, 0.0), preload=0) for i in range(game.robots + 1)]
    alike = [RobotEntry() for _ in range(len(game.starts) + 1)]
    yield from (
        (lambda seed=seed: Match(game, seed=seed), ConfigError, f"seed must be a whole number >= 0, got {seed!r}")
        for seed in (None, -1, 1.5, True, "3")
    )
    yield from (
        (lambda seconds=seconds: play_auto(game, seconds=seconds), ConfigError, "seconds must be a number above 0")
        for seconds in (0.0, -1.0, math.nan, math.inf)
    )
    yield from (
        (robots(RobotEntry(start=(x, y, 0.0))), ConfigError, "starts outside of the field")
        for x, y in ((-1.0, 2.0), (length + 1.0, 2.0), (2.0, width + 3.0))
    )
    yield from (
        (lambda: Match(game, practice="no"), ConfigError, "practice must be True or False, got 'no'"),
        (lambda: Match(game, sinks=[5]), ConfigError, "sinks must be TelemetrySinks, with due, write and close, got 5"),
        (lambda: Match(game, engine=5), ConfigError, "engine must be None, 'bullet' or 'mujoco', or an Engine, got 5"),
        (lambda: Match(game, options=("no such option",)), UnknownNameError, f"option of {game.name}"),
        (lambda: Match(game, controllers=[None, None]), ConfigError, "2 controllers for 1 robots"),
        (lambda: Match(game, field_mesh="none.obj"), FieldMeshError, "none.obj"),
        (lambda: play_auto(game, auto[:-1] + "x"), UnknownNameError, f"Did you mean '{auto}'"),
        (robots(RobotEntry(start=INSIDE[game.name])), ConfigError, "starts inside of a field element"),
        (robots(RobotEntry(start=start), RobotEntry(start=start)), ConfigError, "starts inside of robot 0"),
        (robots(*many), ConfigError, f"at most {game.robots} robots, got {game.robots + 1}"),
        (robots(RobotEntry(preload=game.preload + 1)), ConfigError, f"preload must be 0..{game.preload}"),
    )
    if len(game.starts) < game.robots:
        yield robots(*alike), ConfigError, f"{len(game.starts)} starts per alliance"
    if game.preload > 1:
        yield robots(RobotEntry(preload=2, config=small)), ConfigError, "holds 1 pieces, got a preload of 2"
    for name in [option.name for option in game.options]:
        yield lambda near=name[:-1]: Match(game, options=(near,)), UnknownNameError, f"Did you mean '{name}'"


def test_invalid_matches_are_refused_at_construction(game):
    for call, error, said in of_game(game):
        with pytest.raises(error, match=re.escape(said)):
            call()
    small = replace(game.robot(), storage=replace(game.robot().storage, capacity=1))
    with Match(game, robots=(RobotEntry(config=small),)) as match:
        assert match.count.held == 1 and match.count.is_conserved, "with no number given it takes what fits"


def of_match(match):
    """Yield calls that a running match refuses, with error and message."""
    yield from (
        (lambda: match.reset(seed=-1), ConfigError, "seed must be"),
        (lambda: match.reset(sinks=[5]), ConfigError, "sinks must be"),
        (lambda: match.set_controller(1, None), ConfigError, "there are robots 0 to 0, got 1"),
        (lambda: match.carry_to(0, (100.0, 50.0, 0.0)), ConfigError, "outside of the field"),
        (lambda: match.carry_to(0, INSIDE[match.game.name]), ConfigError, r"inside of a field element.* m is free"),
        (lambda: match.carry_to(0, (2.0, math.nan, 0.0)), ConfigError, r"pose\[1\] must be a number"),
        (lambda: match.carry_to(0, None), ConfigError, "pose must be 3 numbers"),
        (lambda: match.carry_to(1, (2.0, 2.0, 0.0)), ConfigError, "there are robots 0 to 0, got 1"),
        (lambda: match.robots[0].reset((1e6, 0.0, 0.0)), ConfigError, r"pose\[0\] must be a number from -100 to 100 m"),
    )


def test_a_refused_call_leaves_the_match_unchanged(game):
    sink = MemorySink()
    with Match(game, robots=(RobotEntry(preload=0),), sinks=[sink]) as match:
        match.tick()
        before = match.robots[0].chassis.pose
        for call, error, said in of_match(match):
            with pytest.raises(error, match=said):
                call()
        assert match.robots[0].chassis.pose == before
        match.tick()
        assert match.ticks == 2 and match.sinks == [sink]


def test_the_start_of_a_red_robot_is_checked_on_the_red_side(game):
    """The entry gives the start for blue, so the message has both poses."""
    x, y, _ = INSIDE[game.name]
    with pytest.raises(ConfigError) as caught:
        Match(game, robots=(RobotEntry(alliance="red", start=INSIDE[game.name]),))
    said, there = str(caught.value), game.field.symmetry.flip_point(x, y)
    assert (
        f"starts inside of a field element, at ({there[0]:.2f}, {there[1]:.2f}) m, as blue ({x:.2f}, {y:.2f}) m" in said
    )
    *_, as_blue = re.findall(r"as blue \(([-.\d]+), ([-.\d]+)\) m is free", said)
    Match(game, robots=(RobotEntry(alliance="red", start=(float(as_blue[0]), float(as_blue[1]), 0.0)),)).close()


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: RobotEntry(alliance="green"), "alliance must be 'blue' or 'red'"),
        (lambda: RobotEntry(start=(1.0, math.nan, 0.0)), "start[1] must be a number from -100 to 100 m, got nan"),
        (lambda: RobotEntry(start=(1.0, 2.0)), "start must be 3 numbers (m, m, rad), got (1.0, 2.0)"),
        (lambda: RobotEntry(preload=-1), "preload must be a whole number"),
        (lambda: RobotEntry(preload=1.5), "preload must be a whole number"),
        (lambda: replace(CRATES, name="my game"), "letters, digits"),
        (lambda: replace(CRATES, starts=()), "starts must have at least one place"),
        (lambda: replace(CRATES, pieces=CRATES.pieces[:1] * 2), "kinds of pieces must differ"),
        (lambda: replace(CRATES.field, elements=()), "either a mesh or elements"),
        (lambda: replace(CRATES.field, size=(10.0, 6.0)), "symmetry is for a field of"),
    ],
)
def test_invalid_entries_and_games_are_refused(make, said):
    with pytest.raises(ConfigError, match=re.escape(said)):
        make()


def test_an_error_in_a_script_propagates_and_closes_the_sinks_and_the_world():
    def script(robot):
        yield from robot.wait(0.1)
        raise RuntimeError("student bug")

    sink, seen = MemorySink(), []
    auto = Auto(name="bug", summary="", start=CRATES.starts[0], controller=lambda m, a: ScriptedRobot(script, m, a))
    with pytest.raises(RuntimeError, match="student bug"):
        play_auto(CRATES, auto, seconds=1.0, sinks=[sink], on_tick=seen.append)
    assert len(sink.snapshots) == 5, "the log goes up to the bug"
    assert sink.closed
    with pytest.raises(EngineError, match="closed"):
        seen[0].world.step(0.02)


def test_a_sink_that_fails_to_close_does_not_keep_other_sinks_and_the_match_open():
    class Full(MemorySink):
        def close(self):
            raise OSError("disk full")

    other = MemorySink()
    match = Match(CRATES, sinks=[Full(), other])
    with pytest.raises(OSError, match="disk full"):
        match.close()
    assert other.closed
    with pytest.raises(EngineError, match="closed"):
        match.tick()
