"""Each contact law agrees with its closed form."""

import math
from itertools import pairwise

import numpy as np
import pytest
from each_case import each

from games.rebuilt.fuel import FUEL
from simcore.loop.contact import (
    air_acceleration,
    foam_energy,
    foam_force,
    foam_loss,
    foam_memory,
    foam_slope,
    friction_stiffness,
    hardened,
    rolling_resistance,
    steps_for,
)
from simcore.pieces.aerodynamics import Aerodynamics, air_factors

INCH, POUND = 0.0254, 4.4482216


@each(("inches", "pounds"), [(1.0, 20.6), (1.5, 42.0), (2.0, 77.0)])
def test_foam_between_two_plates_exerts_the_force_in_the_makers_report(inches, pounds):
    """Each side of the fuel takes half of the compression; AndyMark's figures hold within 1 %."""
    assert foam_force(0.5 * inches * INCH, *FUEL.foam) == pytest.approx(pounds * POUND, rel=0.01)


def test_the_foam_slope_is_the_derivative_of_the_force_up_to_dense_foam():
    for depth in (0.001, 0.02, 0.044, 0.05, 0.065):
        rise = foam_force(depth + 1e-7, *FUEL.foam) - foam_force(depth - 1e-7, *FUEL.foam)
        assert foam_slope(depth, *FUEL.foam) == pytest.approx(rise / 2e-7, rel=1e-4)


def test_dense_foam_absorbs_300_joules_within_nine_tenths_of_the_radius():
    depth = np.linspace(0.0, 0.9 * FUEL.bounding_radius, 2001)
    force = np.array([foam_force(d, *FUEL.foam) for d in depth])
    assert np.trapezoid(force, depth) > 300.0


def test_the_foam_energy_is_the_work_of_the_force_up_to_dense_foam():
    """Simpson's rule is exact for cubics, so the sum over two intervals equals U up to rounding."""
    start = FUEL.foam[2]
    for low, high in ((0.0, start), (start, 0.065)):
        middle = 0.5 * (low + high)
        forces = [foam_force(d, *FUEL.foam) for d in (low, middle, high)]
        work = (high - low) / 6.0 * (forces[0] + 4.0 * forces[1] + forces[2])
        assert foam_energy(high, *FUEL.foam) - foam_energy(low, *FUEL.foam) == pytest.approx(work, rel=1e-12)


CURVES = {
    "linear": (1e4, 0.0, 1.0, 0.0),
    "cubic": (1e-6, 1e7, 1.0, 0.0),
    "fuel": FUEL.foam,
    "dense": (10.0, 0.0, 0.0, 1e7),
}


@pytest.mark.parametrize("curve", CURVES)
@pytest.mark.parametrize("restitution", [0.0, 0.1, 0.2, 0.3, 0.31, 0.55, 0.8, 1.0])
def test_a_contact_returns_e_squared_of_its_energy_for_any_force_curve(curve, restitution):
    """Foam is compressed by 60 mm and released fast, in 40,000 steps; the thinnest band has three steps."""
    foam, (loss, band) = CURVES[curve], foam_loss(restitution)
    inward = np.linspace(0.0, 0.06, 20_001)
    memory, last, work = 1.0, 0.0, [0.0, 0.0]
    for way, depths in enumerate((inward, inward[::-1])):
        for before, depth in pairwise(depths.tolist()):
            energy = foam_energy(depth, *foam)
            memory, last = foam_memory(memory, energy, last, band, 1e-9), energy
            work[way] += foam_force(0.5 * (before + depth), *foam) * (1.0 + loss * memory) * (depth - before)
    assert math.sqrt(-work[1] / work[0]) == pytest.approx(max(restitution, 0.0387), abs=0.005)


def test_released_foam_pushes_with_e_squared_of_its_force():
    """1 - c = e^2, which is never zero, so a pair of balls separates."""
    for restitution in (0.1, 0.3, 0.7, 1.0):
        assert 1.0 - foam_loss(restitution)[0] == pytest.approx(restitution**2)


