"""Flights in the loop: equation of motion, parabola and independence."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from games.rebuilt.fuel import FUEL
from simcore.loop.state import make_memory
from simcore.pieces.aerodynamics import Aerodynamics
from simcore.pieces.flight import FLIGHT_STEP, cannot_rise, flying_balls
from simcore.units import GRAVITY
from simcore.world.ball_dynamics import StandingField
from simcore.world.contact_law import CARPET

POS, VEL, SPIN = (np.array([row]) for row in ((1.0, 2.0, 0.5), (8.0, -2.0, 9.0), (0.0, -150.0, 20.0)))
CURVED = replace(FUEL, aerodynamics=Aerodynamics(lift_slope=1.92))
HEAVY = replace(FUEL, aerodynamics=None)
OPEN = StandingField.of((), CARPET)


def flown(balls, seconds):
    memory = make_memory(len(balls.pos))
    for _ in range(round(seconds / FLIGHT_STEP)):
        OPEN.fly(balls, memory, FLIGHT_STEP)
    return balls


def test_a_flight_with_drag_and_lift_follows_the_equation_of_motion():
    """dv/dt = -g - k |v| v + c (omega x v) / (1 + s |omega x v| / v^2), dw/dt = -f w^2: within 2 mm after 1.5 s."""
    air = CURVED.air

    def law(_, state):
        v, w = state[3:6], state[6:]
        across, speed = np.cross(w, v), np.linalg.norm(v)
        lift = air.lift * across / (1.0 + air.lift_saturation * np.linalg.norm(across) / speed**2)
        return [*v, *(lift - air.drag * speed * v - (0.0, 0.0, GRAVITY)), *(-air.spin_drag * np.linalg.norm(w) * w)]

    start = np.concatenate([POS[0], VEL[0], SPIN[0]])
    exact = solve_ivp(law, (0.0, 1.5), start, rtol=1e-10, atol=1e-12).y[:, -1]
    ball = flown(flying_balls(CURVED, POS, VEL, SPIN), 1.5)
    assert np.linalg.norm(exact[:3] - POS[0] - 1.5 * VEL[0]) > 3.0, "gravity, drag and lift bend it"
    assert np.linalg.norm(ball.pos[0] - exact[:3]) < 0.002
    assert np.linalg.norm(ball.vel[0] - exact[3:6]) < 0.004


def test_a_flight_without_air_is_a_parabola():
    ball = flown(flying_balls(HEAVY, POS, VEL, SPIN), 0.7)
    assert ball.pos == pytest.approx(POS + 0.7 * VEL - (0.0, 0.0, 0.5 * GRAVITY * 0.7**2))
    assert ball.vel == pytest.approx(VEL - (0.0, 0.0, GRAVITY * 0.7))


def test_balls_fly_independently_with_their_own_factors():
    """Two balls from one place pass through each other; the heavier one flies exactly as it would alone."""
    mass = np.array([1.0, 1.1])
    both = flown(flying_balls(FUEL, POS.repeat(2, 0), VEL.repeat(2, 0), SPIN.repeat(2, 0), mass=mass), 1.0)
    one = flown(flying_balls(FUEL, POS, VEL, SPIN, mass=mass[1:]), 1.0)
    assert np.array_equal(both.pos[1], one.pos[0]) and both.pos[1, 0] > both.pos[0, 0]
    assert both.air[:, 0] * both.mass == pytest.approx(FUEL.air.drag * FUEL.mass)


@pytest.mark.parametrize(("factor", "spent"), [(0.99, True), (1.01, False)])
def test_the_rise_of_a_ball_follows_from_its_kinetic_and_spin_energy(factor, spent):
    """v^2 / 2 + (2/5) r^2 omega^2 / 2 = g h for a solid ball."""
    rim = 3.0
    up = math.sqrt(2.0 * (GRAVITY * 1.5 * factor - 0.2 * rim**2))
    ball = flying_balls(FUEL, POS, np.array([[0.0, 0.0, up]]), np.array([[rim / FUEL.bounding_radius, 0.0, 0.0]]))
    assert cannot_rise(ball, 2.0, GRAVITY).tolist() == [spent]
