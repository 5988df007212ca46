"""The robot in the world: what it is driven by, and what the world makes of it.

Each sub-step the driver (a velocity to follow, forces, or a drivetrain model) asks for a change of velocity, no larger
than tires can give; the engine adds gravity, contacts and hits; what really came of it is what the driver sees next.
Poses are never forced.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from simcore.errors import ConfigError, EngineError, NonFiniteError
from simcore.geometry.rotation import Quaternion, Vector, from_yaw, matrix, rotate, rotate_back, rpy, yaw_of
from simcore.physics.substeps import Surroundings
from simcore.physics.world import PhysicsWorld
from simcore.robot.chassis_config import ChassisConfig
from simcore.typing import FloatArray

__all__ = ["ChassisSimulation", "Drivetrain"]

_CONTACT_GAP = 0.004  # [m]; a wheel this close to the ground carries load
_TIRE_LAG = 0.010  # [s]; treads and carpet give a little, so loads follow the chassis with a lag. Estimate, +-50 %
_MOST_RESISTANCE = 1.5  # [g]; more than any tire can push against for longer than a hit
_START_HEIGHT = -2e-5  # [m]; a gap of exactly 0 is no contact yet, and the first step would fall


class Drivetrain(Protocol):
    """What moves a chassis: tire forces from motors, seen from the robot frame."""

    def wheel_loads(self, touching: Sequence[bool], gravity: Vector, acceleration: Vector) -> list[float]:
        """Load of each wheel [N].

        Args:
            touching: Which wheels are on the ground.
            gravity: In robot axes [m/s^2].
            acceleration: Of the center of mass over the last sub-step, robot axes [m/s^2].
        """
        ...

    def step(
        self,
        h: float,
        vx: float,
        vy: float,
        omega: float,
        normal_loads: Sequence[float],
        ax: float,
        ay: float,
    ) -> tuple[float, float, float]:
        """Advance wheels and motors by h [s]; returns the change of velocity by tire forces [m/s, m/s, rad/s].

        Args:
            h: Step [s].
            vx: Velocity over ground of the point on the carpet under the center of mass, forward [m/s].
            vy: The same, to the left [m/s].
            omega: Yaw rate [rad/s].
            normal_loads: Load of each wheel [N], 0 in the air.
            ax: Acceleration that the world will add by itself (a slope, a wall that pushes back), forward [m/s^2].
            ay: The same, to the left [m/s^2].
        """
        ...


class ChassisSimulation:
    """A robot body, driven in one of three ways: by a velocity to follow, by forces, or by a drivetrain model.

    Args:
        world: Where it stands.
        config: Mass, shape and wheels.
        pose: Start, field frame [m, m, rad].
        drivetrain: A model of motors and tires; None: `follow_velocity` or `apply_forces` drive it.
        name: For messages.
    """

    def __init__(
        self,
        world: PhysicsWorld,
        config: ChassisConfig,
        *,
        pose: tuple[float, float, float] = (0.0, 0.0, 0.0),
        drivetrain: Drivetrain | None = None,
        name: str = "robot",
    ) -> None:
        self.config = config
        self.name = name
        self._world = world
        self._engine = world.engine
        self._drivetrain = drivetrain
        self._require_finite("pose", pose)
        self.row = world.add_robot_body(
            name,
            config.shape,
            mass=config.mass,
            surface=config.surface,
            center_of_mass=(0.0, 0.0, config.center_of_mass_height),
            inertia=config.inertia,
            pos=(pose[0], pose[1], _START_HEIGHT),
            quat=from_yaw(pose[2]),
        )
        self._target: tuple[float, float, float] | None = None
        self._force: Vector = (0.0, 0.0, 0.0)
        self._torque: Vector = (0.0, 0.0, 0.0)
        r = config.wheel_radius
        self._hubs = np.array([(x, y, r) for x, y in config.wheel_positions])
        self._soles = np.array([(x, y, -_CONTACT_GAP) for x, y in config.wheel_positions])
        self._all_touching = [True] * len(config.wheel_positions)
        self.touching = list(self._all_touching)
        """Which wheels are on the ground."""
        self.normal_loads = [0.0] * len(config.wheel_positions)
        """Load of each wheel in the last sub-step [N]."""
        self._vel_before: Vector = (0.0, 0.0, 0.0)
        self._h_before = 0.0
        self._vel_pushed: Sequence[float] = (0.0, 0.0, 0.0)
        self._acceleration: Sequence[float] = (0.0, 0.0, 0.0)
        self.pos: Vector = (0.0, 0.0, 0.0)
        """Point on the robot's underside where the carpet would be, field frame [m]."""
        self.quat: Quaternion = (0.0, 0.0, 0.0, 1.0)
        """Attitude."""
        self.vel: Vector = (0.0, 0.0, 0.0)
        """Velocity of the center of mass, field frame [m/s]."""
        self.rate: Vector = (0.0, 0.0, 0.0)
        """Angular velocity, field frame [rad/s]."""
        self.read()

    # --- driving ------------------------------------------------------------------------------------------------

    def follow_velocity(self, vx: float, vy: float, omega: float) -> None:
        """Follow a velocity, robot frame [m/s, m/s, rad/s], as fast as the tires allow; until the next command.

        Raises:
            ConfigError: A drivetrain moves this robot.
            NonFiniteError: A value is not finite; the last target stays.
        """
        if self._drivetrain is not None:
            raise ConfigError(f"{self.name}: its drivetrain moves it; command that, or build the chassis without one")
        self._require_finite("velocity to follow", (vx, vy, omega))
        self._target = (vx, vy, omega)

    def coast(self) -> None:
        """Follow nothing and push nothing."""
        self._target, self._force, self._torque = None, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)

    def apply_forces(self, force: Vector, torque: Vector = (0.0, 0.0, 0.0)) -> None:
        """Push at the center of mass, field frame [N, N m], until the next command.

        Raises:
            NonFiniteError: A value is not finite; the last forces stay.
        """
        self._require_finite("force", (*force, *torque))
        self._force, self._torque = force, torque

    def set_pose(self, x: float, y: float, yaw: float) -> None:
        """Put the robot somewhere on the carpet, at rest [m, m, rad]."""
        self._require_finite("pose", (x, y, yaw))
        self._world.set_pose(self.row, (x, y, _START_HEIGHT), from_yaw(yaw))
        self._h_before = 0.0
        self.read()

    # --- one sub-step -------------------------------------------------------------------------------------------

    def before_substep(self, h: float) -> None:
        """Ask the driver for its change of velocity, and put it on the body for the next sub-step of h [s]."""
        self.read()
        if self._drivetrain is not None:
            dvx, dvy, domega = self._drive(h)
        elif self._target is not None:
            dvx, dvy, domega = self._follow(h)
        else:
            dvx = dvy = domega = 0.0
        self._push(dvx, dvy, domega, h)
        self._h_before = h

    def read(self) -> None:
        """Take pose and velocity from the engine.

        Raises:
            EngineError: The engine lost the body (a value is not finite).
        """
        self.pos, self.quat = self._engine.pose(self.row)
        self.vel, self.rate = self._engine.velocity(self.row)
        if not all(map(math.isfinite, (*self.pos, *self.vel, *self.rate))):
            raise EngineError(f"{self.name}: the engine returned a pose or velocity that is not finite: {self.pos}")

    # --- questions ----------------------------------------------------------------------------------------------

    @property
    def pose(self) -> tuple[float, float, float]:
        """Position and heading, field frame [m, m, rad]."""
        return self.pos[0], self.pos[1], yaw_of(self.quat)

    @property
    def roll_pitch_yaw(self) -> Vector:
        """Attitude, WPILib's Rotation3d order [rad]."""
        return rpy(self.quat)

    @property
    def robot_rate(self) -> Vector:
        """Angular velocity, robot axes [rad/s]."""
        return rotate_back(self.quat, self.rate)

    @property
    def ground_velocity(self) -> tuple[float, float, float]:
        """Velocity of the point on the carpet under the center of mass, robot frame [m/s, m/s, rad/s]."""
        vx, vy, _ = rotate_back(self.quat, self.vel)
        wx, wy, wz = rotate_back(self.quat, self.rate)
        height = self.config.center_of_mass_height
        return vx - wy * height, vy + wx * height, wz

    @property
    def speed(self) -> float:
        """Speed of the fastest corner [m/s]."""
        reach = 0.5 * math.hypot(self.config.bumper_length, self.config.bumper_width)
        return math.hypot(*self.vel) + abs(self.rate[2]) * reach

    @property
    def origin_velocity(self) -> Vector:
        """Velocity of the point at `pos`, field frame [m/s]."""
        ax, ay, az = rotate(self.quat, (0.0, 0.0, -self.config.center_of_mass_height))
        (vx, vy, vz), (wx, wy, wz) = self.vel, self.rate
        return vx + wy * az - wz * ay, vy + wz * ax - wx * az, vz + wx * ay - wy * ax

    @property
    def footprint(self) -> tuple[float, float, float, float, float, float]:
        """What the pieces need to know: x, y, yaw, half length, half width [m, rad], speed of the box [m/s]."""
        x, y, yaw = self.pose
        return x, y, yaw, self.config.bumper_length / 2, self.config.bumper_width / 2, self.speed

    def wheel_ground(self) -> tuple[FloatArray, FloatArray]:
        """What is under the wheels.

        Returns:
            Lowest point of each wheel, field frame [m], shape (n, 3), and the height of what carries robots straight
            under it [m], shape (n,); 5 m below the wheel's axle where there is nothing.
        """
        soles = (self._soles + np.array((0.0, 0.0, _CONTACT_GAP))) @ matrix(self.quat).T + self.pos
        start = soles + np.array((0.0, 0.0, self.config.wheel_radius))
        hits = self._world.ground_rays(start, start - np.array((0.0, 0.0, 5.0)))
        return soles, start[:, 2] - 5.0 * hits.fraction

    def surroundings(self, dt: float) -> Surroundings:
        """What could be met within dt [s]."""
        reach = 0.5 * math.hypot(self.config.bumper_length, self.config.bumper_width) + self.speed * dt + 0.03
        x, y, z = self.pos
        low, high = (x - reach, y - reach, z + 0.01), (x + reach, y + reach, z + self.config.height)
        return self._world.surroundings(self.row, low, high)

    # --- inside -------------------------------------------------------------------------------------------------

    def _drive(self, h: float) -> Vector:
        assert self._drivetrain is not None
        self._find_ground()
        down = rotate_back(self.quat, (0.0, 0.0, -self._world.gravity))
        before = self._h_before
        if before > 0.0:
            measured = [(now - then) / before for now, then in zip(self.vel, self._vel_before, strict=True)]
            share = -math.expm1(-before / _TIRE_LAG)
            self._acceleration = [
                old + share * (new - old) for old, new in zip(self._acceleration, measured, strict=True)
            ]
            # What the world added to the tires' push in the last sub-step: a wall, a slope, another robot.
            world = [(now - then) / before for now, then in zip(self.vel, self._vel_pushed, strict=True)]
            ax, ay, _ = rotate_back(self.quat, world)
            size, most = math.hypot(ax, ay), _MOST_RESISTANCE * self._world.gravity
            if size > most:  # a hit lasts for one sub-step only
                ax, ay = ax * most / size, ay * most / size
        else:
            self._acceleration = [0.0, 0.0, 0.0]
            ax, ay = down[0], down[1]
        self.normal_loads = self._drivetrain.wheel_loads(
            self.touching, down, rotate_back(self.quat, self._acceleration)
        )
        self._vel_before = self.vel
        vx, vy, omega = self.ground_velocity
        return self._drivetrain.step(h, vx, vy, omega, self.normal_loads, ax, ay)

    def _follow(self, h: float) -> Vector:
        """Toward the target by no more than mu g h, and about the yaw axis by what the same grip can turn.

        The wheels that touch carry the whole weight between them, so grip is there in full until the last one lifts.
        """
        assert self._target is not None
        self._find_ground()
        grip = self.config.friction * self._world.gravity * h if any(self.touching) else 0.0
        vx, vy, omega = self.ground_velocity
        dvx, dvy, domega = self._target[0] - vx, self._target[1] - vy, self._target[2] - omega
        size = math.hypot(dvx, dvy)
        if size > grip:
            dvx, dvy = dvx * grip / size, dvy * grip / size
        spin = grip * self.config.mass * self.config.traction_radius / self.config.inertia[2]
        return dvx, dvy, max(-spin, min(spin, domega))

    def _push(self, dvx: float, dvy: float, domega: float, h: float) -> None:
        """Change the velocity of the body by forces on the carpet, in the robot's plane, and outside forces."""
        c = self.config
        ix, iy, iz = c.inertia
        lever = c.mass * c.center_of_mass_height
        change = rotate(self.quat, (dvx, dvy, 0.0))
        turn = rotate(self.quat, (lever * dvy / ix, -lever * dvx / iy, domega))  # grip acts below the center of mass
        scale = h / c.mass
        linear = [v + d + f * scale for v, d, f in zip(self.vel, change, self._force, strict=True)]
        angular = [w + d for w, d in zip(self.rate, turn, strict=True)]
        if self._torque != (0.0, 0.0, 0.0):
            tx, ty, tz = rotate_back(self.quat, self._torque)
            kick = rotate(self.quat, (tx * h / ix, ty * h / iy, tz * h / iz))
            angular = [w + k for w, k in zip(angular, kick, strict=True)]
        self._engine.set_velocity(self.row, linear, angular)
        self._vel_pushed = linear

    def _find_ground(self) -> None:
        """Which wheels touch: all of them on the flat carpet (no rays needed), else by a short ray down each wheel."""
        x, y, _, _ = self.quat
        if abs(self.pos[2]) < 0.002 and x * x + y * y < 1e-6:
            self.touching = self._all_touching
            return
        turn = matrix(self.quat).T
        start = self._hubs @ turn + self.pos
        end = self._soles @ turn + self.pos
        self.touching = (self._world.ground_rays(start, end).row >= 0).tolist()

    def _require_finite(self, what: str, values: Sequence[float]) -> None:
        if not all(map(math.isfinite, values)):
            raise NonFiniteError(f"{self.name}: {what} must be finite, got {tuple(values)}")
