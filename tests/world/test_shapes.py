"""Collision shapes: those without volume are refused; their reach and stability follow from their geometry."""

import math

import numpy as np
import pytest
from each_case import each

from simcore.errors import ConfigError
from simcore.world.rotation import IDENTITY, from_rpy, matrix
from simcore.world.shapes import (
    Box,
    Compound,
    Cylinder,
    Hull,
    Mesh,
    Part,
    Sphere,
    bounding_box,
    bounding_radius,
    centered,
    cone,
    inner_radius,
    mass_properties,
    mean_frontal_area,
    principal_axes,
    smallest_thickness,
    stands,
    support_height,
    torus,
    tube,
)


@each("value", [0.0, -0.1, math.nan, math.inf])
def test_lengths_must_be_positive_numbers(value):
    with pytest.raises(ConfigError, match="Sphere: radius"):
        Sphere(value)
    with pytest.raises(ConfigError, match="Cylinder: radius"):
        Cylinder(value, 1.0)
    with pytest.raises(ConfigError, match="Cylinder: height"):
        Cylinder(1.0, value)
    with pytest.raises(ConfigError, match=r"Box: size\[1\] must be a number above 0 and up to 2000 m"):
        Box((1.0, value, 1.0))


@each(
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


def test_shapes_with_equal_dimensions_compare_and_hash_equal():
    assert Sphere(0.1) == Sphere(0.1)
    assert hash(Box((1.0, 2.0, 3.0))) == hash(Box((1.0, 2.0, 3.0)))


TUBE = tube(length=0.3, outer_radius=0.06, inner_radius=0.05)
LYING = from_rpy(0.0, math.pi / 2, 0.0)
CUBE = Hull(np.array([[x, y, z] for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.1, 0.1)]))


