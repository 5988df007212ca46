"""How far shapes reach: their corners, their smallest thickness, and how they stand on flat ground."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from scipy.spatial import ConvexHull, HalfspaceIntersection, QhullError

from simcore.errors import ConfigError
from simcore.geometry.rotation import IDENTITY, Quaternion, matrix
from simcore.physics.shapes import (
    Box,
    Compound,
    Cylinder,
    HalfSpace,
    Hull,
    Mesh,
    Part,
    Shape,
    Sphere,
    bounding_box,
    parts_of,
    support,
)
from simcore.typing import FloatArray

__all__ = [
    "bounding_radius",
    "inner_radius",
    "mean_frontal_area",
    "outline",
    "outline_points",
    "round_radius",
    "shrunk",
    "smallest_thickness",
    "stands",
    "support_height",
]

_RING = 24  # points of a round outline
_ROUND = 0.99  # least share of its radius that something round has everywhere
_TOUCHES = 0.001  # [m]; points this much above the lowest one carry the shape, too
_OVER = 0.002  # [m]; how far the center may be beside what carries it
_DIRECTIONS: FloatArray = np.array([np.cos(np.arange(72) * math.tau / 72), np.sin(np.arange(72) * math.tau / 72)])


def outline_points(shape: Shape) -> FloatArray:
    """Points whose convex hull is the shape (round ones as a ring of 24), in its own frame [m], shape (n, 3)."""
    if isinstance(shape, Box):
        corners = np.array(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5])).reshape(3, -1).T
        return np.asarray(corners * np.array(shape.size))
    if isinstance(shape, Hull):
        return shape.points
    if isinstance(shape, Mesh):
        return shape.vertices
    if isinstance(shape, Compound):
        return np.vstack(
            [outline_points(part.shape) @ matrix(part.quat).T + np.array(part.offset) for part in shape.parts]
        )
    if isinstance(shape, HalfSpace):
        raise ConfigError("a half space has no outline; a field's floor belongs to the world, not to its elements")
    angle = np.arange(_RING) * math.tau / _RING
    half = shape.height / 2.0 if isinstance(shape, Cylinder) else shape.radius
    ring = shape.radius * np.column_stack([np.cos(angle), np.sin(angle)])
    return np.vstack([np.column_stack([ring, np.full(_RING, z)]) for z in (-half, half)])


def outline(points: FloatArray) -> FloatArray:
    """Corners of the convex hull of points in a plane, counter-clockwise, shape (n, 2); the ends of a line."""
    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except QhullError:
        return np.asarray(points[np.lexsort((points[:, 1], points[:, 0]))[[0, -1]]])


@lru_cache(maxsize=256)
def bounding_radius(shape: Shape) -> float:
    """Radius of the smallest ball around the origin that holds the shape [m]."""
    if isinstance(shape, Sphere):
        return shape.radius
    if isinstance(shape, Compound):
        return max([_reach(part) for part in shape.parts])
    return float(np.linalg.norm(outline_points(shape), axis=1).max())


@lru_cache(maxsize=256)
def inner_radius(shape: Shape) -> float:
    """Radius of the largest ball around the origin within the shape's convex hull [m]."""
    if isinstance(shape, Sphere):
        return shape.radius
    if isinstance(shape, Cylinder):
        return min(shape.radius, shape.height / 2.0)
    if isinstance(shape, Box):
        return min(shape.size) / 2.0
    return float(-ConvexHull(outline_points(shape)).equations[:, 3].max())


@lru_cache(maxsize=256)
def round_radius(shape: Shape) -> float | None:
    """Radius about z with which a shape rolls on its side [m]; None: it is not round.

    >>> round_radius(Cylinder(0.1, 0.3)), round_radius(Box((0.1, 0.1, 0.3)))
    (0.1, None)
    """
    if isinstance(shape, Sphere | Cylinder):
        return shape.radius
    if isinstance(shape, HalfSpace | Mesh):
        return None
    low, high = bounding_box(shape)
    points = outline_points(shape)
    ends = [outline(points[np.abs(points[:, 2] - z) < _TOUCHES][:, :2]) for z in (low[2], high[2])]
    radii = [np.linalg.norm(end, axis=1).max() for end in ends]
    inner = [np.linalg.norm(0.5 * (end + np.roll(end, 1, axis=0)), axis=1).min() for end in ends]
    return float(max(radii)) if min(inner) > _ROUND * max(radii) else None


