"""Shot solver: known and impossible shots."""

import math
from dataclasses import astuple

import pytest
from each_case import each

from simcore.errors import ConfigError, NonFiniteError, SimcoreError
from simcore.pieces.shot_solver import NoShotError, solve_shot
from simcore.units import GRAVITY, inches

K = 0.0232


@each(("speed", "degrees", "x"), [(7, 65, 2.75), (8, 60, 4.18), (10, 55, 7.13), (12, 50, 10.42)])
def test_the_solver_reproduces_the_table_of_fuel_flights(speed, degrees, x):
    muzzle, hub = (0.0, 0.0, 0.5), (x, 0.0, inches(72))
    assert solve_shot(muzzle, hub, elevation=math.radians(degrees), drag=K).speed == pytest.approx(speed, rel=0.01)


def test_a_shot_in_vacuum_is_a_parabola():
    """v^2 = g x^2 / (2 cos^2 (x tan - h))."""
    shot = solve_shot((1.0, 1.0, 0.5), (4.0, 5.0, 2.0), elevation=1.0)
    speed = math.sqrt(GRAVITY * 25.0 / (2.0 * math.cos(1.0) ** 2 * (5.0 * math.tan(1.0) - 1.5)))
    assert shot.speed == pytest.approx(speed, rel=1e-9)
    assert shot.yaw == pytest.approx(math.atan2(4.0, 3.0))
    assert shot.time_of_flight == pytest.approx(5.0 / (speed * math.cos(1.0)), rel=1e-9)


def test_a_given_speed_has_a_high_and_a_low_arc():
    high, low = (solve_shot((0, 0, 0.5), (4, 0, 1.8), speed=9.0, drag=K, high_arc=arc) for arc in (True, False))
    assert high.elevation > low.elevation
    assert high.entry_angle > low.entry_angle > 0.0
    assert (high.speed, low.speed) == pytest.approx((9.0, 9.0))


def test_the_muzzle_velocity_of_a_turning_robot_adds_to_the_shot():
    turning = solve_shot((0, 0, 0.5), (4, 0, 1.8), elevation=1.1, yaw_rate=3.0, muzzle_offset=(0.2, 0.1, 0.5))
    driving = solve_shot((0, 0, 0.5), (4, 0, 1.8), elevation=1.1, robot_velocity=(-0.3, 0.6, 0.0))
    assert astuple(turning) == pytest.approx(astuple(driving))


@each(
    ("arguments", "reason"),
    [
        ({"speed": 5.0}, "out of range: it needs"),
        ({"elevation": 0.1}, "line of sight"),
        ({"elevation": math.radians(89)}, "too steep"),
        ({"elevation": math.radians(30)}, "way up"),
        ({"elevation": 1.1, "max_speed": 6.0}, "launcher gives 6.00"),
        ({"speed": 200.0}, "steeper or flatter"),
    ],
)
def test_the_error_for_an_impossible_shot_gives_the_reason(arguments, reason):
    with pytest.raises(NoShotError, match=reason) as caught:
        solve_shot((0, 0, 0.5), (4, 0, 2.5), drag=K, **arguments)
    assert (caught.value.distance, caught.value.height) == (4.0, 2.0)
    assert isinstance(caught.value, SimcoreError) and isinstance(caught.value, ValueError)


def test_a_goal_open_to_the_front_accepts_rising_shots():
    """1.14 m in front of a slot at 2.05 m, at 58 degrees; the parabola gives v^2 = g x^2 / (2 cos^2 (x tan - h))."""
    muzzle, slot, elevation = (1.37, 5.54, 0.45), (0.23, 5.54, 2.05), math.radians(58.0)
    with pytest.raises(NoShotError, match="rising"):
        solve_shot(muzzle, slot, elevation=elevation)
    shot = solve_shot(muzzle, slot, elevation=elevation, rising=True)
    fall = 1.14 * math.tan(elevation) - 1.6
    assert shot.speed == pytest.approx(math.sqrt(GRAVITY * 1.14**2 / (2.0 * math.cos(elevation) ** 2 * fall)))
    assert shot.entry_angle < 0.0


def test_a_shot_from_right_under_the_target_is_refused():
    with pytest.raises(NoShotError, match="over or under"):
        solve_shot((4, 0, 0.5), (4, 0, 1.8), elevation=1.1)


@each("arguments", [{}, {"elevation": 1.0, "speed": 9.0}, {"elevation": 2.0}, {"speed": -1.0}])
def test_missing_conflicting_or_out_of_range_arguments_are_refused(arguments):
    with pytest.raises(ConfigError):
        solve_shot((0, 0, 0.5), (4, 0, 1.8), **arguments)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_positions_and_velocities_must_be_finite(bad):
    with pytest.raises(NonFiniteError):
        solve_shot((0, 0, bad), (4, 0, 1.8), elevation=1.1)
    with pytest.raises(NonFiniteError):
        solve_shot((0, 0, 0.5), (4, 0, 1.8), elevation=1.1, robot_velocity=(0.0, bad, 0.0))
    with pytest.raises(NonFiniteError):
        solve_shot((0, 0, 0.5), (4, 0, 1.8), elevation=1.1, yaw_rate=bad, muzzle_offset=(0.1, 0.1, 0.5))
    with pytest.raises(ConfigError):
        solve_shot((0, 0, 0.5), (4, 0, 1.8), elevation=1.1, drag=-1.0)
