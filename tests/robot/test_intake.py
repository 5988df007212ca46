"""Pieces that an intake takes."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from each_case import each

from simcore.errors import ConfigError, UnknownNameError
from simcore.robot.intake import Intake, IntakeConfig, IntakeZone, field_to_robot
from simcore.world.linkage import Joint

REAR = dict(x_min=-0.50, x_max=-0.35, y_min=-0.25, y_max=0.25, z_max=0.20)
ZONE = IntakeZone(**REAR)


def points(*rows):
    return np.array(rows, dtype=np.float64)


def test_a_piece_is_in_the_intake_zone_if_its_center_is_inside_the_box():
    pos = points([-0.4, 0, 0.075], [-0.34, 0, 0.075], [-0.4, 0.26, 0.075], [-0.4, 0, 0.21], [-0.5, 0.25, 0.2])
    assert ZONE.contains(pos).tolist() == [True, False, False, False, True]


def test_a_piece_that_passes_through_the_zone_within_a_tick_is_caught():
    """At 20 m/s, a piece moves 0.4 m in a tick; the zone is 0.15 m deep."""
    prev = points([-0.7, 0, 0.1], [-0.7, 0, 0.1], [-0.7, 0.4, 0.1], [-0.7, 0, 0.1])
    now = points([-0.3, 0, 0.1], [-0.55, 0, 0.1], [-0.3, 0.3, 0.1], [-0.3, 0, 0.6])
    assert ZONE.captured(prev, now).tolist() == [True, False, False, False]


def test_a_resting_piece_is_taken_without_a_numpy_warning():
    at = points([-0.4, 0, 0.075], [-0.35, 0.25, 0.2], [0, 0, 0])
    with np.errstate(all="raise"):
        assert ZONE.captured(at, at).tolist() == [True, True, False]


def mechanism(position=0.0, velocity=0.0, stops=(0.0, 10.0)):
    return SimpleNamespace(position=position, velocity=velocity, stops=stops)


def test_an_intake_takes_pieces_while_deployed_with_its_roller_turning_inward():
    roller, slide = mechanism(), mechanism()
    config = IntakeConfig(zone=ZONE, roller="roller", deploy="slide")
    intake = Intake(config, {"roller": roller, "slide": slide})
    at = points([-0.4, 0, 0.075])
    for velocity, position, takes in ((0, 10, False), (20, 7.9, False), (20, 8.1, True), (-20, 10, False)):
        roller.velocity, slide.position = velocity, position
        assert intake.is_active is takes
        assert intake.captured(at, at).tolist() == [takes]


def test_an_intake_can_be_deployed_at_its_lower_stop():
    arm = mechanism(position=10.0)
    intake = Intake(IntakeConfig(zone=ZONE, deploy="arm", deployed_at="lower"), {"arm": arm})
    assert not intake.is_active
    arm.position = 1.9
    assert intake.is_active


def test_a_stretched_zone_covers_the_travel_of_its_slide():
    slide = mechanism()
    stretch = Joint(mechanism="slide", axis=(-1.0, 0.0, 0.0), slides=True, ratio=0.02)
    intake = Intake(IntakeConfig(zone=ZONE, stretch=stretch), {"slide": slide})
    beyond = points([-0.6, 0, 0.075])
    assert intake.captured(beyond, beyond).tolist() == [False]
    slide.position = 10.0
    assert (intake.zone.x_min, intake.zone.x_max) == pytest.approx((-0.7, -0.35))
    assert intake.captured(beyond, beyond).tolist() == [True]
    before, now, radius = intake.around
    assert before == now == pytest.approx((-0.525, 0.0, 0.5 * (ZONE.z_min + ZONE.z_max)))
    assert radius >= math.hypot(0.175, ZONE.y_max)


def test_a_zone_on_a_part_sweeps_with_the_part():
    """An arm swings the zone past a resting piece within one tick."""
    arm = mechanism()
    zone = IntakeZone(x_min=0.4, x_max=0.6, y_min=-0.2, y_max=0.2, z_min=-0.05, z_max=0.05)
    joint = Joint(mechanism="arm", axis=(0.0, -1.0, 0.0), origin=(0.0, 0.0, 0.5))
    intake = Intake(IntakeConfig(zone=zone, joints=(joint,)), {"arm": arm})
    at = points([0.5, 0.0, 0.5])
    for angle, takes in ((0.5, False), (0.4, False), (-0.4, True), (-0.5, False)):
        arm.position = angle
        assert intake.captured(at, at).tolist() == [takes], angle
    arm.position = 0.0
    assert intake.captured(at, at).tolist() == [True]


def test_an_invalid_intake_is_refused():
    with pytest.raises(UnknownNameError, match="for an intake"):
        Intake(IntakeConfig(zone=ZONE, roller="rollr"), {"roller": mechanism()})
    with pytest.raises(ConfigError, match="deploy must have stops"):
        Intake(IntakeConfig(zone=ZONE, deploy="x"), {"x": mechanism(stops=(-math.inf, math.inf))})
    with pytest.raises(ConfigError, match="stretch must be a joint that slides"):
        IntakeConfig(zone=ZONE, stretch=Joint(mechanism="x", axis=(1.0, 0.0, 0.0)))


def test_a_piece_at_nan_is_never_taken():
    bad, good = points([math.nan, 0, 0.1]), points([-0.4, 0, 0.1])
    assert ZONE.contains(bad).tolist() == [False]
    assert ZONE.captured(bad, good).tolist() == ZONE.captured(good, bad).tolist() == [False]


@each("change", [{"x_min": 0.0}, {"y_max": math.nan}, {"z_max": -0.2}, {"z_min": math.inf}])
def test_an_invalid_intake_zone_is_refused(change):
    with pytest.raises(ConfigError, match=next(iter(change))[0]):
        IntakeZone(**{**REAR, **change})


def test_a_rotation_must_be_a_unit_quaternion():
    with pytest.raises(ConfigError, match="quaternion"):
        field_to_robot(points([0, 0, 0]), np.zeros(3), np.zeros(4))
