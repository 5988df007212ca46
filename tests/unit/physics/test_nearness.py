"""Nearness to elements of the field, by their bounding boxes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simcore.geometry.rotation import IDENTITY, from_yaw, rotate
from simcore.physics.nearness import PlanOutlines, StaticBoxes
from simcore.physics.shapes import Box, Compound, Cylinder, Hull, Part, Sphere, bounding_box

COORDINATES = st.floats(-5.0, 5.0)


def near(boxes: StaticBoxes, place, reach: float) -> bool:
    return bool(boxes.are_near(np.array([place], dtype=float), np.array([reach]))[0])


def test_distance_is_to_the_nearest_face_edge_or_corner():
    boxes = StaticBoxes()
    boxes.add(Box((2.0, 2.0, 2.0)), (1.0, 0.0, 0.0), IDENTITY)
    for place, gap in (((3.0, 0.0, 0.0), 1.0), ((3.0, 2.0, 0.0), math.sqrt(2.0)), ((3.0, 2.0, 2.0), math.sqrt(3.0))):
        assert near(boxes, place, gap + 1e-9)
        assert not near(boxes, place, gap - 1e-9)
    assert near(boxes, (1.0, 0.0, 0.0), 1e-6), "inside"


@given(x=COORDINATES, y=COORDINATES, yaw=st.floats(-math.pi, math.pi))
def test_a_turned_box_is_never_missed(x, y, yaw):
    boxes = StaticBoxes()
    boxes.add(Box((3.0, 0.2, 1.0)), (0.5, -0.5, 0.0), from_yaw(yaw))
    for corner in ((1.5, 0.1), (1.5, -0.1), (-1.5, 0.1), (-1.5, -0.1)):
        there = np.add(rotate(from_yaw(yaw), (*corner, 0.0)), (0.5, -0.5, 0.0))
        away = math.hypot(x - there[0], y - there[1])
        assert near(boxes, (x, y, 0.0), away + 1e-6)


def test_many_places_are_answered_in_their_order_and_nothing_is_near_nothing():
    boxes = StaticBoxes()
    places, reach = np.array([[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.6, 0.0, 0.0]]), np.array([0.1, 0.1, 0.05])
    assert boxes.are_near(places, reach).tolist() == [False] * 3
    boxes.add(Sphere(0.5), (0.0, 0.0, 0.0), IDENTITY)
    assert boxes.are_near(places, reach).tolist() == [True, False, False]
    assert boxes.are_near(places[:0], reach[:0]).tolist() == []


@given(data=st.data())
def test_distances_are_those_to_each_box_by_itself(data):
    middles = data.draw(st.lists(st.tuples(COORDINATES, COORDINATES, COORDINATES), min_size=1, max_size=4))
    boxes, alone = StaticBoxes(), []
    for middle in middles:
        boxes.add(Box((1.0, 0.3, 0.5)), middle, IDENTITY)
        one = StaticBoxes()
        one.add(Box((1.0, 0.3, 0.5)), middle, IDENTITY)
        alone.append(one)
    far = st.floats(-30.0, 30.0)
    x, y, z, reach = data.draw(st.tuples(far, far, COORDINATES, st.floats(0.01, 40.0)))
    half = np.array((0.5, 0.15, 0.25))
    low, high = np.array(middles) - half, np.array(middles) + half
    away = np.maximum(np.maximum(low - (x, y, z), (x, y, z) - high), 0.0)
    distance = np.sqrt(np.square(away).sum(axis=1)).min()
    if abs(distance - reach) > 1e-9:
        assert near(boxes, (x, y, z), reach) == (distance < reach)
    assert near(boxes, (x, y, z), reach) == any(near(one, (x, y, z), reach) for one in alone)
    flat = np.hypot(away[:, 0], away[:, 1]).min()
    if abs(flat - reach) > 1e-9:
        assert boxes.is_clear(x, y, reach) == (flat > reach)


@pytest.mark.parametrize(
    ("shape", "low", "high"),
    [
        (Sphere(0.5), (-0.5,) * 3, (0.5,) * 3),
        (Cylinder(0.5, 2.0), (-0.5, -0.5, -1.0), (0.5, 0.5, 1.0)),
        (Box((1.0, 2.0, 3.0)), (-0.5, -1.0, -1.5), (0.5, 1.0, 1.5)),
        (Hull(np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3.0]])), (0, 0, 0), (1, 2, 3)),
        (Compound((Part(Sphere(0.1), (1.0, 0.0, 0.0)), Part(Box((0.2, 0.2, 0.2))))), (-0.1,) * 3, (1.1, 0.1, 0.1)),
    ],
)
def test_bounding_boxes_of_shapes(shape, low, high):
    found = bounding_box(shape)
    assert np.allclose(found[0], low) and np.allclose(found[1], high)


# --- which elements an upright box may meet, by their outlines from above -------------------------------------------


WEDGE = Hull(np.array([[x, y, z] for x, y in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)) for z in (0.0, 0.5)]))


def outlines() -> PlanOutlines:
    found = PlanOutlines()
    found.add(Box((1.0, 1.0, 1.0)), (5.0, 5.0, 0.5), IDENTITY)
    found.add(WEDGE, (0.0, 0.0, 0.0), IDENTITY)
    return found


def test_a_box_meets_what_its_sides_and_height_reach():
    assert outlines().met(4.0, 5.0, 0.0, 0.6, 0.1, 0.0, 1.0).tolist() == [True, False]
    assert outlines().met(4.0, 5.0, 0.0, 0.4, 0.1, 0.0, 1.0).tolist() == [False, False]
    assert outlines().met(4.0, 5.0, 0.0, 0.6, 0.1, 1.2, 1.4).tolist() == [False, False]
    assert PlanOutlines().met(0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 1.0).tolist() == []


def test_a_box_along_a_slanting_side_is_not_met():
    """Its own axes part it from the wedge's long side, which the field's axes do not."""
    x = y = 0.5 + 0.3 / math.sqrt(2.0)
    assert outlines().met(x, y, math.pi / 4, 0.25, 0.8, 0.0, 1.0).tolist() == [False, False]
    assert outlines().met(x, y, math.pi / 4, 0.32, 0.8, 0.0, 1.0).tolist() == [False, True]
    assert outlines().met(x, y, 0.0, 0.8, 0.8, 0.0, 1.0)[1]
