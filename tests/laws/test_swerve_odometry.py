"""Odometry integrates arcs: the closed form of a circle."""

import math

import pytest
from each_case import each

from simcore.robot.robot import SwerveOdometry

pytestmark = pytest.mark.engines("bullet")

SQUARE = ((0.3, 0.25), (0.3, -0.25), (-0.3, 0.25), (-0.3, -0.25))


@each("turn", [math.pi / 2.0, -math.pi / 2.0, 0.3])
def test_odometry_of_one_long_sample_ends_on_the_circle(turn):
    """A chord along the heading at the start or end of the sample would be off by the radius."""
    radius = 2.0
    ways = [(radius * abs(turn) - turn * y, turn * x) for x, y in SQUARE]
    odometry = SwerveOdometry(SQUARE)
    pose = odometry.update([math.hypot(*way) for way in ways], [math.atan2(b, a) for a, b in ways], turn)
    side = math.copysign(radius, turn)
    expected = radius * math.sin(abs(turn)), side * (1.0 - math.cos(turn)), turn
    assert pose == pytest.approx(expected, abs=1e-12)
