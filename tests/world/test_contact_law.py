"""Materials, and the spring and damper of a contact that is computed in steps."""

import math
from dataclasses import FrozenInstanceError, replace

import pytest
from each_case import each

from simcore.errors import ConfigError
from simcore.world.contact_law import CARPET, TerrainSurface, contact_spring

H = 0.0005


def speed_after(restitution: float, stiffness: float = math.inf) -> float:
    """Return the rebound speed of a 1 kg body that arrives at 1 m/s [m/s]: x'' = max(0, k x - c v), in steps."""
    k, c = contact_spring(restitution, 0.5, stiffness, 1.0, H)
    depth, speed = 0.0, 1.0
    while depth >= 0.0:
        speed -= max(0.0, k * depth + c * speed) * H
        depth += speed * H
    return -speed


@each("restitution", [0.15, 0.3, 0.6, 0.9])
@each("stiffness", [1e4, math.inf])
def test_a_spring_and_a_damper_produce_the_configured_restitution(restitution, stiffness):
    assert speed_after(restitution, stiffness) == pytest.approx(restitution, abs=0.05)


def test_a_material_softer_than_the_step_allows_keeps_its_stiffness():
    assert contact_spring(0.3, 0.5, 1e4, 2.0, H)[0] == 5e3
    assert contact_spring(0.3, 0.5, math.inf, 2.0, H) == contact_spring(0.3, 0.5, 1e9, 2.0, H)


def test_a_contact_without_friction_and_bounce_stops_a_body_in_a_single_step():
    spring, damper = contact_spring(0.0, 0.0, math.inf, 55.0, 0.005)
    assert damper * 0.005 == pytest.approx(1.0)
    assert damper == pytest.approx(2.0 * math.sqrt(spring)), "critical"


@each(
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
def test_the_error_names_an_impossible_material(field, value):
    values = {"friction": 1.0, "restitution": 0.5, "rolling": 0.0, field: value}
    with pytest.raises(ConfigError, match=f"ICE: {field}"):
        TerrainSurface(name="ICE", **values)


def test_a_preset_is_frozen_but_can_be_varied():
    with pytest.raises(FrozenInstanceError):
        CARPET.friction = 0.1
    assert replace(CARPET, friction=0.1).restitution == CARPET.restitution
