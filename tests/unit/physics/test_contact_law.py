"""Materials, and what a contact wants of a solver, of a body of 1 kg: (A + R) f = a_ref - a_0, f >= 0, A = 1."""

from __future__ import annotations

import math
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simcore.errors import ConfigError
from simcore.physics.contact_law import CARPET, REST_SPEED, RIGID, TerrainSurface, normal_rows

SOFT = 1e4


def speed_after(gap: float, speed: float, free: float = 0.0, *, e: float = 0.5, k: float = RIGID, h: float) -> float:
    """Rate of the gap after a step [m/s]; damping is twice the critical, and 20 ms of the stiffness of rigid pairs."""
    one = lambda value: np.array([value])  # noqa: E731
    damping = 4.0 * np.sqrt(k) if k < RIGID else 0.02 * k
    wanted, softness = normal_rows(
        *map(one, (gap, speed, free, 1.0)), restitution=one(e), stiffness=one(k), damping=one(damping), h=h
    )
    force = max(0.0, float(wanted[0] - free) / (1.0 + float(softness[0])))
    return speed + (free + force) * h


@pytest.mark.parametrize("k", [SOFT, RIGID])
@given(st.floats(0.5, 20.0), st.floats(0.01, 0.99), st.floats(0.01, 1.0), st.floats(-20.0, 0.0))
def test_an_impact_leaves_with_restitution_times_the_closing_speed(k, v, phase, e, free):
    assert speed_after(0.999 * phase * v * 0.01, -v, free, e=e, k=k, h=0.01) == pytest.approx(e * v, abs=1e-9)


def test_what_is_not_reached_is_let_be():
    assert speed_after(0.1, -1.0, h=0.01) == -1.0


def test_what_is_slow_ends_at_the_surface_without_a_bounce():
    """What a rigid row lacks of it is 1 / (1 + h (k h + c)): 1e-3."""
    gap, speed = 0.0002, -0.5 * REST_SPEED
    assert speed_after(gap, speed, h=0.01) == pytest.approx(-gap / 0.01, rel=2e-3)


@pytest.mark.parametrize("h", [0.001, 0.005, 0.02])
@given(st.floats(1e-4, 0.03), st.floats(-0.09, 0.5))
def test_under_load_the_force_is_that_of_the_spring_and_damper_at_the_end_of_the_step(h, depth, speed):
    """Implicit Euler: v' = (v + h k x) / (1 + h (k h + c)) for 1 kg, where that pushes."""
    damping = 4.0 * np.sqrt(SOFT)
    pushed = (speed + h * SOFT * depth) / (1.0 + h * (SOFT * h + damping))
    assert speed_after(-depth, speed, k=SOFT, h=h) == pytest.approx(max(pushed, speed), abs=1e-9)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("friction", -0.1),
        ("friction", math.nan),
        ("restitution", -0.1),
        ("restitution", 1.1),
        ("restitution", math.nan),
        ("rolling", -1e-3),
        ("rolling", math.inf),
    ],
)
def test_impossible_materials_are_refused_by_name(field, value):
    values = {"friction": 1.0, "restitution": 0.5, "rolling": 0.0, field: value}
    with pytest.raises(ConfigError, match=f"ICE: {field}"):
        TerrainSurface(name="ICE", **values)


def test_a_preset_cannot_be_changed_but_varied():
    with pytest.raises(FrozenInstanceError):
        CARPET.friction = 0.1
    assert replace(CARPET, friction=0.1).restitution == CARPET.restitution
