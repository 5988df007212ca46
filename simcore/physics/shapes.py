"""Collision shapes as plain records, and how far they reach: corners, thickness, and how they stand on flat ground.

Every shape is given in its own frame; its pose is given where it is added to a world.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from simcore.errors import ConfigError
from simcore.geometry.rotation import IDENTITY, Quaternion, matrix
from simcore.quantities import FIELD_PLACE, Quantity, require_attitude, require_fields, require_points
from simcore.typing import FloatArray, IntArray

__all__ = [
    "Box",
    "Compound",
    "Cylinder",
    "HalfSpace",
    "Hull",
    "Mesh",
    "Part",
    "Shape",
    "Sphere",
    "bounding_box",
    "bounding_radius",
    "inner_radius",
    "mean_frontal_area",
    "outline",
    "outline_points",
    "parts_of",
    "round_radius",
    "smallest_thickness",
    "stands",
    "support",
    "support_height",
]

_LENGTH = Quantity("m", 0.0, 2000.0, is_open=True)  # the floor of a world is that long
_RING = 24  # points of a round outline
_ROUND = 0.99  # least share of its radius that something round has everywhere
_TOUCHES = 0.001  # [m]; points this much above the lowest one carry the shape, too
_OVER = 0.002  # [m]; how far the center may be beside what carries it
_DIRECTIONS: FloatArray = np.array([np.cos(np.arange(72) * math.tau / 72), np.sin(np.arange(72) * math.tau / 72)])


@dataclass(frozen=True, slots=True)
class Sphere:
    """A ball around the origin."""

    radius: float
    """Radius [m]."""

    def __post_init__(self) -> None:
        require_fields(self, radius=_LENGTH)


@dataclass(frozen=True, slots=True)
class HalfSpace:
    """Everything below z = 0; for statics only. The cheapest floor for pieces, but driven boxes sink into it."""


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder along z, centered at the origin."""

    radius: float
    """Radius [m]."""
    height: float
    """Whole height [m]."""

    def __post_init__(self) -> None:
        require_fields(self, radius=_LENGTH, height=_LENGTH)


@dataclass(frozen=True, slots=True)
class Box:
    """A box centered at the origin."""

    size: tuple[float, float, float]
    """Whole edge lengths along x, y and z [m]."""

    def __post_init__(self) -> None:
        require_fields(self, size=(_LENGTH,) * 3)


@dataclass(frozen=True, slots=True, eq=False)
class Hull:
    """The convex hull of some points."""

    points: FloatArray
    """Corners [m], shape (n, 3), n >= 4."""

    def __post_init__(self) -> None:
        require_points("Hull", "points", self.points, FIELD_PLACE, least=4)


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """A triangle mesh, two-sided; for statics only. Slower and leakier than the shapes above."""

    vertices: FloatArray
    """Vertices [m], shape (n, 3)."""
    faces: IntArray
    """Vertex rows of each triangle, shape (m, 3)."""

    def __post_init__(self) -> None:
        require_points("Mesh", "vertices", self.vertices, FIELD_PLACE, least=3)
        require_points("Mesh", "faces", self.faces, Quantity("", 0, len(self.vertices) - 1, is_whole=True), least=1)


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """One member of a `Compound`, at its place and attitude."""

    shape: Sphere | Cylinder | Box | Hull
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Origin of the member in the frame of the whole [m]."""
    quat: Quaternion = IDENTITY
    """Its attitude there, x, y, z, w, a unit quaternion."""

    def __post_init__(self) -> None:
        if not isinstance(self.shape, Sphere | Cylinder | Box | Hull):
            name = type(self.shape).__name__
            raise ConfigError(f"Part: a member is a Sphere, Cylinder, Box or Hull, got a {name}")
        require_attitude("Part", "quat", self.quat)
        require_fields(self, offset=(FIELD_PLACE,) * 3)


@dataclass(frozen=True, slots=True, eq=False)
class Compound:
    """Several convex shapes that move as one body and share one surface."""

    parts: tuple[Part, ...]

    def __post_init__(self) -> None:
        if not self.parts:
            raise ConfigError("Compound: it needs at least one part")


Shape: TypeAlias = Sphere | Cylinder | Box | HalfSpace | Hull | Mesh | Compound


def parts_of(shape: Shape) -> tuple[Part, ...]:
    """The convex members of a shape; a shape that is one itself is its own."""
    if isinstance(shape, Compound):
        return shape.parts
    if isinstance(shape, HalfSpace | Mesh):
        raise ConfigError(f"a {type(shape).__name__} can only be a static")
    return (Part(shape),)


def support(shape: Shape, ways: FloatArray) -> FloatArray:
    """How far a shape reaches from its origin along unit vectors, shape (n, 3) [m], shape (n,)."""
    if isinstance(shape, Compound):
        reach = [support(p.shape, ways @ matrix(p.quat)) + ways @ np.array(p.offset) for p in shape.parts]
        return np.asarray(np.max(reach, axis=0))
    if isinstance(shape, Sphere):
        return np.full(len(ways), shape.radius)
    if isinstance(shape, Cylinder):
        x, y, z = ways.T
        return np.asarray(0.5 * shape.height * np.abs(z) + shape.radius * np.hypot(x, y))
    if isinstance(shape, Box):
        return np.abs(ways) @ (0.5 * np.array(shape.size))
    if isinstance(shape, HalfSpace):
        return np.where(ways[:, 2] > 1.0 - 1e-12, 0.0, np.inf)
    return np.asarray((ways @ (shape.points if isinstance(shape, Hull) else shape.vertices).T).max(axis=1))


def bounding_box(shape: Shape) -> tuple[FloatArray, FloatArray]:
    """Smallest and largest coordinates of a shape in its own frame [m], shape (3,) each."""
    return -support(shape, -np.eye(3)), support(shape, np.eye(3))


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
