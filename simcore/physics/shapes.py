"""Collision shapes as plain records: what the field loader and the chassis hand to an engine.

Every shape is given in its own frame; its pose is given where it is added to a world.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from simcore.quantities import FIELD_PLACE, Quantity, require_fields, require_points
from simcore.typing import FloatArray, IntArray

__all__ = ["Box", "Compound", "Cylinder", "HalfSpace", "Hull", "Mesh", "Part", "Shape", "Sphere", "bounding_box"]

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
    """One member of a `Compound`, moved to its place without rotation."""

    shape: Sphere | Cylinder | Box | Hull
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Origin of the member in the frame of the whole [m]."""

    def __post_init__(self) -> None:
        require_fields(self, offset=(FIELD_PLACE,) * 3)


@dataclass(frozen=True, slots=True, eq=False)
class Compound:
    """Several convex shapes that move as one body and share one surface."""

    parts: tuple[Part, ...]


Shape: TypeAlias = Sphere | Cylinder | Box | HalfSpace | Hull | Mesh | Compound


def bounding_box(shape: Shape) -> tuple[FloatArray, FloatArray]:
    """Smallest and largest coordinates of a shape in its own frame [m], shape (3,) each."""
    if isinstance(shape, HalfSpace):
        return np.full(3, -np.inf), np.array([np.inf, np.inf, 0.0])
    if isinstance(shape, (Hull, Mesh)):
        corners = shape.points if isinstance(shape, Hull) else shape.vertices
        return corners.min(axis=0), corners.max(axis=0)
    if isinstance(shape, Compound):
        boxes = [(np.array(part.offset), *bounding_box(part.shape)) for part in shape.parts]
        low = np.min([offset + least for offset, least, _ in boxes], axis=0)
        return low, np.max([offset + most for offset, _, most in boxes], axis=0)
    if isinstance(shape, Sphere):
        half = np.full(3, shape.radius)
    elif isinstance(shape, Cylinder):
        half = np.array([shape.radius, shape.radius, 0.5 * shape.height])
    else:
        half = 0.5 * np.array(shape.size)
    return -half, half
