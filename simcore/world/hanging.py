"""Bodies that swing on a chain or turn about a hinge fixed to the field, pushed by robots and game pieces.

The compiled loop moves these bodies (`simcore.loop.swing`). This module adds the pull of climbers, and sleep.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from simcore.errors import ConfigError, NonFiniteError
from simcore.loop.robot_state import Records
from simcore.quantities import FIELD_LENGTH, FIELD_PLACE, MASS, Quantity, require_fields
from simcore.typing import Alliance
from simcore.world.bodies import Pivot
from simcore.world.contact_law import WALL, TerrainSurface
from simcore.world.rotation import Quaternion, Vector, cross, matrix, minus, rotate, rotate_back, yaw_of
from simcore.world.shapes import Box, Cylinder, Sphere, bounding_box, bounding_radius
from simcore.world.world import PhysicsWorld

__all__ = ["HangingBody", "HangingConfig"]

_DAMPING = Quantity("1/s", 0.0, 100.0)
_SPRING = Quantity("N m/rad", 0.0, 1e5)
_STILL_ANGLE, _STILL_RATE = 0.002, 0.005  # [rad], [rad/s]; 2 mm at the end of a chain of 1 m
_STILL_TIME = 0.5  # [s], time at rest before the body sleeps
_TOUCHING_SPEED = 0.3  # [m/s]; at lower speeds, the engine wakes touched bodies in time


@dataclass(frozen=True, slots=True, kw_only=True)
class HangingConfig:
    """Config of a body on a chain or a hinge, for example a bar, or a seesaw that robots drive on."""

    name: str
    shape: Box | Cylinder | Sphere
    """Collision shape with the center of mass at the origin; at rest, the axes of the shape are the field axes."""
    mass: float
    """Mass [kg]."""
    pivot: Vector
    """Fixed end of the chain, or center of the hinge, field frame [m]."""
    drop: float
    """Distance from the pivot down to the center of mass [m]. A hinge can also be at the center of mass (0) or below
    the center of mass (negative)."""
    hinge: Literal["x", "y"] | None = None
    """Axis of the hinge; None for a body on a chain. Carpet and field elements are the end stops of a hinge."""
    spring: float = 0.0
    """Stiffness of the spring that returns a hinged body to the rest position [N m/rad]."""
    drivable: bool = False
    """Whether robots drive on the body; only a hinged body can be drivable."""
    alliance: Alliance | None = None
    """Alliance of the body; None for a neutral body."""
    surface: TerrainSurface = WALL
    damping: float = 0.3
    """Decay rate of the angular velocity by friction and drag [1/s]; the amplitude of a swing decays at half this
    rate."""

    def __post_init__(self) -> None:
        owner = f"HangingConfig {self.name!r}"
        drop = FIELD_LENGTH if self.hinge is None else FIELD_PLACE
        require_fields(self, owner, mass=MASS, pivot=(FIELD_PLACE,) * 3, drop=drop, damping=_DAMPING, spring=_SPRING)
        if self.hinge not in (None, "x", "y"):
            raise ConfigError(f"{owner}: hinge must be along 'x' or 'y', or None for a chain, got {self.hinge!r}")
        if self.hinge is None and (self.spring or self.drivable):
            raise ConfigError(f"{owner}: only a body with a hinge can have a spring or carry robots")


class HangingBody:
    """Body on a chain or hinge in a world; the body starts at rest and sleeps until another object touches the body.

    Args:
        world: World with the field.
        config: Config of the body.
    """

    def __init__(self, world: PhysicsWorld, config: HangingConfig) -> None:
        self.config, self._bodies = config, world.bodies
        x, y, z = config.pivot
        self.row = world.add_hanging_body(
            config.name,
            config.shape,
            mass=config.mass,
            surface=config.surface,
            pos=(x, y, z - config.drop),
            pivot=Pivot(config.pivot, config.hinge, config.spring, config.damping),
            drivable=config.drivable,
        )
        self._axis = 0 if config.hinge is None else "xy".index(config.hinge)
        self._inertia = float(self._record["model"]["inertia"][0, self._axis])  # about the pivot [kg m^2]
        self.radius = bounding_radius(config.shape)
        """Radius of a sphere around the center of mass that encloses the body [m]."""
        self._half = bounding_box(config.shape)[1]
        self._still = 0.0

    @property
    def _record(self) -> Records:
        return self._bodies.of(self.row)

    @property
    def is_awake(self) -> bool:
        """Whether the body is awake; contact with a moving object wakes the body."""
        return bool(self._record["is_awake"][0])

    @property
    def pos(self) -> Vector:
        """Center of mass, field frame [m]."""
        x, y, z = self._record["pos"][0].tolist()
        return x, y, z

    @property
    def quat(self) -> Quaternion:
        """Attitude, field frame."""
        x, y, z, w = self._record["quat"][0].tolist()
        return x, y, z, w

    @property
    def rate(self) -> Vector:
        """Angular velocity, field frame [rad/s]."""
        x, y, z = self._record["rate"][0].tolist()
        return x, y, z

    # --- interface for climbers -----------------------------------------------------------------------------------

    def to_rest(self, place: Vector) -> Vector:
        """Map the present position of a body point to the point's position at rest, field frame [m]."""
        return self._from_pivot(rotate_back(self.quat, self._arm(place)))

    def from_rest(self, place: Vector) -> Vector:
        """Map the position at rest of a body point to the point's present position, field frame [m]."""
        return self._from_pivot(rotate(self.quat, self._arm(place)))

    def velocity_at(self, place: Vector) -> Vector:
        """Return the velocity of the body point at the present position `place` [m], field frame [m/s]."""
        return cross(self.rate, self._arm(place))

    def mobility_at(self, place: Vector) -> float:
        """Return the inverse effective mass at a point [1/kg], for a force perpendicular to the line to the pivot."""
        arm = self._arm(place)
        return (arm[0] ** 2 + arm[1] ** 2 + arm[2] ** 2) / self._inertia

    def pull(self, place: Vector, force: Vector) -> None:
        """Apply a force [N] at a point [m], field frame, in the next step of 5 ms, and wake the body.

        The pivot supports the force component along the line from the point to the pivot, and takes the torque about
        the line from the center of mass of a body on a chain to the pivot.

        Raises:
            NonFiniteError: If the force is not finite.
        """
        if not all(map(math.isfinite, force)):
            raise NonFiniteError(f"{self.config.name}: a force must be finite [N], got {force}")
        record, torque = self._record[0], np.array(cross(self._arm(place), force))
        self._still = 0.0
        if self.config.hinge is None:
            arm = np.array(self._arm(self.pos))
            torque -= arm * (torque @ arm) / (arm @ arm)
        record["torque"] += torque
        record["is_awake"] = 1

    # --- motion ---------------------------------------------------------------------------------------------------

    def after_tick(self, dt: float) -> None:
        """Let a body sleep after 0.5 s at rest without contact, after a tick of dt [s]."""
        record = self._record[0]
        if not record["is_awake"]:
            self._still = 0.0
            return
        is_still = math.hypot(*self.rate) < _STILL_RATE and not record["impulse"].any()
        if self.config.hinge is None:  # a hinged body can rest at any angle
            x, y, _ = self._arm(self.pos)
            is_still = is_still and max(math.hypot(x, y) / self.config.drop, abs(yaw_of(self.quat))) < _STILL_ANGLE
        self._still = self._still + dt if is_still else 0.0
        if self._still > _STILL_TIME:
            record["is_awake"], record["rate"] = 0, 0.0

    @property
    def angle(self) -> float:
        """Angle of the hinge from the rest position, about the positive axis [rad]; for hinged bodies only."""
        return 2.0 * math.atan2(self.quat[self._axis], self.quat[3])

    @property
    def speed(self) -> float:
        """Upper bound on the speed of any point of the body [m/s]."""
        return math.hypot(*self.rate) * (abs(self.config.drop) + self.radius)

    @property
    def footprint(self) -> tuple[float, float, float, float, float, float, tuple[float, float], float]:
        """Extent and speed of the body, for the search for game pieces to wake.

        The values are x, y, yaw [m, m, rad], half length and half width [m], speed [m/s], heights of the lowest and
        highest point [m], and a threshold speed [m/s]. Below this speed, the body wakes only pieces in contact. Without
        the threshold the body would keep near pieces awake for half a minute, the duration of a swing.
        """
        dx, dy, dz = (np.abs(matrix(self.quat)) @ self._half).tolist()
        x, y, z = self.pos
        return x, y, 0.0, dx, dy, self.speed, (z - dz, z + dz), _TOUCHING_SPEED

    def _arm(self, place: Vector) -> Vector:
        return minus(place, self.config.pivot)

    def _from_pivot(self, arm: Vector) -> Vector:
        x, y, z = self.config.pivot
        return (x + arm[0], y + arm[1], z + arm[2])
