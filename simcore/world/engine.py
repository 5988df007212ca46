"""What simcore needs from a rigid-body engine, and nothing more: bodies by row, arrays in, arrays out.

One module implements it on PyBullet, another on MuJoCo. A `row` is the number that `add_body` gave.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np

from simcore.typing import FloatArray, IntArray
from simcore.world.contact_law import TerrainSurface
from simcore.world.rotation import Quaternion, Vector
from simcore.world.shapes import Shape

__all__ = ["BodyDefinition", "Engine", "RayHits"]

_SomeEngine = TypeVar("_SomeEngine", bound="Engine")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BodyDefinition:
    """A rigid body to be made."""

    shape: Shape
    surface: TerrainSurface
    mass: float = 0.0
    """Mass [kg]; 0 makes a static."""
    center_of_mass: Vector = (0.0, 0.0, 0.0)
    """In the frame of the shape [m]."""
    inertia: Vector | None = None
    """Principal moments about the center of mass [kg m^2]; None: a uniform solid."""
    inertia_axes: Quaternion = (0.0, 0.0, 0.0, 1.0)
    """Attitude of the principal axes in the frame of the shape, x, y, z, w."""
    group: int = 1
    """Collision group, one bit."""
    mask: int = 0xFFFF
    """Groups to collide with; two bodies touch when each has the other's group in its mask."""
    pos: Vector = (0.0, 0.0, 0.0)
    """Origin of the shape, field frame [m]."""
    quat: Quaternion = (0.0, 0.0, 0.0, 1.0)
    keeps_spin: bool = True
    """Whether a body that tumbles in the air keeps its energy to second order."""
    pivot: Vector | None = None
    """A place of a moving body that stays where it is, field frame [m]: the body turns about it; None: it is free."""


@dataclass(frozen=True, slots=True, eq=False)
class RayHits:
    """What some rays met first, one row a ray."""

    fraction: FloatArray
    """Part of the ray before the hit, 1.0 where nothing was met, shape (n,)."""
    row: IntArray
    """Row of the body met, -1 for none, shape (n,)."""
    normal: FloatArray
    """Surface normal at the hit, field frame, shape (n, 3)."""


class Engine(Protocol):
    """A rigid-body world with gravity along -z.

    It takes x += h v with v already moved to the end of the step (semi-implicit Euler).
    """

    name: str
    """As `engine_choice` knows it."""
    gravity: float
    """[m/s^2]"""
    _definitions: list[BodyDefinition]
    """By row."""

    def __enter__(self: _SomeEngine) -> _SomeEngine:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def add_body(self, definition: BodyDefinition) -> int:
        """Make a body or a static; returns its row."""
        ...

    def set_pose(self, row: int, pos: Sequence[float], quat: Sequence[float]) -> None:
        """Put the origin of a body somewhere [m]; its velocity becomes zero."""
        ...

    def set_velocity(self, row: int, linear: Sequence[float], angular: Sequence[float]) -> None:
        """Velocity of the center of mass [m/s] and angular velocity [rad/s], field frame. Does not wake it."""
        ...

    def set_mass(self, row: int, mass: float, center_of_mass: Vector, inertia: Vector) -> None:
        """Change mass [kg], center of mass in the frame of the shape [m] and principal moments [kg m^2] of a body.

        The pose of its origin stays, and so do the numbers of its velocity: from now on they are those of the new
        center. It is awake, and what it touches is found anew in the next step.
        """
        ...

    def pose(self, row: int) -> tuple[Vector, Quaternion]:
        """Origin [m] and attitude of one body, field frame."""
        ...

    def state(self, row: int) -> tuple[float, ...]:
        """Center of mass [m], attitude of the principal axes and velocities [m/s, rad/s] of a moving body, field frame.

        Thirteen numbers: what the loop of robots asks for in each step.
        """
        ...

    def velocity(self, row: int) -> tuple[Vector, Vector]:
        """Velocity of the center of mass [m/s] and angular velocity [rad/s] of one body, field frame."""
        ...

    def centers(self, rows: Sequence[int]) -> FloatArray:
        """Centers of mass of moving bodies, field frame [m], shape (n, 3)."""
        return np.array([self.state(row)[:3] for row in rows]).reshape(-1, 3)

    def velocities(self, rows: Sequence[int]) -> FloatArray:
        """Linear and angular velocities of moving bodies, field frame [m/s, rad/s], shape (n, 6)."""
        return np.array([self.state(row)[7:] for row in rows]).reshape(-1, 6)

    def apply_forces(self, rows: Sequence[int], forces: FloatArray) -> None:
        """Forces at the centers of mass [N], shape (n, 3), field frame, for the next `step` only."""
        ...

    def wake(self, row: int) -> None:
        """Let a body move again."""
        ...

    def sleep(self, row: int) -> None:
        """Freeze a body until it is touched by a moving one or woken; its velocity becomes zero."""
        ...

    def fix(self, row: int) -> None:
        """Freeze a body until it is woken, or put to sleep; what touches it meets a static."""
        ...

    def overlap(self, row: int) -> float:
        """How deep the body is in others, at its deepest contact in the last step [m]; 0 for none."""
        ...

    def depth(self, row: int) -> float:
        """How deep a body is in statics where it is now, whether it has been in a step there or not [m]; 0 for none."""
        ...

    def touching(self, row: int) -> list[int]:
        """Rows of the bodies that a body was in contact with in the last step."""
        return sorted(set(self.contact_points(row)[0]))

    def contact_points(self, row: int) -> tuple[list[int], FloatArray]:
        """Where a body was in contact in the last step.

        Returns:
            Row of the other body, for each contact, and place on it, field frame [m], shape (n, 3).
        """
        ...

    def set_collision(self, row: int, group: int, mask: int) -> None:
        """Change with what a body collides; 0, 0 takes it out of the world."""
        ...

    def step(self, h: float) -> None:
        """Advance by h [s]."""
        ...

    def rays(self, start: FloatArray, end: FloatArray, mask: int) -> RayHits:
        """First hits of segments, (n, 3) each [m], on bodies whose group is in `mask`."""
        ...

    def overlapping(self, low: Sequence[float], high: Sequence[float]) -> list[int]:
        """Rows of the bodies whose bounding boxes overlap a box [m]."""
        ...

    def reset(self) -> None:
        """Remove all bodies and statics; rows count from 0 again."""
        ...

    def close(self) -> None:
        """Free everything; may be called twice."""
        ...
