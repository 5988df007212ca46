"""Histories of poses and readings, interpolated between ticks."""

import pytest

from simcore.errors import ConfigError
from simcore.vision.heading import AngleHistory, PoseHistory
from simcore.world.rotation import from_yaw


def test_a_history_holds_its_end_values_outside_its_samples():
    history = PoseHistory()
    with pytest.raises(ConfigError, match="no pose"):
        history.at(0.0)
    history.add(1.0, (1.0, 0.0, 0.0), from_yaw(0.1))
    assert history.at(0.0) == history.at(9.0)


def test_a_history_covers_at_least_two_seconds_and_fewer_than_200_samples():
    history = PoseHistory()
    for k in range(1000):
        history.add(0.02 * k, (0.01 * k, 0.0, 0.0), from_yaw(0.0))
    assert history.at(19.98 - 2.0)[0][0] == pytest.approx(8.99)
    assert len(history) < 200


@pytest.mark.parametrize(("time", "x"), [(1.02, 5.0), (0.5, 1.0)])
def test_a_robot_moved_by_hand_has_no_interpolated_poses(time, x):
    """Nothing is interpolated across a jump in space, or where time runs backwards."""
    history = PoseHistory()
    history.add(1.0, (1.0, 0.0, 0.0), from_yaw(0.0))
    history.add(time, (x, 0.0, 0.0), from_yaw(0.0))
    assert len(history) == 1
    assert history.at(time - 0.01)[0] == (x, 0.0, 0.0)


def test_readings_are_interpolated_and_late_readings_are_dropped():
    history = AngleHistory()
    assert history.at(0.0) is None
    history.add(1.0, (1.0, 0.0, 0.0))
    history.add(2.0, (3.0, 0.0, 0.0))
    history.add(1.5, (99.0, 0.0, 0.0))
    assert history.at(1.5) == pytest.approx((2.0, 0.0, 0.0))
    history.add(2.0, (5.0, 0.0, 0.0))
    assert history.at(9.0) == (5.0, 0.0, 0.0)
