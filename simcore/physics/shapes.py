"""Collision shapes as plain records: what the field loader and the chassis hand to an engine.

Every shape is given in its own frame; its pose is given where it is added to a world.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

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
    "parts_of",
]

_LENGTH = Quantity("m", 0.0, 2000.0, is_open=True)  # the floor of a world is that long


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


def bounding_box(shape: Shape) -> tuple[FloatArray, FloatArray]:
    """Smallest and largest coordinates of a shape in its own frame [m], shape (3,) each."""
    if isinstance(shape, HalfSpace):
        return np.full(3, -np.inf), np.array([np.inf, np.inf, 0.0])
    if isinstance(shape, (Hull, Mesh)):
        corners = shape.points if isinstance(shape, Hull) else shape.vertices
        return corners.min(axis=0), corners.max(axis=0)
    if isinstance(shape, Compound):
        boxes = [(np.array(part.offset), *_turned_box(part)) for part in shape.parts]
        least = np.min([offset + low for offset, low, _ in boxes], axis=0)
        return least, np.max([offset + high for offset, _, high in boxes], axis=0)
    if isinstance(shape, Sphere):
        half = np.full(3, shape.radius)
    elif isinstance(shape, Cylinder):
        half = np.array([shape.radius, shape.radius, 0.5 * shape.height])
    else:
        half = 0.5 * np.array(shape.size)
    return -half, half


def _turned_box(part: Part) -> tuple[FloatArray, FloatArray]:
    """Bounding box of a member about its own origin, along the axes of the whole [m]."""
    if part.quat == IDENTITY:
        return bounding_box(part.shape)
    axes, shape = matrix(part.quat), part.shape
    if isinstance(shape, Hull):
        corners = shape.points @ axes.T
        return corners.min(axis=0), corners.max(axis=0)
    if isinstance(shape, Sphere):
        half = np.full(3, shape.radius)
    elif isinstance(shape, Cylinder):
        half = shape.radius * np.sqrt(np.maximum(1.0 - axes[:, 2] ** 2, 0.0)) + 0.5 * shape.height * np.abs(axes[:, 2])
    else:
        half = np.abs(axes) @ (0.5 * np.array(shape.size))
    return -half, half
