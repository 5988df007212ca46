"""Collision shapes refuse what has no volume; how far they reach and how they stand, against their geometry."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simcore.errors import ConfigError
from simcore.geometry.rotation import IDENTITY, from_rpy
from simcore.physics.shapes import (
    Box,
    Compound,
    Cylinder,
    Hull,
    Part,
    Sphere,
    bounding_box,
    bounding_radius,
    cone,
    inner_radius,
    mean_frontal_area,
    smallest_thickness,
    stands,
    support_height,
    torus,
    tube,
)


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


TUBE = tube(length=0.3, outer_radius=0.06, inner_radius=0.05)
LYING = from_rpy(0.0, math.pi / 2, 0.0)
CUBE = Hull(np.array([[x, y, z] for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.1, 0.1)]))


@pytest.mark.parametrize(
    ("shape", "quat", "height"),
    [
        (Sphere(0.1), LYING, 0.1),
        (Cylinder(0.1, 0.4), LYING, 0.1),
        (Cylinder(0.1, 0.4), from_rpy(0.0, math.pi / 4, 0.0), (0.2 + 0.1) / math.sqrt(2.0)),
        (Box((0.2, 0.4, 0.6)), from_rpy(math.pi / 2, 0.0, 0.0), 0.2),
        (CUBE, from_rpy(math.pi / 4, 0.0, 0.0), 0.1 * math.sqrt(2.0)),
        (TUBE, IDENTITY, 0.15),
        (TUBE, LYING, 0.06 * math.cos(math.pi / 96)),
        (torus(ring_radius=0.2, tube_radius=0.03), IDENTITY, 0.03),
        (Compound((Part(Sphere(0.1), (0.0, 0.0, -0.2)), Part(Sphere(0.1)))), from_rpy(math.pi, 0.0, 0.0), 0.1),
    ],
)
def test_the_height_on_flat_ground_is_that_of_the_lowest_point(shape, quat, height):
    assert support_height(shape, quat) == pytest.approx(height, rel=2e-3)


def test_what_is_over_its_ground_stands_and_what_is_beside_it_does_not():
    assert stands(Sphere(0.1)) and stands(TUBE) and stands(TUBE, LYING) and stands(CUBE)
    assert not stands(TUBE, from_rpy(0.0, 0.3, 0.0)) and not stands(CUBE, from_rpy(0.5, 0.0, 0.0))
    assert stands(CUBE, from_rpy(math.pi / 4, 0.0, 0.0)), "on an edge, balanced"
    assert not stands(Compound((Part(Sphere(0.1)), Part(Sphere(0.1), (0.3, 0.0, 0.0)))), from_rpy(0.0, 0.2, 0.0))
    assert stands(cone(height=0.4, bottom_radius=0.2)), "on its bottom"


def test_sizes_follow_the_formulas():
    assert bounding_radius(TUBE) == pytest.approx(math.hypot(0.15, 0.06))
    assert inner_radius(TUBE) == pytest.approx(0.06, rel=2e-3), "the bore counts as filled"
    assert smallest_thickness(TUBE) == pytest.approx(0.01, rel=0.05)
    assert smallest_thickness(Compound((Part(Sphere(0.2)), Part(Box((0.4, 0.02, 0.4)))))) == 0.02
    assert mean_frontal_area(Sphere(0.1)) == pytest.approx(math.pi * 0.01)
    assert mean_frontal_area(CUBE) == pytest.approx(mean_frontal_area(Box((0.2, 0.2, 0.2)))) == pytest.approx(0.06)
    assert mean_frontal_area(TUBE) == pytest.approx(mean_frontal_area(Cylinder(0.06, 0.3)), rel=5e-3)


def test_the_bounding_box_follows_turned_parts():
    low, high = bounding_box(Compound((Part(Cylinder(0.1, 0.4), (1.0, 0.0, 0.0), LYING),)))
    assert low == pytest.approx([0.8, -0.1, -0.1]) and high == pytest.approx([1.2, 0.1, 0.1])
    low, high = bounding_box(
        Compound((Part(CUBE, quat=from_rpy(0.0, 0.0, math.pi / 4)), Part(Box((0.1, 0.1, 0.6)), quat=LYING)))
    )
    assert high == pytest.approx([0.3, 0.1 * math.sqrt(2.0), 0.1])
    assert low == pytest.approx(-high)