def test_foam_at_rest_relaxes_to_its_curve():
    """Memory decays by 1 / (1 + 2 h / w T) a step, from either side: 1 % is left after 5 ms."""
    _, band = foam_loss(0.55)
    for memory in (-1.0, 1.0):
        for _ in range(1000):
            memory = foam_memory(memory, 0.3, 0.3, band, 1e-3)
        assert abs(memory) < 1e-6
    assert foam_memory(0.5, 0.0, 0.0, band, 1e-9) == pytest.approx(0.5), "and untouched foam has none to turn by"


@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.7, 1.0])
def test_a_contact_never_pulls_and_never_returns_more_energy_than_it_took(restitution):
    """-1 <= s <= 1 and 0 <= c <= 1 for any compression history; energy is summed over 400 histories."""
    rng, foam = np.random.default_rng(7), FUEL.foam
    loss, band = foam_loss(restitution)
    assert 0.0 <= loss <= 1.0
    for _ in range(400):
        depths = np.abs(np.cumsum(rng.normal(0.0, 2e-4, 300)))
        depths = np.concatenate((depths, np.linspace(depths[-1], 0.0, 50)))
        memory, last, work, before = 1.0, 0.0, 0.0, 0.0
        for depth, h in zip(depths.tolist(), rng.choice([1e-9, 1e-3, 0.1], len(depths)).tolist(), strict=True):
            energy = foam_energy(depth, *foam)
            after = foam_memory(memory, energy, last, band, h)
            assert -1.0 <= after <= 1.0
            push = foam_force(0.5 * (before + depth), *foam) * (1.0 + 0.5 * loss * (memory + after))
            memory, last, work, before = after, energy, work + push * (depth - before), depth
        assert work > -0.02 * foam_energy(float(depths.max()), *foam)


def test_a_contact_with_little_restitution_needs_shorter_steps():
    """Stiffness at a reversal is 4 c k / w with w = e^2: at e = 0.1 eleven times that at 0.35."""
    assert hardened(1000.0, 0.1) == pytest.approx(1000.0 * 0.12 / 0.011)
    assert hardened(1000.0, 0.35) == 1000.0
    assert steps_for(1000.0, 0.2, 3e-3) == 1, "k h^2 / m = 0.045 is at most 0.05"
    assert steps_for(1000.0, 0.2, 6e-3) == 2, "0.18 needs a quarter of that, and has 0.045 in half the step"


def test_foam_resists_rolling_in_proportion_to_its_loss():
    """The lever arm is 3/16 (1 - e^2) a with a patch a = sqrt(R d): 0.97 mm for two fuel pressed by 2.2 N."""
    for spin in (0.1, 10.0):
        torque = spin * rolling_resistance(2.2, spin**2, 0.00086, 0.0375, 0.3)
        assert torque == pytest.approx(2.2 * 0.00097, rel=0.01)
    assert rolling_resistance(2.2, 1.0, 0.01, 0.0375, 1.0) == 0.0, "what loses nothing rolls for ever"


def test_a_friction_spring_is_no_stiffer_than_its_step_allows():
    stiffness, damping = friction_stiffness(1e9, 0.2, 1e-3)
    assert stiffness * 1e-6 / (2.0 / 7.0 * 0.2) == pytest.approx(0.5)
    assert damping * 1e-3 / (2.0 / 7.0 * 0.2) < 1.0
    assert friction_stiffness(1000.0, 0.2, 1e-3)[0] == pytest.approx(800.0)


def test_a_contact_four_times_as_stiff_takes_twice_as_many_steps():
    assert steps_for(1.0, 0.2, 1e-3) == 1
    assert steps_for(4e6, 0.2, 1e-3) == pytest.approx(2 * steps_for(1e6, 0.2, 1e-3), abs=1)


def test_drag_opposes_the_velocity_and_lift_is_normal_to_velocity_and_spin():
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
