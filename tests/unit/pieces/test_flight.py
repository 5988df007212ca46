"""Flights: one step against many small ones, the parabola, paths and crossings."""

from __future__ import annotations

import numpy as np
import pytest

from simcore.pieces.aerodynamics import Aerodynamics, AirFactors, air_factors
from simcore.pieces.flight import FlightState, advance, crossing, path
from simcore.units import GRAVITY

POS, VEL, SPIN = (np.array([row]) for row in ((1.0, 2.0, 0.5), (15.0, -2.0, 12.0), (0.0, -150.0, 20.0)))
AIR = air_factors(Aerodynamics(lift_slope=1.92), radius=0.075, mass=0.215)


def test_a_step_is_of_second_order():
    """20 ms with drag and lift, against steps of a hundredth; half the step, a quarter of the error."""
    exact, faster = POS, VEL
    for _ in range(100):
        exact, faster = advance(exact, faster, SPIN, AIR, 0.0002)
    there, after = advance(POS, VEL, SPIN, AIR, 0.02)
    assert there == pytest.approx(exact, abs=5e-5) and after == pytest.approx(faster, abs=5e-3)
    half = advance(*advance(POS, VEL, SPIN, AIR, 0.01), SPIN, AIR, 0.01)
    assert np.linalg.norm(half[1] - faster) < 0.3 * np.linalg.norm(after - faster)


def test_without_air_it_is_the_parabola_at_any_step():
    pos, vel = advance(POS, VEL, SPIN, AirFactors(), 0.7)
    assert pos == pytest.approx(POS + 0.7 * VEL - (0.0, 0.0, 0.5 * GRAVITY * 0.7**2))
    assert vel == pytest.approx(VEL - (0.0, 0.0, GRAVITY * 0.7))


def test_a_path_has_a_row_a_step_and_what_is_left_out_changes_no_other():
    rows = AirFactors(drag=np.array([0.0, 0.03]), lift=np.zeros(2), lift_saturation=np.zeros(2))
    both = FlightState(pos=POS.repeat(2, 0), vel=VEL.repeat(2, 0), spin=SPIN.repeat(2, 0), radius=np.ones(2), air=rows)
    points = path(both, 50)
    t = 0.02 * np.arange(51)[:, None]
    assert points[:, 0] == pytest.approx(POS + t * VEL - 0.5 * GRAVITY * t * t * (0.0, 0.0, 1.0))
    assert np.array_equal(path(both.only(np.array([1])), 50)[:, 0], points[:, 1])


def test_a_plane_is_crossed_in_the_direction_of_its_normal_alone():
    start, end = np.array([(0.0, 0.0, 2.0), (0.0, 0.0, -1.0), (0.0, 0.0, 3.0)]), np.array([(4.0, 0.0, -2.0)] * 3)
    end[1, 2] = 1.0
    down = crossing(start, end, np.zeros(3), np.array([0.0, 0.0, -1.0]))
    assert down == pytest.approx([0.5, np.inf, 0.6])
