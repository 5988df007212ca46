"""Laws of scripted autos in every game: conserved pieces, limits of robots, and equal results for red and blue."""

from __future__ import annotations

import math

import numpy as np
import pytest
from game_table import GAMES

from simcore.pieces.pool import PieceStatus


def test_an_auto_conserves_pieces_at_every_tick(run):
    assert run.lost == []


def test_the_counts_of_pieces_shots_and_scores_in_an_auto_are_consistent(run):
    match, report = run.run.match, run.run.report
    assert report.pieces.scored == sum(match.tracker.pieces.values()) == len(match.tracker.events)
    assert report.score.blue == match.tracker.totals["blue"] > 0 or report.auto == "tour"
    assert report.score.red == 0
    assert report.hits <= report.shots == len(match.record.shots)
    preload = run.auto.preload if run.auto.preload is not None else match.game.preload
    assert report.pieces.held == preload + len(match.record.taken_in) - report.shots - match.record.put_down
    room = match.robots[0].config.storage.capacity + len(match.robots[0].placers)
    assert max(run.held) <= room
    assert report.ticks == round(report.sim_seconds / 0.02) == len(run.poses)


def test_no_piece_center_sinks_below_the_carpet_during_an_auto(run):
    rest = min(kind.rest_height for kind in run.run.match.pieces.types)
    assert run.sunk > -rest, "a robot that rolls over it squeezes it for a moment; its middle stays above the carpet"


def test_no_piece_leaves_the_field_during_an_auto(run):
    assert run.run.match.pieces.recovered == 0


def test_a_sleeping_piece_lies_at_its_reported_position(run):
    """A sleeping piece that the engine woke once fell through the floor unseen.

    Sleeping pieces are checked every 2 s, and a heap under pressure creeps by up to 4 mm/s.
    """
    assert run.ghosts < 0.010


def test_a_robot_in_auto_stays_upright_and_inside_the_field(run):
    poses, tilt = np.array(run.poses), np.array(run.roll_pitch)
    assert poses[:, 2].min() > -0.01, "it does not sink"
    assert math.degrees(np.abs(tilt).max()) < 30.0
    length, width = run.run.match.game.field.size
    chassis = run.run.match.robots[0].chassis.config
    half = min(chassis.bumper_length, chassis.bumper_width) / 2
    assert poses[:, 0].min() > half - 0.02 and poses[:, 0].max() < length - half + 0.02
    assert poses[:, 1].min() > half - 0.02 and poses[:, 1].max() < width - half + 0.02


def test_the_battery_sags_in_auto_but_does_not_brown_out(run):
    assert 6.3 < run.run.report.min_battery_v < 12.5


def test_untouched_pieces_lie_where_they_were_staged(run):
    match = run.run.match
    on_field = match.pieces.on_field()
    asleep = on_field[match.pieces.state.status[on_field] == PieceStatus.ASLEEP]
    places = match.pieces.state.pos[asleep]
    nearest = np.linalg.norm(places[:, None] - run.run.pieces_at_start[None], axis=2).min(axis=1)
    assert (nearest < 1e-3).sum() >= 0.2 * len(run.run.pieces_at_start)


# --- red and blue under the field's symmetry --------------------------------------------------------------------------


def test_a_red_robot_scores_as_much_as_a_blue_robot(runs):
    blue, red = runs["blue"].run.report, runs["red"].run.report
    assert red.score.blue == blue.score.red == 0
    assert red.shots == pytest.approx(blue.shots, abs=4 if runs.auto == "neutral" else 0)
    assert red.score.red == pytest.approx(blue.score.blue, abs=4 if runs.auto == "neutral" else 0)


def test_a_red_robot_drives_the_flipped_path_of_a_blue_robot(runs):
    """The paths are equal until the robot meets a piece; a pushed heap amplifies any difference.

    On a rotated field only rounding differs, in the engine's contacts of robot and carpet. On a mirrored field the
    robot's left and right wheels also change places.
    """
    blue, red = runs["blue"], runs["red"]
    symmetry = GAMES[runs.name].field.symmetry
    flipped = np.array([symmetry.flip_pose(*pose) for pose in red.run.path])
    apart = np.linalg.norm(flipped[:, :2] - blue.run.path[:, :2], axis=1)
    turned = np.abs(np.remainder(flipped[:, 2] - blue.run.path[:, 2] + math.pi, math.tau) - math.pi)
    alone = min(blue.touched or len(apart), red.touched or len(apart)) - 1
    assert alone >= 50
    tolerance = 1e-5 if symmetry.keeps_hands else 1e-4
    assert apart[:alone].max() < tolerance and turned[:alone].max() < tolerance
    assert apart[-1] < 0.1, "both end at one place"


def test_pieces_of_a_red_match_are_staged_at_the_flipped_positions(runs):
    blue, red = (runs[alliance].run.pieces_at_start for alliance in ("blue", "red"))
    flipped = GAMES[runs.name].field.symmetry.flip_points(red)
    assert flipped == pytest.approx(blue, abs=1e-9)


def test_a_red_shot_flies_along_the_flipped_path_of_a_blue_shot(runs):
    """The first shot, before any contact, has mirrored aim, muzzle, speed and spin."""
    shots = [runs[alliance].run.match.record.shots for alliance in ("blue", "red")]
    if not shots[0] or shots[0][0].time > 0.02 * (runs["blue"].touched or math.inf):
        pytest.skip("no shot before it meets a piece")
    blue, red = shots[0][0], shots[1][0]
    assert blue.time == red.time
    flipped = GAMES[runs.name].field.symmetry.flip_points(np.array(red.points))
    n = min(len(flipped), len(blue.points), 25)
    apart = np.linalg.norm(flipped[:n] - np.array(blue.points)[:n], axis=1)
    if GAMES[runs.name].field.symmetry.keeps_hands:
        assert apart.max() < 1e-5
    else:
        (shooter,) = runs["blue"].run.match.robots[0].shooters
        assert shooter.config.launch.barrels == (0.0,), "a robot is not mirrored itself; this one is its own image"
        assert apart.max() < 1e-5
