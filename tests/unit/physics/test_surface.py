"""Materials."""

from __future__ import annotations

import math
from dataclasses import FrozenInstanceError, replace

import pytest

from simcore.errors import ConfigError
from simcore.physics.contact_law import CARPET, PRESETS, TerrainSurface


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


def test_the_presets_are_there_by_name():
    assert {"CARPET", "WALL", "RUBBER", "POLYCARBONATE"} <= set(PRESETS)
    assert all(surface.name == name for name, surface in PRESETS.items())


def test_a_preset_cannot_be_changed_but_varied():
    with pytest.raises(FrozenInstanceError):
        CARPET.friction = 0.1
    assert replace(CARPET, friction=0.1).restitution == CARPET.restitution
