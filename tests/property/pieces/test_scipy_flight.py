"""The flight by scipy against closed forms and the table of fuel flights."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy_flight import fly

from simcore.errors import ConfigError, NonFiniteError
from simcore.pieces.aerodynamics import Aerodynamics, AirFactors, air_factors
from simcore.pieces.launch import launch_direction
from simcore.units import GRAVITY, inches

FUEL = AirFactors(drag=0.0232)
START = np.array([0.0, 0.0, 0.5])


def test_without_air_it_is_a_parabola():
    flight = fly(START, np.array([3.0, -1.0, 6.0]))
    t = flight.time
    assert flight.pos == pytest.approx(np.column_stack([3 * t, -t, 0.5 + 6 * t - 0.5 * GRAVITY * t**2]), abs=1e-8)
    assert flight.landed
    assert flight.pos[-1, 2] == pytest.approx(0.0, abs=1e-9)


def test_straight_down_follows_the_hyperbolic_tangent():
    """v = vt tanh(g t / vt), vt = sqrt(g / k)."""
    flight = fly(np.array([0.0, 0.0, 100.0]), np.zeros(3), air=FUEL, max_time=3.0)
    terminal = math.sqrt(GRAVITY / 0.0232)
    assert not flight.landed
    assert flight.velocity[:, 2] == pytest.approx(-terminal * np.tanh(GRAVITY * flight.time / terminal), abs=1e-7)


@pytest.mark.parametrize(
    ("speed", "degrees", "floor_drag", "floor_vacuum", "hub_drag", "hub_vacuum", "t_drag", "t_vacuum"),
    [
        (7, 65, 3.67, 4.02, 2.75, 3.05, 0.979, 1.031),
        (8, 60, 5.24, 5.89, 4.18, 4.74, 1.119, 1.184),
        (10, 55, 8.30, 9.87, 7.13, 8.54, 1.387, 1.488),
        (12, 50, 11.72, 14.81, 10.42, 13.24, 1.572, 1.717),
    ],
)
def test_fuel_flies_as_the_table_says(speed, degrees, floor_drag, floor_vacuum, hub_drag, hub_vacuum, t_drag, t_vacuum):
    velocity = speed * launch_direction(0.0, math.radians(degrees))
    for air, floor, hub, t in (
        (FUEL, floor_drag, hub_drag, t_drag),
        (AirFactors(), floor_vacuum, hub_vacuum, t_vacuum),
    ):
        assert fly(START, velocity, air=air).pos[-1, 0] == pytest.approx(floor, rel=0.01)
        through = fly(START, velocity, air=air, stop_height=inches(72))
        assert through.pos[-1, 0] == pytest.approx(hub, rel=0.01)
        assert through.time[-1] == pytest.approx(t, rel=0.01)


def test_backspin_carries_further():
    air = air_factors(Aerodynamics(lift_slope=1.0), radius=0.075, mass=0.215)
    velocity = 8.0 * launch_direction(0.7, math.radians(45))
    straight = fly(START, velocity, air=air)
    spun = fly(START, velocity, air=air, spin=40.0 * np.array([math.sin(0.7), -math.cos(0.7), 0.0]))
    assert np.hypot(*spun.pos[-1, :2]) > np.hypot(*straight.pos[-1, :2]) + 0.1
    assert math.atan2(spun.pos[-1, 1], spun.pos[-1, 0]) == pytest.approx(0.7)  # lift does not turn it


def test_a_flight_that_only_just_rises_over_the_height_is_seen_to_land():
    """It is above the height for 0.06 s; scipy's steps without drag are longer."""
    flight = fly(START, np.array([5.0, 0.0, math.sqrt(2 * GRAVITY * (1.0 + 0.5 * GRAVITY * 0.03**2))]), stop_height=1.5)
    assert flight.landed
    assert flight.pos[-1, 2] == pytest.approx(1.5)


@pytest.mark.parametrize("bad", [[math.nan, 0.0, 0.0], [0.0, math.inf, 0.0], [0.0, 0.0]])
def test_bad_starts_are_refused(bad):
    with pytest.raises(NonFiniteError):
        fly(START, np.array(bad))
    with pytest.raises(ConfigError, match="max_time"):
        fly(START, np.zeros(3), max_time=-1.0)
