"""Every solved shot, integrated by solve_ivp from the actual muzzle, falls through the target."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from simcore.loop.contact import air_acceleration
from simcore.pieces.launch import LaunchParameters, launch_direction
from simcore.pieces.shot_solver import NoShotError, solve_shot
from simcore.units import GRAVITY

pytestmark = pytest.mark.engines("bullet")

FIELD = (16.541, 8.069)
LAUNCH = LaunchParameters(height=0.55, forward=0.168, barrels=(0.08, -0.08))

asked = st.one_of(
    st.builds(lambda degrees: {"elevation": math.radians(degrees)}, st.floats(45, 80)),
    st.builds(lambda speed, arc: {"speed": speed, "high_arc": arc}, st.floats(6, 14), st.booleans()),
)
speeds = st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.just(0.0))
places = st.tuples(st.floats(1, 10), st.floats(0.5, 7.5), st.floats(0.2, 1.0))
targets = st.tuples(st.just(4.63), st.just(4.03), st.floats(0.5, 2.5))
drags = st.sampled_from([0.0, 0.0232, 0.06])


def fallen(start, velocity, drag: float, height: float) -> tuple[float, np.ndarray]:
    """Return the time and place at which a ball falls through a height [s, m], integrated by scipy."""

    def law(_, state):
        return [*state[3:], *np.array(air_acceleration(*state[3:], 0.0, 0.0, 0.0, drag, 0.0, 0.0)) - (0, 0, GRAVITY)]

    def falls_through(_, state):
        return state[2] - height

    falls_through.terminal, falls_through.direction = True, -1.0
    # keep steps shorter than the time above the height, or solve_ivp misses the crossing
    found = solve_ivp(law, (0.0, 10.0), [*start, *velocity], events=falls_through, rtol=1e-9, atol=1e-10, max_step=0.02)
    return float(found.t[-1]), found.y[:3, -1]


@settings(max_examples=100)
@given(places, targets, speeds, asked, drags)
def test_a_piece_with_the_solved_speed_falls_through_the_target(muzzle, target, velocity, question, drag):
    try:
        shot = solve_shot(muzzle, target, drag=drag, robot_velocity=velocity, **question)
    except NoShotError:
        assume(False)
    assume(shot.entry_angle > 0.1)  # above the target for long enough that solve_ivp finds the crossing
    start = shot.speed * launch_direction(shot.yaw, shot.elevation) + np.array(velocity)
    time, place = fallen(muzzle, start, drag, target[2])
    assert np.linalg.norm(place - target) < 0.005
    assert abs(time - shot.time_of_flight) < 0.001
    for name in ("elevation", "speed"):
        assert math.isclose(getattr(shot, name), question.get(name, getattr(shot, name)), abs_tol=1e-6)
