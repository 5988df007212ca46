"""Height of a robot above the ground, from its wheels."""

import numpy as np
import pytest

from simcore.errors import ConfigError, NonFiniteError
from simcore.robot.chassis import ground_clearance

pytestmark = pytest.mark.engines("bullet")

WHEELS = np.array([[0.3, 0.3, 0.0], [0.3, -0.3, 0.0], [-0.3, 0.3, 0.0], [-0.3, -0.3, 0.0]])


def test_a_robot_tilted_on_a_bump_is_not_airborne() -> None:
    wheels = WHEELS + np.array([[0, 0, 0.165], [0, 0, 0.165], [0, 0, 0.0], [0, 0, 0.0]])
    result = ground_clearance(wheels, np.array([0.165, 0.165, 0.0, 0.0]))
    assert result.height == 0.0
    assert not result.is_airborne


def test_the_height_of_an_airborne_robot_is_the_gap_below_its_lowest_wheel() -> None:
    result = ground_clearance(WHEELS + np.array([0.0, 0.0, 0.05]), np.zeros(4))
    assert result.height == pytest.approx(0.05)
    assert result.is_airborne


def test_ground_clearance_refuses_arrays_of_wrong_shape_and_non_finite_heights() -> None:
    with pytest.raises(ConfigError, match="shape"):
        ground_clearance(WHEELS, np.zeros(3))
    with pytest.raises(ConfigError, match="shape"):
        ground_clearance(np.empty((0, 3)), np.empty(0))
    with pytest.raises(NonFiniteError, match="finite"):
        ground_clearance(WHEELS, np.array([0.0, np.nan, 0.0, 0.0]))