@each(
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
def test_the_support_height_is_set_by_the_lowest_point(shape, quat, height):
    assert support_height(shape, quat) == pytest.approx(height, rel=2e-3)


def test_a_shape_stands_if_its_center_is_above_its_base():
    assert stands(Sphere(0.1)) and stands(TUBE) and stands(TUBE, LYING) and stands(CUBE)
    assert not stands(TUBE, from_rpy(0.0, 0.3, 0.0)) and not stands(CUBE, from_rpy(0.5, 0.0, 0.0))
    assert stands(CUBE, from_rpy(math.pi / 4, 0.0, 0.0)), "on an edge, balanced"
    assert not stands(Compound((Part(Sphere(0.1)), Part(Sphere(0.1), (0.3, 0.0, 0.0)))), from_rpy(0.0, 0.2, 0.0))
    assert stands(cone(height=0.4, bottom_radius=0.2)), "on its bottom"


def test_radius_thickness_and_frontal_area_of_shapes_follow_their_formulas():
    assert bounding_radius(TUBE) == pytest.approx(math.hypot(0.15, 0.06))
    assert inner_radius(TUBE) == pytest.approx(0.06, rel=2e-3), "the bore counts as filled"
    assert smallest_thickness(TUBE) == pytest.approx(0.01, rel=0.05)
    assert smallest_thickness(Compound((Part(Sphere(0.2)), Part(Box((0.4, 0.02, 0.4)))))) == 0.02
    assert mean_frontal_area(Sphere(0.1)) == pytest.approx(math.pi * 0.01)
    assert mean_frontal_area(CUBE) == pytest.approx(mean_frontal_area(Box((0.2, 0.2, 0.2)))) == pytest.approx(0.06)
    assert mean_frontal_area(TUBE) == pytest.approx(mean_frontal_area(Cylinder(0.06, 0.3)), rel=5e-3)


def test_the_bounding_box_includes_rotated_parts():
    low, high = bounding_box(Compound((Part(Cylinder(0.1, 0.4), (1.0, 0.0, 0.0), LYING),)))
    assert low == pytest.approx([0.8, -0.1, -0.1]) and high == pytest.approx([1.2, 0.1, 0.1])
    low, high = bounding_box(
        Compound((Part(CUBE, quat=from_rpy(0.0, 0.0, math.pi / 4)), Part(Box((0.1, 0.1, 0.6)), quat=LYING)))
    )
    assert high == pytest.approx([0.3, 0.1 * math.sqrt(2.0), 0.1])
    assert low == pytest.approx(-high)


# --- inertia of solids, compared with their formulas ------------------------------------------------------------------


CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


def test_a_tube_has_the_inertia_of_a_hollow_cylinder():
    """m (a^2 + b^2) / 2 and m (3 (a^2 + b^2) + h^2) / 12; the bore is a polygon with 2 % more area than its circle.

    The halves of its staves overlap in the middle, where the mass counts twice: 3 % less across.
    """
    a, b, h = 0.1016 / 2, 0.1143 / 2, 0.3016
    found = mass_properties(tube(length=h, outer_radius=b, inner_radius=a))
    across = (3.0 * (a * a + b * b) + h * h) / 12.0
    assert found.inertia[2, 2] == pytest.approx((a * a + b * b) / 2.0, rel=0.01)
    assert np.diag(found.inertia)[:2] == pytest.approx(across, rel=0.03)
    assert np.abs(found.inertia - np.diag(np.diag(found.inertia))).max() < 1e-9
    assert found.center == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    assert found.volume == pytest.approx(math.pi * (b * b - a * a) * h, rel=0.12)


def test_the_hull_of_a_boxs_corners_has_the_mass_properties_of_the_box_anywhere():
    turn, size = matrix(from_rpy(0.4, -0.8, 1.1)), np.array([0.2, 0.5, 0.9])
    hull = mass_properties(Hull(CORNERS * size @ turn.T + (1.0, 2.0, 3.0)))
    box = mass_properties(Box((0.2, 0.5, 0.9)))
    assert hull.center == pytest.approx([1.0, 2.0, 3.0])
    assert hull.volume == pytest.approx(box.volume)
    assert hull.inertia == pytest.approx(turn @ box.inertia @ turn.T, abs=1e-12)
    moments, axes = principal_axes(hull.inertia)
    assert sorted(moments) == pytest.approx(sorted(np.diag(box.inertia)))
    again = matrix(axes) @ np.diag(moments) @ matrix(axes).T
    assert again == pytest.approx(hull.inertia, abs=1e-12) and np.linalg.det(matrix(axes)) == pytest.approx(1.0)


def test_a_cone_and_a_torus_have_the_textbook_moments_of_inertia():
    """Cone: 3/10 r^2 and 3/20 (r^2 + h^2 / 4), center at h / 4. Torus: R^2 + 3/4 r^2 and R^2 / 2 + 5/8 r^2."""
    found = mass_properties(cone(height=0.4, bottom_radius=0.2, sides=48))
    assert np.diag(found.inertia) == pytest.approx([0.15 * (0.04 + 0.04)] * 2 + [0.3 * 0.04], rel=0.02)
    assert bounding_box(cone(height=0.4, bottom_radius=0.2))[0][2] == pytest.approx(-0.1, rel=0.01)
    ring = np.diag(mass_properties(torus(ring_radius=0.15, tube_radius=0.025, segments=16)).inertia)
    across = 0.15**2 / 2.0 + 5.0 / 8.0 * 0.025**2
    assert ring == pytest.approx([across, across, 0.15**2 + 0.75 * 0.025**2], rel=0.05)


def test_the_mass_properties_of_a_compound_include_its_rotated_parts():
    cross = Compound((Part(Cylinder(0.05, 0.4)), Part(Cylinder(0.05, 0.4), quat=from_rpy(math.pi / 2, 0.0, 0.0))))
    one = np.diag(mass_properties(Cylinder(0.05, 0.4)).inertia)
    assert np.diag(mass_properties(cross).inertia) == pytest.approx(
        [one[0], (one[0] + one[2]) / 2, (one[0] + one[2]) / 2]
    )
    high, low = Part(Sphere(0.1), (0.0, 0.0, 0.5)), Part(Sphere(0.1), (0.0, 0.0, 0.1))
    shape = centered(Compound((high, low)))
    assert mass_properties(shape).center == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    assert bounding_box(shape)[1][2] == pytest.approx(0.3)


def test_a_shape_without_volume_is_refused():
    with pytest.raises(ConfigError, match="Mesh has no volume"):
        mass_properties(Mesh(np.eye(3), np.array([[0, 1, 2]])))
    with pytest.raises(ConfigError, match="one plane"):
        mass_properties(Hull(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]])))


@each(
    ("make", "words"),
    [
        (lambda: tube(length=0.3, outer_radius=0.05, inner_radius=0.05), "leaves no wall"),
        (lambda: tube(length=0.3, outer_radius=0.05, inner_radius=0.03, staves=3), "parts of a ring, got 3"),
        (lambda: torus(ring_radius=0.1, tube_radius=0.2), "ring_radius must be above"),
        (lambda: cone(height=0.1, bottom_radius=0.1, top_radius=-1.0), "top_radius must be a number from 0"),
        (lambda: Part(Mesh(np.eye(3), np.array([[0, 1, 2]]))), "got a Mesh"),
        (lambda: Part(Sphere(0.1), quat=(0.0, 0.0, 0.0, 2.0)), "unit quaternion"),
        (lambda: Compound(()), "at least one part"),
    ],
)
def test_invalid_shapes_are_refused(make, words):
    with pytest.raises(ConfigError, match=words):
        make()
