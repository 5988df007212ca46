"""Collision shapes refuse what has no volume."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simcore.errors import ConfigError
from simcore.physics.shapes import Box, Cylinder, Hull, Sphere


@pytest.mark.parametrize("value", [0.0, -0.1, math.nan, math.inf])
def test_lengths_must_be_positive_numbers(value):
    with pytest.raises(ConfigError, match="Sphere: radius"):
        Sphere(value)
    with pytest.raises(ConfigError, match="Cylinder: radius"):
        Cylinder(value, 1.0)
    with pytest.raises(ConfigError, match="Cylinder: height"):
        Cylinder(1.0, value)
    with pytest.raises(ConfigError, match=r"Box: size\[1\] must be a number above 0 and up to 2000 m"):
        Box((1.0, value, 1.0))


@pytest.mark.parametrize(
    ("points", "says"),
    [
        (np.zeros((3, 3)), "n >= 4"),
        (np.zeros((4, 2)), "n >= 4"),
        (np.zeros(12), "n >= 4"),
        (np.full((4, 3), math.nan), "must be a number from -100 to 100 m, got nan"),
    ],
)
def test_a_hull_needs_four_finite_points(points, says):
    with pytest.raises(ConfigError, match=says):
        Hull(points)


def test_equal_shapes_are_equal_so_that_the_engine_can_share_them():
    assert Sphere(0.1) == Sphere(0.1)
    assert hash(Box((1.0, 2.0, 3.0))) == hash(Box((1.0, 2.0, 3.0)))
