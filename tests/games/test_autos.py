"""The scripted autos on the real field: what they score, and what no robot and no fuel may do meanwhile."""

from __future__ import annotations

import math

import numpy as np
import pytest

from games.rebuilt.dimensions import (
    BUMP_DEPTH,
    BUMP_HEIGHT,
    BUMP_WIDTH,
    FIELD_LENGTH,
    FIELD_WIDTH,
    HUB_CENTER,
    TRENCH_ARM_DEPTH,
    TRENCH_CLEAR_HEIGHT,
    TRENCH_CLEAR_WIDTH,
)
from games.rebuilt.fuel import FUEL
from simcore.geometry.symmetry import turn_half_pose
from simcore.pieces.pool import PieceStatus

AUTOS = ["depot", "neutral", "tour"]
SIZE = (FIELD_LENGTH, FIELD_WIDTH)


@pytest.fixture(params=AUTOS)
def run(request, played):
    return played[request.param, "blue"]


def test_the_depot_auto_scores_at_least_twenty_of_its_thirty_two(played):
    report = played["depot", "blue"].run.report
    assert 20 <= report.score.blue <= 32
    assert report.score.red == 0
    assert report.hits == report.fuel.scored == report.score.blue <= report.shots
    assert report.sim_seconds == 20.0 and report.ticks == 1000


def test_the_neutral_auto_comes_back_with_more_than_it_took_along(played):
    one = played["neutral", "blue"]
    x = [pose[0] for pose in one.poses]
    assert max(x) > HUB_CENTER[0] + 2.0, "it was in the neutral zone"
    assert x[-1] < HUB_CENTER[0] - 1.0, "and is back"
    assert one.run.report.score.blue > 20, "8 of its own and more"


def test_fuel_is_conserved_at_every_tick(run):
    assert run.lost == []
    assert run.run.report.fuel.staged == 504


def test_the_tracker_the_pieces_and_the_shots_tell_one_story(run):
    sim, report = run.run.sim, run.run.report
    assert report.fuel.scored == sum(sim.tracker.pieces.values()) == len(sim.tracker.events)
    assert report.hits <= report.shots == len(sim.shots)
    taken = len(sim.intakes)
    preload = 0 if report.auto == "tour" else 8
    assert report.fuel.held == preload + taken - report.shots
    assert max(run.held) <= sim.robots[0].config.hopper_capacity


def test_no_fuel_sinks_below_the_carpet(run):
    assert run.lowest > 0.5 * FUEL.bounding_radius, "a robot presses it into the carpet for a moment, no deeper"


def test_no_fuel_leaves_the_field_or_has_to_be_brought_back(run):
    assert run.run.sim.pieces.recovered == 0


def test_sleeping_fuel_lies_where_it_is_said_to_lie(run):
    """A sleeper that the engine woke by touch once fell through the floor, unseen, after its chunk fell quiet."""
    assert run.ghosts < 0.003


def test_the_robot_stays_on_the_floor_and_upright(run):
    roll, pitch, z = np.array(run.floor).T
    assert z.min() > -0.01, "it does not sink"
    assert z.max() < BUMP_HEIGHT + 0.05, "it does not fly or climb"
    assert math.degrees(max(np.abs(roll).max(), np.abs(pitch).max())) < 30.0
    if run.run.report.auto == "depot":
        assert z.max() < 0.04, "only over the depot's barrier"


def test_the_robot_stays_inside_the_field(run):
    poses = np.array(run.poses)
    half = run.run.sim.robots[0].chassis.config.bumper_length / 2
    assert poses[:, 0].min() > half - 0.02 and poses[:, 1].max() < FIELD_WIDTH - half + 0.02


def test_the_battery_sags_but_never_browns_out_for_good(run):
    assert 6.3 < run.run.report.min_battery_v < 12.5


def test_the_tour_climbs_the_bump_and_comes_down(played):
    one = played["tour", "blue"]
    poses = np.array(one.poses)
    on_bump = (np.abs(poses[:, 0] - HUB_CENTER[0]) < BUMP_DEPTH / 2) & (
        np.abs(poses[:, 1] - FIELD_WIDTH / 2) < 0.6 + BUMP_WIDTH
    )
    assert poses[on_bump, 2].max() > 0.6 * BUMP_HEIGHT, "it really rises"
    assert abs(poses[-1, 2]) < 0.005, "and stands on the carpet at the end"


def test_the_tour_passes_under_the_arm_of_the_trench(played):
    one = played["tour", "blue"]
    poses = np.array(one.poses)
    config = one.run.sim.robots[0].chassis.config
    assert config.height < TRENCH_CLEAR_HEIGHT
    in_lane = poses[:, 1] > FIELD_WIDTH - TRENCH_CLEAR_WIDTH + config.bumper_width / 2
    under = in_lane & (np.abs(poses[:, 0] - HUB_CENTER[0]) < TRENCH_ARM_DEPTH)
    assert under.any(), "it is under the arm"
    assert (poses[under, 2] + config.height < TRENCH_CLEAR_HEIGHT).all()
    before, after = poses[: int(np.argmax(under))], poses[len(poses) - int(np.argmax(under[::-1])) :]
    assert before[-1, 0] > HUB_CENTER[0] > after[0, 0], "from the neutral side to its own"


@pytest.mark.parametrize("name", AUTOS)
def test_red_scores_what_blue_scores(played, name):
    """Red is blue turned by 180 degrees."""
    blue, red = played[name, "blue"].run.report, played[name, "red"].run.report
    assert red.score.blue == blue.score.red == 0
    assert red.shots == pytest.approx(blue.shots, abs=4 if name == "neutral" else 0)
    assert red.score.red == pytest.approx(blue.score.blue, abs=4 if name == "neutral" else 0)
    assert red.fuel.is_conserved


@pytest.mark.parametrize("name", ["depot", "tour"])
def test_a_red_robot_drives_the_turned_path(played, name):
    """Only rounding differs, which the fuel that is pushed around makes larger in time."""
    blue, red = played[name, "blue"].run, played[name, "red"].run
    turned = np.array([turn_half_pose(*pose, SIZE) for pose in red.path])
    apart = np.linalg.norm(turned[:, :2] - blue.path[:, :2], axis=1)
    assert apart[:150].max() < 1e-6
    assert apart[: 1000 if name == "tour" else 150].max() < 0.1  # then the depot robot chases the nearest fuel


def test_the_red_match_is_staged_as_the_blue_one_turned(played):
    blue, red = played["tour", "blue"].run.fuel_at_start, played["tour", "red"].run.fuel_at_start
    turned = np.array(SIZE) - red[:, :2]
    assert np.sort(turned, axis=0) == pytest.approx(np.sort(blue[:, :2], axis=0), abs=1e-9)


def test_what_nobody_touched_still_lies_where_it_was_staged(played):
    run = played["tour", "blue"].run
    state = run.sim.pieces.state
    on_field = run.sim.pieces.on_field()
    assert (state.status[on_field] == PieceStatus.ASLEEP).all()
    moved = np.linalg.norm(state.pos[on_field] - run.fuel_at_start, axis=1)
    assert (moved < 1e-9).sum() > 350
