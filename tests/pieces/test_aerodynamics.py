"""Formulas of drag and lift."""

import math

import numpy as np
import pytest
from each_case import each

from simcore.errors import ConfigError
from simcore.loop.contact import air_acceleration
from simcore.pieces.aerodynamics import Aerodynamics, air_factors, drag_acceleration

BASEBALL = Aerodynamics(lift_slope=1.92)


def lift_acceleration(velocity, spin, factors):
    return air_acceleration(*velocity, *spin, 0.0, factors.lift, factors.lift_saturation)


def test_the_drag_to_weight_ratio_of_fuel_equals_the_published_ratio():
    """Drag is 0.15, 0.24 and 0.34 of the weight at 8, 10 and 12 m/s."""
    k = air_factors(Aerodynamics(), radius=0.075, mass=0.215).drag
    speeds = np.array([8.0, 10.0, 12.0])
    drag = drag_acceleration(np.column_stack([speeds, 0 * speeds, 0 * speeds]), k)
    assert -drag[:, 0] / 9.81 == pytest.approx([0.15, 0.24, 0.34], abs=0.005)
    assert math.sqrt(9.81 / k) == pytest.approx(20.6, abs=0.05)  # terminal speed


def test_the_drag_factor_may_differ_from_piece_to_piece():
    velocity = np.array([[3.0, 4.0, 0.0], [0.0, 0.0, -2.0], [0.0, 0.0, 0.0]])
    drag = drag_acceleration(velocity, np.array([0.1, 0.5, 0.1]))
    assert drag == pytest.approx(np.array([[-1.5, -2.0, 0.0], [0.0, 0.0, 2.0], [0.0, 0.0, 0.0]]))


def test_backspin_lifts_a_ball_and_sidespin_bends_its_path():
    factors = air_factors(BASEBALL, radius=0.075, mass=0.215)
    forward = (10.0, 0.0, 0.0)
    up = lift_acceleration(forward, (0.0, -30.0, 0.0), factors)
    assert up[2] > 0.0
    assert up[:2] == pytest.approx([0.0, 0.0])
    assert lift_acceleration(forward, (0.0, 0.0, 30.0), factors)[1] > 0.0
    assert lift_acceleration(forward, (30.0, 0.0, 0.0), factors) == pytest.approx((0, 0, 0))  # rifle spin


@each("rate", [5.0, 60.0, 1000.0])
def test_the_lift_acceleration_is_rho_area_cl_speed_squared_over_two_m(rate):
    """With Cl = slope S / (1 + slope S / limit) at a spin ratio S = r omega / v."""
    factors = air_factors(BASEBALL, radius=0.075, mass=0.215)
    lift = lift_acceleration((10.0, 0.0, 0.0), (0.0, -rate, 0.0), factors)
    spin_ratio = 0.075 * rate / 10.0
    coefficient = 1.92 * spin_ratio / (1.0 + 1.92 * spin_ratio / 0.48)
    assert lift[2] == pytest.approx(0.5 * 1.2 * math.pi * 0.075**2 * coefficient * 100.0 / 0.215)


def test_a_piece_at_rest_has_no_drag_or_lift():
    factors = air_factors(BASEBALL, radius=0.075, mass=0.215)
    for spin in ((0.0, 50.0, 0.0), (0.0, 0.0, 0.0)):
        assert air_acceleration(0.0, 0.0, 0.0, *spin, *factors[:3]) == (0.0, 0.0, 0.0)


@each("change", [{"drag_coefficient": -0.1}, {"lift_slope": math.nan}, {"lift_limit": 0.0}])
def test_invalid_coefficients_are_refused(change):
    with pytest.raises(ConfigError, match=next(iter(change))):
        Aerodynamics(**change)


@each(("radius", "mass"), [(-0.1, 1.0), (0.1, 0.0), (math.nan, 1.0), (0.1, -0.2)])
def test_a_ball_needs_a_positive_radius_and_mass(radius, mass):
    with pytest.raises(ConfigError):
        air_factors(Aerodynamics(), radius=radius, mass=mass)
