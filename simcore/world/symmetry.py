"""Symmetry of a field between blue and red.

A game defines robots, scripts and zones for blue. The red half of a field is the blue half, either rotated by
180 degrees about the center (`rotate`) or mirrored across the center line (`mirror`). The name `flip_pose` follows
PathPlanner's `FlippingUtil`.
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
"""Planar pose: x, y and heading, field frame [m, m, rad]."""


@dataclass(frozen=True, slots=True)
class FieldSymmetry:
    """Map between corresponding points of the two halves of a field.

    >>> FieldSymmetry("rotate", (16.0, 8.0)).flip_pose(2.0, 3.0, 0.0)[:2]
    (14.0, 5.0)
    >>> FieldSymmetry("mirror", (16.0, 8.0)).flip_pose(2.0, 3.0, 0.0)[:2]
    (14.0, 3.0)
    """

    kind: Literal["rotate", "mirror"]
    """Kind of symmetry: rotation by 180 degrees about the center, or reflection in the plane x = length / 2."""
    size: tuple[float, float]
    """Length and width of the field [m]."""

    def __post_init__(self) -> None:
        require_fields(self, size=(FIELD_LENGTH, FIELD_LENGTH))

    @property
    def keeps_hands(self) -> bool:
        """Whether the map preserves left and right: True for a rotated field, False for a mirrored field."""
        return self.kind == "rotate"

    def flip_point(self, x: float, y: float) -> tuple[float, float]:
        """Return the corresponding point on the other half of the field [m]."""
        return self.size[0] - x, (self.size[1] - y if self.kind == "rotate" else y)

    def points_of(self, alliance: str, *points: Vector) -> tuple[Vector, ...]:
        """Return the points of `alliance` that correspond to the given blue points, field frame [m].

        >>> FieldSymmetry("rotate", (16.0, 8.0)).points_of("red", (2.0, 3.0, 0.5))
        ((14.0, 5.0, 0.5),)
        """
        return tuple((*self.flip_point(x, y), z) for x, y, z in points) if alliance == "red" else points

    def box_of(self, alliance: str, low: Vector, high: Vector) -> tuple[Vector, Vector]:
        """Return the low and high corners of the box of `alliance` that corresponds to a blue box, field frame [m]."""
        (x0, y0, z0), (x1, y1, z1) = self.points_of(alliance, low, high)
        return (min(x0, x1), min(y0, y1), z0), (max(x0, x1), max(y0, y1), z1)

    def flip_pose(self, x: float, y: float, yaw: float) -> Pose:
        """Return the corresponding planar pose on the other half of the field [m, m, rad], yaw within -pi..pi."""
        turned = yaw + math.pi if self.kind == "rotate" else math.pi - yaw
        return (*self.flip_point(x, y), wrap_angle(turned))

    def flip_points(self, points: FloatArray) -> FloatArray:
        """Return the corresponding points on the other half of the field [m], shape (n, 2) or (n, 3); z is the same."""
        flipped = points.copy()
        flipped[:, 0] = self.size[0] - points[:, 0]
        if self.kind == "rotate":
            flipped[:, 1] = self.size[1] - points[:, 1]
        return flipped

    def flip_vectors(self, vectors: FloatArray) -> FloatArray:
        """Return the corresponding velocities or directions, shape (n, 2) or (n, 3); z is the same."""
        flipped = vectors.copy()
        flipped[:, 0] = -vectors[:, 0]
        if self.kind == "rotate":
            flipped[:, 1] = -vectors[:, 1]
        return flipped

    def flip_attitudes(self, attitudes: FloatArray) -> FloatArray:
        """Return the corresponding attitudes, quaternions x, y, z, w, shape (n, 4).

        On a mirrored field, the result is correct only for objects that are symmetric about their own y-z plane.
        """
        x, y, z, w = np.asarray(attitudes, dtype=float).T
        return np.column_stack((-y, x, w, -z) if self.kind == "rotate" else (x, -y, -z, w))
