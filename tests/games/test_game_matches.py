"""Matches of every game: conserved pieces, no tunnelling, split ticks, several robots."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from game_table import GAMES, play
from scipy.spatial import ConvexHull

from simcore.match.game import Game, RobotEntry
from simcore.match.match import Match
from simcore.pieces.pool import PieceStatus
from simcore.world.shapes import outline_points


def walls(match: Match) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Yield name, normals and offsets of the faces of each element: inside means normals @ p + offsets < 0."""
    for element in match.field.elements:
        planes = ConvexHull(outline_points(element.shape) + element.position).equations
        yield element.name, planes[:, :3], planes[:, 3]


# --- pieces ---------------------------------------------------------------------------------------------------------


def test_a_match_with_every_option_conserves_pieces_through_resets(game, whole):
    """A robot at each start plays an auto, with every option that returns pieces.

    Matches are short unless `--whole` is given.
    """
    autos = list(game.autos.values())
    places = game.starts[: min(len(game.starts), game.robots // 2)]
    entries = [RobotEntry(alliance=a, start=start) for a in ("blue", "red") for start in places]
    options = [option.name for option in game.options]
    with Match(game, robots=entries, seed=1, options=options) as match:
        for number, entry in enumerate(entries):
            match.set_controller(number, autos[number % len(autos)].controller(match, entry.alliance))
        for ticks in (300, 300) if whole else (120, 60):
            total = match.count.staged
            assert total == sum(supply.count for supply in game.pieces)
            for tick in range(ticks):
                if tick == ticks * 2 // 3:
                    match.start_mode("teleop")
                match.tick()
                count = match.count
                assert count.is_conserved and count.staged == total, match.ticks
            held = [slot for robot in match.robots for slot in robot.held]
            assert len(held) == len(set(held)) == count.held
            assert (match.pieces.state.status[held] == PieceStatus.HELD).all()
            match.reset()


@pytest.mark.parametrize(("name", "speed"), [(name, speed) for name in GAMES for speed in (10.0, 25.0)])
def test_no_piece_tunnels_through_an_element(name, speed):
    """Every third piece on the field is launched along the carpet at once; none enters or passes a wall."""
    game = GAMES[name]
    with Match(game, robots=(RobotEntry(preload=0),), seed=2) as match:
        slots = match.pieces.on_field()[::3]
        angle = np.random.default_rng(3).uniform(0.0, math.tau, len(slots))
        match.pieces.push(slots, speed * np.column_stack((np.cos(angle), np.sin(angle), np.zeros(len(slots)))))
        solid = list(walls(match))
        length, width = game.field.size
        were_out = np.zeros(0, dtype=np.int64)
        for _ in range(60):
            match.tick()
            slots = match.pieces.on_field()
            pos = match.pieces.state.pos[slots]
            for element, normals, offsets in solid:
                deep = -(pos @ normals.T + offsets).max(axis=1).min()
                assert deep < 0.02, f"a center is {1e3 * deep:.0f} mm inside of {element}"
            out = (pos[:, :2] < 0.0).any(axis=1) | (pos[:, 0] > length) | (pos[:, 1] > width)
            crossed = out & ~np.isin(slots, were_out)
            assert (pos[crossed, 2] > 0.4).all(), "what is beyond a wall went over it"
            were_out = slots[out]
            assert match.count.is_conserved


# --- split ticks ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "auto", "seconds"), [("rebuilt", "depot", 4.0), ("crates", "crate", 10.0), ("crates", "balls", 10.0)]
)
def test_an_auto_scores_the_same_with_each_tick_split_into_four_parts(name, auto, seconds):
    scores = []
    chosen = GAMES[name].auto(auto)
    for parts in (1, 4):
        with Match(GAMES[name], robots=(RobotEntry(start=chosen.start, preload=chosen.preload),)) as match:
            match.set_controller(0, chosen.controller(match, "blue"))
            for _ in range(round(seconds / 0.02)):
                match.tick(parts)
            scores.append(match.score.blue)
    assert scores[0] == scores[1] > 0


# --- robots ---------------------------------------------------------------------------------------------------------


def test_two_robots_playing_together_each_score_as_much_as_alone(game):
    """Blue and red play at opposite ends, and each scores for its alliance as many points as a robot alone."""
    auto = game.auto()
    entries = [RobotEntry(alliance=a, start=auto.start, preload=auto.preload) for a in ("blue", "red")]
    alone = play(game.name, auto.name).run.report
    with Match(game, robots=entries) as match:
        for number, entry in enumerate(entries):
            match.set_controller(number, auto.controller(match, entry.alliance))
        match.play(alone.sim_seconds)
        assert match.count.is_conserved
        for alliance in ("blue", "red"):
            assert match.tracker.totals[alliance] == pytest.approx(alone.score.blue, abs=6 if game.year == 2026 else 0)
        assert {shot.robot for shot in match.record.shots} <= {0, 1}


def test_gyro_noise_does_not_depend_on_other_robots(game):
    starts = game.starts[:2]
    noise = []
    for count in (1, 2):
        with Match(game, robots=[RobotEntry(start=start, preload=0) for start in starts[:count]]) as match:
            match.play(1.0)
            noise.append([robot.gyro.rates.tolist() for robot in match.robots])
    # More bodies in the world change the engine's arithmetic by 1e-8; the noise is some 1e-3.
    assert np.array(noise[1][:1]) == pytest.approx(np.array(noise[0]), abs=1e-6)
    assert np.abs(np.diff(noise[1], axis=0)).max() > 1e-4, "each robot has its own"


def test_set_alliance_moves_a_robot_to_the_other_side_and_keeps_its_gyro_reading(game: Game):
    """The gyro continues from its reading, as when a team carries the robot."""
    with Match(game, robots=(RobotEntry(preload=0),), seed=1) as match:
        robot = match.robots[0]
        match.play(0.4, controllers=[lambda robot, time: robot.drive.set_chassis_speeds(0.5, 0.0, 0.5)])
        before = robot.gyro.yaw
        match.set_controller(0, lambda robot, time: robot.drive.set_chassis_speeds(0.0, 0.0, 0.0))
        match.set_alliance(0, "red")
        assert robot.chassis.pose == pytest.approx(game.field.symmetry.flip_pose(*game.starts[0]), abs=1e-6)
        assert robot.gyro.yaw == before
        assert robot.odometry.pose == pytest.approx(robot.chassis.pose, abs=1e-6)
        match.play(0.5)
        assert robot.gyro.yaw == pytest.approx(before, abs=0.05)
        assert match.alliances == ["red"]


def test_a_robot_without_commands_stays_at_rest(game):
    with Match(game, robots=(RobotEntry(preload=0),)) as match:
        start = match.robots[0].chassis.pose[:2]
        match.play(0.6)
        assert match.robots[0].chassis.pose[:2] == pytest.approx(start, abs=2e-3)
        assert len(match.pieces.awake) == 0 and match.score.total == 0


def test_errors_in_robot_code_propagate_unchanged(game):
    error = RuntimeError("our bug")

    def code(robot, now):
        raise error

    with Match(game, controllers=[code]) as match, pytest.raises(RuntimeError) as caught:
        match.tick()
    assert caught.value is error