@lru_cache(maxsize=256)
def smallest_thickness(shape: Shape) -> float:
    """Of the thinnest part, between two parallel planes of which one is along a face [m]."""
    if isinstance(shape, Sphere):
        return 2.0 * shape.radius
    if isinstance(shape, Cylinder):
        return min(2.0 * shape.radius, shape.height)
    if isinstance(shape, Box):
        return min(shape.size)
    if isinstance(shape, Compound):
        return min([smallest_thickness(part.shape) for part in shape.parts])
    points = outline_points(shape)
    height = points @ ConvexHull(points).equations[:, :3].T
    return float((height.max(axis=0) - height.min(axis=0)).min())


def shrunk(shape: Shape, by: float) -> Shape:
    """The same shape with each of its faces moved inward [m], but by no more than a quarter of its thickness.

    A mesh or half space stays as it is.
    """
    if isinstance(shape, Mesh | HalfSpace):
        return shape
    if isinstance(shape, Compound):
        return Compound(tuple(Part(_shrunk(part.shape, by), part.offset, part.quat) for part in shape.parts))
    return _shrunk(shape, by)


def _shrunk(shape: Sphere | Cylinder | Box | Hull, by: float) -> Sphere | Cylinder | Box | Hull:
    """The same of a convex shape."""
    if isinstance(shape, Box):
        length, width, height = [size - 2.0 * min(by, 0.25 * size) for size in shape.size]
        return Box((length, width, height))
    by = min(by, 0.25 * smallest_thickness(shape))
    if isinstance(shape, Sphere):
        return Sphere(shape.radius - by)
    if isinstance(shape, Cylinder):
        return Cylinder(shape.radius - by, shape.height - 2.0 * by)
    planes = np.unique(ConvexHull(shape.points).equations.round(12), axis=0)
    planes[:, 3] += by
    return Hull(HalfspaceIntersection(planes, shape.points.mean(axis=0)).intersections)


@lru_cache(maxsize=256)
def mean_frontal_area(shape: Shape) -> float:
    """Area of the shadow of the shape's convex hull, the mean over all directions: a quarter of its surface [m^2].

    Source: A. Cauchy, 1841; exact for convex bodies, so also for a ball: pi r^2.
    """
    if isinstance(shape, Sphere):
        return math.pi * shape.radius**2
    if isinstance(shape, Cylinder):
        return 0.5 * math.pi * shape.radius * (shape.radius + shape.height)
    if isinstance(shape, Box):
        x, y, z = shape.size
        return 0.5 * (x * y + y * z + z * x)
    return float(ConvexHull(outline_points(shape)).area) / 4.0


def support_height(shape: Shape, quat: Quaternion = IDENTITY) -> float:
    """Height of the origin over flat ground that the shape touches in an attitude [m]."""
    return float(support(shape, -matrix(quat)[2:])[0])


def stands(shape: Shape, quat: Quaternion = IDENTITY) -> bool:
    """Whether the shape stays in an attitude on flat ground: its origin is above what carries it."""
    parts = parts_of(shape)
    axes = matrix(quat)
    points = np.vstack([_low_points(part, axes) for part in parts])
    carrying = points[points[:, 2] < points[:, 2].min() + _TOUCHES, :2]
    return bool((carrying @ _DIRECTIONS).min(axis=0).max() < _OVER)


def _low_points(part: Part, axes: FloatArray) -> FloatArray:
    """Points of which some carry a member of a shape whose axes are turned, about the shape's origin."""
    origin = axes @ np.array(part.offset)
    if isinstance(part.shape, Sphere):
        return np.array([origin - (0.0, 0.0, part.shape.radius)])
    turned: FloatArray = outline_points(part.shape) @ (axes @ matrix(part.quat)).T + origin
    return turned


def _reach(part: Part) -> float:
    """Farthest that a member has from the origin of the whole [m]."""
    if isinstance(part.shape, Sphere):
        return math.hypot(*part.offset) + part.shape.radius
    return float(np.linalg.norm(outline_points(part.shape) @ matrix(part.quat).T + part.offset, axis=1).max())
