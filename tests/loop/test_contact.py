"""The laws of contact, one by one, against closed forms."""

import math

import numpy as np
import pytest
from each_case import each

from games.rebuilt.fuel import FUEL
from simcore.loop.contact import (
    DAMPING_RATIOS,
    air_acceleration,
    damping_ratio,
    foam_force,
    foam_slope,
    friction_stiffness,
    normal_force,
    steps_for,
)
from simcore.pieces.aerodynamics import Aerodynamics, air_factors

INCH, POUND = 0.0254, 4.4482216


@each(("inches", "pounds"), [(1.0, 20.6), (1.5, 42.0), (2.0, 77.0)])
def test_foam_between_two_plates_gives_the_makers_force(inches, pounds):
    """Each side of the fuel gives way by half of what the plates move: AndyMark's figures within 1 %."""
    assert foam_force(0.5 * inches * INCH, *FUEL.foam) == pytest.approx(pounds * POUND, rel=0.01)


def test_the_slope_is_that_of_the_force_where_foam_is_dense_too():
    for depth in (0.001, 0.02, 0.044, 0.05, 0.065):
        rise = foam_force(depth + 1e-7, *FUEL.foam) - foam_force(depth - 1e-7, *FUEL.foam)
        assert foam_slope(depth, *FUEL.foam) == pytest.approx(rise / 2e-7, rel=1e-4)


def test_dense_foam_takes_three_hundred_joules_before_nine_tenths_of_the_radius():
    depth = np.linspace(0.0, 0.9 * FUEL.bounding_radius, 2001)
    force = np.array([foam_force(d, *FUEL.foam) for d in depth])
    assert np.trapezoid(force, depth) > 300.0


@pytest.mark.parametrize(("power", "row"), [(1, 0), (3, 1)])
def test_the_damping_ratios_leave_their_restitution(power, row):
    """m x'' = -F - 2 zeta sqrt(m F') x', never tension, integrated by steps of a ten-thousandth of the contact."""
    ratios, restitutions = DAMPING_RATIOS[row], np.linspace(0.0, 1.0, 21)
    h = 1e-4
    depth, speed = np.zeros(21), np.ones(21)
    out = np.full(21, np.nan)
    for _ in range(200_000):
        middle, fast = depth + 0.5 * h * speed, speed
        for _ in range(2):  # the midpoint rule
            d = np.maximum(middle, 0.0)
            damper = 2.0 * ratios * np.sqrt(power * d ** (power - 1)) * fast
            pull = -np.maximum(d**power + damper, 0.0)
            fast = speed + 0.5 * h * pull
        depth, speed = depth + h * fast, speed + h * pull
        left = (depth <= 0.0) & np.isnan(out)
        out[left] = -speed[left]
        if not np.isnan(out[1:]).any():
            break
    assert out[2:] == pytest.approx(restitutions[2:], abs=0.004)
    assert 0.0 <= out[1] < 0.06


def test_between_the_tables_the_ratio_is_interpolated():
    low, high = DAMPING_RATIOS[0, 10], DAMPING_RATIOS[0, 11]
    assert damping_ratio(0.525, 0.0, DAMPING_RATIOS) == pytest.approx(0.5 * (low + high))
    assert damping_ratio(0.5, 1.0, DAMPING_RATIOS) == pytest.approx(DAMPING_RATIOS[1, 10])
    assert damping_ratio(1.0, 0.3, DAMPING_RATIOS) == 0.0


@each("approach", [-100.0, -1.0, 0.0, 1.0])
def test_a_contact_never_pulls_and_pushes_more_while_it_closes(approach):
    push = normal_force(0.0025, 10.0, 4000.0, 4000.0, approach, False, 0.3, 0.2, 1e-3, DAMPING_RATIOS)
    assert push >= 0.0
    assert (push > 10.0) == (approach > 0.0) and (push == 10.0) == (approach == 0.0)


def test_a_friction_spring_is_no_stiffer_than_its_step_allows():
    stiffness, damping = friction_stiffness(1e9, 0.2, 1e-3)
    assert stiffness * 1e-6 / (2.0 / 7.0 * 0.2) == pytest.approx(0.5)
    assert damping * 1e-3 / (2.0 / 7.0 * 0.2) < 1.0
    assert friction_stiffness(1000.0, 0.2, 1e-3)[0] == pytest.approx(800.0)


def test_a_contact_that_is_four_times_as_stiff_takes_twice_the_steps():
    assert steps_for(1.0, 0.2, 1e-3) == 1
    assert steps_for(4e6, 0.2, 1e-3) == pytest.approx(2 * steps_for(1e6, 0.2, 1e-3), abs=1)


def test_drag_is_against_the_flight_and_lift_across_it_and_the_spin():
    """a = -k |v| v + c (omega x v) v^2 / (v^2 + s |omega x v|), with the factors of the piece."""
    rng = np.random.default_rng(3)
    factors = air_factors(Aerodynamics(lift_slope=1.0), radius=0.075, mass=0.215)
    for _ in range(20):
        vel, spin = rng.normal(0.0, 8.0, 3), rng.normal(0.0, 50.0, 3)
        across, v2 = np.cross(spin, vel), vel @ vel
        wanted = -factors.drag * math.sqrt(v2) * vel
        wanted += factors.lift * across * v2 / (v2 + factors.lift_saturation * np.linalg.norm(across))
        got = air_acceleration(*vel, *spin, factors.drag, factors.lift, factors.lift_saturation)
        assert got == pytest.approx(wanted, rel=1e-12)
    assert air_acceleration(0.0, 0.0, 0.0, 1.0, 0.0, 0.0, *factors[:3]) == (0.0, 0.0, 0.0)
    assert factors.spin_drag * 60.0**2 == pytest.approx(0.45, rel=0.1)  # rad/s^2, see `_SPIN_TORQUE`
