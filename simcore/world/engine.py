"""Interface of a rigid-body engine, as small as simcore needs it: bodies by row, arrays in, arrays out.

One module implements it on PyBullet, another on MuJoCo. A `row` is the number that `add_body` returned.
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
    """Definition of a rigid body."""

    shape: Shape
    surface: TerrainSurface
    mass: float = 0.0
    """Mass [kg]; 0 makes a static."""
    center_of_mass: Vector = (0.0, 0.0, 0.0)
    """Center of mass in the frame of the shape [m]."""
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
    """Whether the engine integrates free rotation to second order, which keeps the energy of a tumbling body."""
    pivot: Vector | None = None
    """Fixed point of a moving body, field frame [m]: the body turns about it; None: the body is free."""


@dataclass(frozen=True, slots=True, eq=False)
class RayHits:
    """First hits of rays, one row per ray."""

    fraction: FloatArray
    """Fraction of the ray before the hit, 1.0 for no hit, shape (n,)."""
    row: IntArray
    """Row of the body that was hit, -1 for none, shape (n,)."""
    normal: FloatArray
    """Surface normal at the hit, field frame, shape (n, 3)."""


class Engine(Protocol):
    """A rigid-body world with gravity along -z.

    Integrates positions by x += h v with the v of the end of the step (semi-implicit Euler).
    """

    name: str
    """Name in `engine_choice`."""
    gravity: float
    """Gravity, downward [m/s^2]."""
    _definitions: list[BodyDefinition]
    """Definitions by row."""

    def __enter__(self: _SomeEngine) -> _SomeEngine:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def add_body(self, definition: BodyDefinition) -> int:
        """Add a body or a static and return its row."""
        ...

    def set_pose(self, row: int, pos: Sequence[float], quat: Sequence[float]) -> None:
        """Place the origin of a body [m]; its velocity becomes zero."""
        ...

    def set_velocity(self, row: int, linear: Sequence[float], angular: Sequence[float]) -> None:
        """Set linear (center of mass) [m/s] and angular velocity [rad/s], field frame, without waking the body."""
        ...

    def set_mass(self, row: int, mass: float, center_of_mass: Vector, inertia: Vector) -> None:
        """Change mass [kg], center of mass in the frame of the shape [m] and principal moments [kg m^2] of a body.

        The pose of its origin stays, and so do the values of its velocity: they now apply to the new center. The body
        is awake, and its contacts are found again in the next step.
        """
        ...

    def pose(self, row: int) -> tuple[Vector, Quaternion]:
        """Return origin [m] and attitude of one body, field frame."""
        ...

    def state(self, row: int) -> tuple[float, ...]:
        """Return the state of a moving body as thirteen numbers, field frame.

        Center of mass [m], attitude of the principal axes, linear and angular velocity [m/s, rad/s].
        """
        ...

    def velocity(self, row: int) -> tuple[Vector, Vector]:
        """Return velocity of the center of mass [m/s] and angular velocity [rad/s] of one body, field frame."""
        ...

    def centers(self, rows: Sequence[int]) -> FloatArray:
        """Return centers of mass of moving bodies, field frame [m], shape (n, 3)."""
        return np.array([self.state(row)[:3] for row in rows]).reshape(-1, 3)

    def velocities(self, rows: Sequence[int]) -> FloatArray:
        """Return linear and angular velocities of moving bodies, field frame [m/s, rad/s], shape (n, 6)."""
        return np.array([self.state(row)[7:] for row in rows]).reshape(-1, 6)

    def apply_forces(self, rows: Sequence[int], forces: FloatArray) -> None:
        """Apply forces at the centers of mass [N], shape (n, 3), field frame, for the next `step` only."""
        ...

    def wake(self, row: int) -> None:
        """Let a body move again."""
        ...

    def sleep(self, row: int) -> None:
        """Freeze a body until a moving one touches it or it is woken; its velocity becomes zero."""
        ...

    def fix(self, row: int) -> None:
        """Freeze a body until it is woken or put to sleep; other bodies meet it as a static."""
        ...

    def overlap(self, row: int) -> float:
        """Return the body's deepest overlap with others in the last step [m]; 0 for none."""
        ...

    def depth(self, row: int) -> float:
        """Return the body's depth in statics at its present place, without a step [m]; 0 for none."""
        ...

    def touching(self, row: int) -> list[int]:
        """Return rows of the bodies that a body was in contact with in the last step."""
        return sorted(set(self.contact_points(row)[0]))

    def contact_points(self, row: int) -> tuple[list[int], FloatArray]:
        """Return the contacts of a body in the last step.

        Returns:
            Row of the other body for each contact, and contact point on it, field frame [m], shape (n, 3).
        """
        ...

    def set_collision(self, row: int, group: int, mask: int) -> None:
        """Change collision group and mask of a body; 0, 0 removes it from all collisions."""
        ...

    def step(self, h: float) -> None:
        """Advance by h [s]."""
        ...

    def rays(self, start: FloatArray, end: FloatArray, mask: int) -> RayHits:
        """Return the first hits of segments, (n, 3) each [m], on bodies whose group is in `mask`."""
        ...

    def overlapping(self, low: Sequence[float], high: Sequence[float]) -> list[int]:
        """Return rows of the bodies whose bounding boxes overlap a box [m]."""
        ...

    def reset(self) -> None:
        """Remove all bodies and statics; rows count from 0 again."""
        ...

    def close(self) -> None:
        """Free all resources; may be called twice."""
        ...
