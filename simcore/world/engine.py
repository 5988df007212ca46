"""Interface of a rigid-body engine, reduced to the functions that simcore needs.

`simcore.world.bullet` implements the interface on PyBullet, and `simcore.world.mujoco_engine` on MuJoCo. `row` is the
number of a body, as returned by `add_body`.
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
    """Shape, surface, mass properties, collision groups and initial pose of a rigid body."""

    shape: Shape
    surface: TerrainSurface
    mass: float = 0.0
    """Mass [kg]; 0 for a static."""
    center_of_mass: Vector = (0.0, 0.0, 0.0)
    """Center of mass in the frame of the shape [m]."""
    inertia: Vector | None = None
    """Principal moments of inertia about the center of mass [kg m^2]; None for a uniform solid."""
    inertia_axes: Quaternion = (0.0, 0.0, 0.0, 1.0)
    """Attitude of the principal axes in the frame of the shape, x, y, z, w."""
    group: int = 1
    """Collision group, a single bit."""
    mask: int = 0xFFFF
    """Bits of the groups with which the body can collide; two bodies collide if each mask contains the group of the
    other body."""
    pos: Vector = (0.0, 0.0, 0.0)
    """Origin of the shape, field frame [m]."""
    quat: Quaternion = (0.0, 0.0, 0.0, 1.0)
    """Attitude of the shape, field frame, x, y, z, w."""
    keeps_spin: bool = True
    """Whether the engine integrates free rotation to second order, to conserve the energy of a tumbling body."""


@dataclass(frozen=True, slots=True, eq=False)
class RayHits:
    """First hit of each of n rays, one element or row of each array per ray."""

    fraction: FloatArray
    """Fraction of the ray before the hit, 1.0 for no hit, shape (n,)."""
    row: IntArray
    """Row of the body that the ray hits, -1 without a hit, shape (n,)."""
    normal: FloatArray
    """Unit normal of the surface at the hit, field frame, shape (n, 3)."""


class Engine(Protocol):
    """Rigid-body world with gravity along -z.

    Engines integrate positions by semi-implicit Euler, x += h v with v at the end of the step.
    """

    name: str
    """Name of the engine in `engine_choice`."""
    gravity: float
    """Gravitational acceleration, downward [m/s^2]."""
    _definitions: list[BodyDefinition]
    """Definition of each body, by row."""

    def __enter__(self: _SomeEngine) -> _SomeEngine:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def add_body(self, definition: BodyDefinition) -> int:
        """Add a moving body or a static and return the row of the body."""
        ...

    def set_pose(self, row: int, pos: Sequence[float], quat: Sequence[float]) -> None:
        """Set the origin [m] and attitude of a body, field frame, and set the velocity to zero."""
        ...

    def set_velocity(self, row: int, linear: Sequence[float], angular: Sequence[float]) -> None:
        """Set the velocity of a body's center of mass [m/s] and the angular velocity [rad/s], field frame.

        A sleeping body does not wake.
        """
        ...

    def pose(self, row: int) -> tuple[Vector, Quaternion]:
        """Return the origin [m] and attitude of a body, field frame."""
        ...

    def state(self, row: int) -> tuple[float, ...]:
        """Return the state of a moving body as thirteen numbers, field frame.

        The numbers are center of mass [m], attitude of the principal axes x, y, z, w, linear velocity [m/s] and angular
        velocity [rad/s].
        """
        ...

    def velocity(self, row: int) -> tuple[Vector, Vector]:
        """Return the velocity of a body's center of mass [m/s] and the body's angular velocity [rad/s], field frame."""
        ...

    def centers(self, rows: Sequence[int]) -> FloatArray:
        """Return the centers of mass of moving bodies, field frame [m], shape (n, 3)."""
        return np.array([self.state(row)[:3] for row in rows]).reshape(-1, 3)

    def velocities(self, rows: Sequence[int]) -> FloatArray:
        """Return the linear and angular velocities of moving bodies, field frame [m/s, rad/s], shape (n, 6)."""
        return np.array([self.state(row)[7:] for row in rows]).reshape(-1, 6)

    def apply_forces(self, rows: Sequence[int], forces: FloatArray) -> None:
        """Apply forces at the centers of mass [N], shape (n, 3), field frame, for the next `step` only."""
        ...

    def wake(self, row: int) -> None:
        """Wake a sleeping or fixed body."""
        ...

    def sleep(self, row: int) -> None:
        """Stop a body; the body then sleeps until contact with an awake body, or until a call of `wake`."""
        ...

    def fix(self, row: int) -> None:
        """Stop a body; the body then acts as a static until a call of `wake` or `sleep`."""
        ...

    def depth(self, row: int) -> float:
        """Return the largest overlap of a body with statics at the current pose [m]; 0 without overlap."""
        ...

    def touching(self, row: int) -> list[int]:
        """Return the rows of the bodies that touched a body in the last step, in increasing order."""
        return sorted(set(self.contact_points(row)[0]))

    def contact_points(self, row: int) -> tuple[list[int], FloatArray]:
        """Return the contacts of a body in the last step.

        Returns:
            Row of the other body for each contact, and contact points on the other bodies, field frame [m], shape
            (n, 3).
        """
        ...

    def set_collision(self, row: int, group: int, mask: int) -> None:
        """Change the collision group and mask of a body; 0, 0 removes the body from all collisions."""
        ...

    def step(self, h: float) -> None:
        """Advance the world by h [s]."""
        ...

    def rays(self, start: FloatArray, end: FloatArray, mask: int) -> RayHits:
        """Find the first hit of each segment on bodies with a collision group in `mask`.

        Args:
            start: Starts of the segments, field frame [m], shape (n, 3).
            end: Ends of the segments, field frame [m], shape (n, 3).
            mask: Collision groups that the segments can hit.
        """
        ...

    def reset(self) -> None:
        """Remove all bodies and statics; the next body gets row 0."""
        ...

    def close(self) -> None:
        """Free all resources; a second call has no effect."""
        ...
