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
    "support",
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
