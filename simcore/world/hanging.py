"""Bodies that swing on a chain or turn about a hinge fixed to the field, pushed by robots and game pieces.

The engine connects a body to the pivot and moves the body like a game piece. This module adds the friction of a chain,
a torque that returns a body on a chain to zero yaw, the friction and spring of a hinge, the pull of climbers, and
sleep. A hinged body turns only about the hinge because the engine gets large moments of inertia about the other axes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from simcore.errors import ConfigError
from simcore.quantities import FIELD_LENGTH, FIELD_PLACE, MASS, Quantity, require_fields
from simcore.typing import Alliance
from simcore.world.contact_law import WALL, TerrainSurface
from simcore.world.rotation import Quaternion, Vector, cross, matrix, minus, rotate, rotate_back, yaw_of
from simcore.world.shapes import Box, Cylinder, Sphere, bounding_box, bounding_radius, mass_properties
from simcore.world.world import PhysicsWorld

__all__ = ["HangingBody", "HangingConfig"]

_DAMPING = Quantity("1/s", 0.0, 100.0)
_SPRING = Quantity("N m/rad", 0.0, 1e5)
_STILL_ANGLE, _STILL_RATE = 0.002, 0.005  # [rad], [rad/s]; 2 mm at the end of a chain of 1 m
_STILL_TIME = 0.5  # [s], time at rest before the body sleeps
_TOUCHING_SPEED = 0.3  # [m/s]; at lower speeds, the engine wakes touched bodies in time
_TWIST_RATE = 3.0  # [rad/s]; estimate: two chain links turn a body back within a second, without overshoot


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
        self.config = config
        self._engine = world.engine
        x, y, z = config.pivot
        self.row = world.add_hanging_body(
            config.name,
            config.shape,
            mass=config.mass,
            surface=config.surface,
            pos=(x, y, z - config.drop),
            pivot=config.pivot,
            hinge=config.hinge,
            drivable=config.drivable,
        )
        self._axis = 0 if config.hinge is None else "xy".index(config.hinge)
        across = config.mass * float(mass_properties(config.shape).inertia[self._axis, self._axis])
        self._inertia = across + config.mass * config.drop**2  # about the pivot [kg m^2]
        self._own_share = across / self._inertia
        self.radius = bounding_radius(config.shape)
        """Radius of a sphere around the center of mass that encloses the body [m]."""
        self._half = bounding_box(config.shape)[1]
        self._torque = (0.0, 0.0, 0.0)
        self._still = 0.0
        self.is_awake = False
        """Whether the body is awake."""
        self.pos: Vector = (x, y, z - config.drop)
        """Center of mass, field frame [m]."""
        self.quat: Quaternion = (0.0, 0.0, 0.0, 1.0)
        self.rate: Vector = (0.0, 0.0, 0.0)
        """Angular velocity, field frame [rad/s]."""
        self._engine.sleep(self.row)

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
        """Apply a force [N] at a point [m], field frame, in the next sub-step, and wake the body.

        The pivot supports the force component along the line from the point to the pivot.
        """
        tx, ty, tz = cross(self._arm(place), force)
        x, y, z = self._torque
        self._torque = (x + tx, y + ty, z + tz)
        self._wake()

    # --- motion ---------------------------------------------------------------------------------------------------

    def read(self) -> None:
        """Read the pose and angular velocity of an awake body from the engine.

        The method must run before climbers use the body.
        """
        if self.is_awake:
            self.pos, self.quat = self._engine.pose(self.row)
            vel, rate = self._engine.velocity(self.row)
            if self.config.hinge is not None:
                self.rate = self._about_hinge(rate[self._axis])
                return
            # The angular velocity comes from the angular momentum about the pivot: the joint conserves the momentum
            # even while position and velocity disagree.
            arm, own = self._arm(self.pos), self._own_share
            length2 = arm[0] ** 2 + arm[1] ** 2 + arm[2] ** 2
            along = (rate[0] * arm[0] + rate[1] * arm[1] + rate[2] * arm[2]) / length2
            x, y, z = cross(arm, vel)
            share = (1.0 - own) / length2
            self.rate = (
                share * x + own * (rate[0] - along * arm[0]) + along * arm[0],
                share * y + own * (rate[1] - along * arm[1]) + along * arm[1],
                share * z + own * (rate[2] - along * arm[2]) + along * arm[2],
            )

    def before_substep(self, h: float) -> None:
        """Apply the friction, the spring or yaw torque, and the pull of climbers for the next sub-step of h [s]."""
        if not self.is_awake:
            return
        arm = self._arm(self.pos)
        if self.config.hinge is not None:
            spring, axis = self.config.spring / self._inertia, self._axis
            kept = self.rate[axis] * math.exp(-self.config.damping * h)  # damping acts on the motion, not on the spring
            turn = kept + (self._torque[axis] / self._inertia - spring * self.angle) * h
            self.rate = self._about_hinge(turn / (1.0 + spring * h * h))
            self._engine.set_velocity(self.row, cross(self.rate, arm), self.rate)
            self._torque = (0.0, 0.0, 0.0)
            return
        length2 = arm[0] ** 2 + arm[1] ** 2 + arm[2] ** 2
        along = self.rate[0] * arm[0] + self.rate[1] * arm[1] + self.rate[2] * arm[2]
        keep = math.exp(-self.config.damping * h)
        twist = -along / math.sqrt(length2)  # about the line up to the pivot
        wanted = (twist - _TWIST_RATE**2 * yaw_of(self.quat) * h) / (1.0 + _TWIST_RATE * h) ** 2
        more = -wanted / math.sqrt(length2)
        rate = [keep * (w - along * a / length2) + more * a for w, a in zip(self.rate, arm, strict=True)]
        self.rate = (rate[0], rate[1], rate[2])
        self._engine.set_velocity(self.row, cross(self.rate, arm), self.rate)
        if self._torque != (0.0, 0.0, 0.0):
            fx, fy, fz = cross(self._torque, arm)
            self._engine.apply_forces([self.row], np.array([[fx, fy, fz]]) / length2)
            self._torque = (0.0, 0.0, 0.0)

    def after_tick(self, dt: float, *, in_reach: bool = True) -> None:
        """Wake a sleeping body that moves, wake a hinged body if `in_reach`, and let a body sleep after 0.5 s at rest.

        Args:
            dt: Length of the tick [s].
            in_reach: Whether any moving object could have touched the body.
        """
        is_hinged = self.config.hinge is not None
        if not self.is_awake:
            if in_reach and (is_hinged or any(map(any, self._engine.velocity(self.row)))):
                self._wake()
            return
        self.read()
        if is_hinged:  # a hinged body can rest at any angle, and a robot on it may be slow
            is_still = not in_reach and abs(self.rate[self._axis]) < _STILL_RATE
        else:
            x, y, _ = self._arm(self.pos)
            tilt = math.hypot(x, y) / self.config.drop
            is_still = max(tilt, abs(yaw_of(self.quat))) < _STILL_ANGLE and math.hypot(*self.rate) < _STILL_RATE
        self._still = self._still + dt if is_still else 0.0
        if self._still > _STILL_TIME:
            self.is_awake, self.rate = False, (0.0, 0.0, 0.0)
            self._engine.sleep(self.row)

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

    def _wake(self) -> None:
        if not self.is_awake:
            self.is_awake, self._still = True, 0.0
            self._engine.wake(self.row)

    def _about_hinge(self, rate: float) -> Vector:
        return (rate, 0.0, 0.0) if self._axis == 0 else (0.0, rate, 0.0)

    def _arm(self, place: Vector) -> Vector:
        return minus(place, self.config.pivot)

    def _from_pivot(self, arm: Vector) -> Vector:
        x, y, z = self.config.pivot
        return (x + arm[0], y + arm[1], z + arm[2])
