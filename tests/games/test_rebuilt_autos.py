"""Scripted autos on the field of REBUILT: scores, and limits on robots and fuel."""

from __future__ import annotations

import numpy as np
import pytest
from game_table import play

from games.rebuilt.dimensions import (
    BUMP_DEPTH,
    BUMP_HEIGHT,
    BUMP_WIDTH,
    FIELD_WIDTH,
    HUB_CENTER,
    TRENCH_ARM_DEPTH,
    TRENCH_CLEAR_HEIGHT,
    TRENCH_CLEAR_WIDTH,
)

AUTOS = ["depot", "neutral", "tour"]


@pytest.fixture(scope="module")
def played(engine_name):
    """Return a run of each auto, by name."""
    return {auto: play("rebuilt", auto) for auto in AUTOS}


def test_the_depot_auto_scores_at_least_twenty_of_its_thirty_two_fuel(played):
    report = played["depot"].run.report
    assert 20 <= report.score.blue <= 32
    assert report.pieces.staged == 504
    assert report.score.red == 0
    assert report.hits == report.pieces.scored == report.score.blue <= report.shots
    assert report.sim_seconds == 20.0 and report.ticks == 1000


def test_the_neutral_auto_scores_more_fuel_than_its_preload(played):
    one = played["neutral"]
    x = [pose[0] for pose in one.poses]
    assert max(x) > HUB_CENTER[0] + 2.0, "it was in the neutral zone"
    assert x[-1] < HUB_CENTER[0] - 1.0, "and is back"
    assert one.run.report.score.blue > 20, "8 of its own and more"


def test_the_tour_auto_climbs_the_bump_and_comes_down(played):
    one = played["tour"]
    poses = np.array(one.poses)
    on_bump = (np.abs(poses[:, 0] - HUB_CENTER[0]) < BUMP_DEPTH / 2) & (
        np.abs(poses[:, 1] - FIELD_WIDTH / 2) < 0.6 + BUMP_WIDTH
    )
    assert poses[on_bump, 2].max() > 0.6 * BUMP_HEIGHT, "it really rises"
    assert abs(poses[-1, 2]) < 0.005, "and stands on the carpet at the end"


def test_the_tour_auto_passes_under_the_trench_arm(played):
    one = played["tour"]
    poses = np.array(one.poses)
    config = one.run.match.robots[0].chassis.config
    assert config.height < TRENCH_CLEAR_HEIGHT
    in_lane = poses[:, 1] > FIELD_WIDTH - TRENCH_CLEAR_WIDTH + config.bumper_width / 2
    under = in_lane & (np.abs(poses[:, 0] - HUB_CENTER[0]) < TRENCH_ARM_DEPTH)
    assert under.any(), "it is under the arm"
    assert (poses[under, 2] + config.height < TRENCH_CLEAR_HEIGHT).all()
    before, after = poses[: int(np.argmax(under))], poses[len(poses) - int(np.argmax(under[::-1])) :]
    assert before[-1, 0] > HUB_CENTER[0] > after[0, 0], "from the neutral side to its own"
