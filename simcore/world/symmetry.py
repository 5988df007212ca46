"""Symmetry of a field between blue and red.

Robots, scripts and zones are written for blue. A field is either rotated by 180 degrees about its center (`rotate`),
or mirrored in the plane at half its length (`mirror`). `flip_pose` is named after PathPlanner's `FlippingUtil`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from simcore.quantities import FIELD_LENGTH, require_fields
from simcore.typing import FloatArray
from simcore.world.rotation import Vector, wrap_angle

__all__ = ["FieldSymmetry", "Pose"]

Pose = tuple[float, float, float]
"""Planar pose: position and heading, field frame [m, m, rad]."""


@dataclass(frozen=True, slots=True)
class FieldSymmetry:
    """Map between corresponding places of the two halves of a field.

    >>> FieldSymmetry("rotate", (16.0, 8.0)).flip_pose(2.0, 3.0, 0.0)[:2]
    (14.0, 5.0)
    >>> FieldSymmetry("mirror", (16.0, 8.0)).flip_pose(2.0, 3.0, 0.0)[:2]
    (14.0, 3.0)
    """

    kind: Literal["rotate", "mirror"]
    """Rotation by 180 degrees about the center, or mirror in the plane x = length / 2."""
    size: tuple[float, float]
    """Length and width of the field [m]."""

    def __post_init__(self) -> None:
        require_fields(self, size=(FIELD_LENGTH, FIELD_LENGTH))

    @property
    def keeps_hands(self) -> bool:
        """Whether left stays left: true for a rotated field, false for a mirrored one."""
        return self.kind == "rotate"

    def flip_point(self, x: float, y: float) -> tuple[float, float]:
        """Return the place that corresponds to a place [m]."""
        return self.size[0] - x, (self.size[1] - y if self.kind == "rotate" else y)

    def points_of(self, alliance: str, *points: Vector) -> tuple[Vector, ...]:
        """Return blue's places [m] as an alliance has them.

        >>> FieldSymmetry("rotate", (16.0, 8.0)).points_of("red", (2.0, 3.0, 0.5))
        ((14.0, 5.0, 0.5),)
        """
        return tuple((*self.flip_point(x, y), z) for x, y, z in points) if alliance == "red" else points

    def box_of(self, alliance: str, low: Vector, high: Vector) -> tuple[Vector, Vector]:
        """Return the smallest and largest corner of blue's box [m] as an alliance has it."""
        (x0, y0, z0), (x1, y1, z1) = self.points_of(alliance, low, high)
        return (min(x0, x1), min(y0, y1), z0), (max(x0, x1), max(y0, y1), z1)

    def flip_pose(self, x: float, y: float, yaw: float) -> Pose:
        """Return the planar pose that corresponds to a pose [m, m, rad]."""
        turned = yaw + math.pi if self.kind == "rotate" else math.pi - yaw
        return (*self.flip_point(x, y), wrap_angle(turned))

    def flip_points(self, points: FloatArray) -> FloatArray:
        """Return the places that correspond to places of shape (n, 2) or (n, 3) [m]; z stays."""
        flipped = points.copy()
        flipped[:, 0] = self.size[0] - points[:, 0]
        if self.kind == "rotate":
            flipped[:, 1] = self.size[1] - points[:, 1]
        return flipped

    def flip_vectors(self, vectors: FloatArray) -> FloatArray:
        """Return the velocities or directions that correspond to vectors of shape (n, 2) or (n, 3); z stays."""
        flipped = vectors.copy()
        flipped[:, 0] = -vectors[:, 0]
        if self.kind == "rotate":
            flipped[:, 1] = -vectors[:, 1]
        return flipped

    def flip_attitudes(self, attitudes: FloatArray) -> FloatArray:
        """Return the attitudes that correspond to attitudes, quaternions x, y, z, w of shape (n, 4).

        On a mirrored field they are those of mirrored objects, which look equal if their halves are equal.
        """
        x, y, z, w = np.asarray(attitudes, dtype=float).T
        return np.column_stack((-y, x, w, -z) if self.kind == "rotate" else (x, -y, -z, w))
