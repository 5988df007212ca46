"""Laws of the swept intake zone, of drag and lift, and of launching."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from simcore.loop.contact import air_acceleration
from simcore.pieces.aerodynamics import Aerodynamics, air_factors
from simcore.pieces.launch import Aim, LaunchParameters, launch_state, muzzle_offset
from simcore.robot.intake import IntakeZone, field_to_robot

pytestmark = pytest.mark.engines("bullet")

ZONE = IntakeZone(x_min=-0.50, x_max=-0.35, y_min=-0.25, y_max=0.25, z_max=0.20)
near = arrays(np.float64, (6, 3), elements=st.floats(-1, 1))
vectors = arrays(np.float64, (3,), elements=st.floats(-20, 20))
rotations = arrays(np.float64, (4,), elements=st.floats(-1, 1)).filter(lambda q: np.linalg.norm(q) > 0.1)


@settings(max_examples=200)
@given(near, near)
def test_the_swept_intake_zone_agrees_with_fine_samples(prev, now):
    steps = np.linspace(0.0, 1.0, 200)
    sampled = np.any([ZONE.contains(prev + f * (now - prev)) for f in steps], axis=0)
    swept = ZONE.captured(prev, now)
    assert not np.any(sampled & ~swept)
    grown = IntakeZone(x_min=-0.52, x_max=-0.33, y_min=-0.27, y_max=0.27, z_min=-0.12, z_max=0.22)
    assert not np.any(swept & ~np.any([grown.contains(prev + f * (now - prev)) for f in steps], axis=0))


@settings(max_examples=100)
@given(
    arrays(np.float64, (5, 3), elements=st.floats(-40, 40)), arrays(np.float64, (5, 3), elements=st.floats(-200, 200))
)
def test_aerodynamic_forces_never_add_energy(velocity, spin):
    factors = air_factors(Aerodynamics(lift_slope=1.5), radius=0.075, mass=0.215)
    for v, w in zip(velocity, spin, strict=True):
        assert np.dot(air_acceleration(*v, *w, *factors[:3]), v) <= 1e-6


@settings(max_examples=100)
@given(rotations, vectors, vectors, vectors, st.floats(-3, 3), st.floats(0, 1.5))
def test_the_launch_position_in_the_robot_frame_is_the_muzzle_offset(q, pos, velocity, spin, turret, elevation):
    """`launch_state` and `field_to_robot` use equal frames; the exit speed relative to the muzzle is as commanded."""
    rotation = q / np.linalg.norm(q)
    launch = LaunchParameters(height=0.5, forward=0.2, pivot_x=0.1, barrels=(0.08, -0.08))
    at, v = launch_state(launch, Aim(elevation, 9.0, turret), (pos, rotation, velocity, spin), 1)
    assert np.allclose(field_to_robot(at[None], pos, rotation)[0], muzzle_offset(launch, 1, turret), atol=1e-9)
    assert np.isclose(np.linalg.norm(v - velocity - np.cross(spin, at - pos)), 9.0, atol=1e-9)
