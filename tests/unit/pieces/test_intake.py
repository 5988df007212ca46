"""Which pieces the intake takes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simcore.errors import ConfigError
from simcore.pieces.intake import IntakeZone, field_to_robot

REAR = dict(x_min=-0.50, x_max=-0.35, y_min=-0.25, y_max=0.25, z_max=0.20)
ZONE = IntakeZone(**REAR)


def points(*rows):
    return np.array(rows, dtype=np.float64)


def test_center_inside_the_box_counts():
    pos = points([-0.4, 0, 0.075], [-0.34, 0, 0.075], [-0.4, 0.26, 0.075], [-0.4, 0, 0.21], [-0.5, 0.25, 0.2])
    assert ZONE.contains(pos).tolist() == [True, False, False, False, True]


def test_a_piece_that_went_through_within_a_tick_is_caught():
    """At 20 m/s a piece moves 0.4 m a tick, the zone is 0.15 m deep."""
    prev = points([-0.7, 0, 0.1], [-0.7, 0, 0.1], [-0.7, 0.4, 0.1], [-0.7, 0, 0.1])
    now = points([-0.3, 0, 0.1], [-0.55, 0, 0.1], [-0.3, 0.3, 0.1], [-0.3, 0, 0.6])
    assert ZONE.captured(prev, now).tolist() == [True, False, False, False]


def test_a_resting_piece_is_taken_without_a_warning():
    at = points([-0.4, 0, 0.075], [-0.35, 0.25, 0.2], [0, 0, 0])
    with np.errstate(all="raise"):
        assert ZONE.captured(at, at).tolist() == [True, True, False]


def test_an_intake_that_is_off_takes_nothing():
    off = IntakeZone(**REAR, active=lambda: False)
    at = points([-0.4, 0, 0.075])
    assert off.contains(at).tolist() == [True]
    assert off.captured(at, at).tolist() == [False]


def test_nan_is_never_taken():
    bad, good = points([math.nan, 0, 0.1]), points([-0.4, 0, 0.1])
    assert ZONE.contains(bad).tolist() == [False]
    assert ZONE.captured(bad, good).tolist() == ZONE.captured(good, bad).tolist() == [False]


def test_no_pieces_is_no_problem():
    assert ZONE.captured(np.zeros((0, 3)), np.zeros((0, 3))).shape == (0,)


def test_field_positions_are_seen_from_the_robot():
    """A robot at (5, 2), turned left by 90 degrees, has its rear intake towards smaller y."""
    robot, rotation = np.array([5.0, 2.0, 0.1]), np.array([0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)])
    seen = field_to_robot(points([5.0, 1.6, 0.175], [5.4, 2.0, 0.175]), robot, rotation)
    assert seen == pytest.approx(points([-0.4, 0.0, 0.075], [0.0, -0.4, 0.075]))
    assert ZONE.contains(seen).tolist() == [True, False]


def test_a_pitched_robot_takes_its_zone_along():
    """Nose up by 90 degrees (-90 about +y): what is under the robot's tail in the field is behind it."""
    half = -math.pi / 4
    rotation = np.array([0.0, math.sin(half), 0.0, math.cos(half)])
    assert field_to_robot(points([0.0, 0.0, -0.4]), np.zeros(3), rotation) == pytest.approx(points([-0.4, 0.0, 0.0]))


@pytest.mark.parametrize("change", [{"x_min": 0.0}, {"y_max": math.nan}, {"z_max": -0.2}, {"z_min": math.inf}])
def test_boxes_that_cannot_be_are_refused(change):
    with pytest.raises(ConfigError, match=next(iter(change))[0]):
        IntakeZone(**{**REAR, **change})


def test_a_quaternion_must_be_one():
    with pytest.raises(ConfigError, match="quaternion"):
        field_to_robot(points([0, 0, 0]), np.zeros(3), np.zeros(4))
