"""The robot in the world: what it is driven by, and what the world makes of it.

In each step of the loop tires and bumpers let it move in its plane (`simcore.loop.robots`); the engine adds gravity,
ramps and pieces; what really came of it is what tires and motors see next. Poses are never forced.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from simcore.errors import ConfigError, NonFiniteError
from simcore.geometry.rotation import Quaternion, Vector, from_yaw, rotate, rotate_back, rpy, yaw_of
from simcore.physics.world import PhysicsWorld
from simcore.quantities import POSE, require_row
from simcore.robot.chassis_config import ChassisConfig
from simcore.robot.mass_distribution import MassDistribution
from simcore.robot.shaft import ShaftSim
from simcore.robot.wheel_ground import WheelGround
from simcore.robot.wheeled_drive import WheeledDrive
from simcore.typing import FloatArray

__all__ = ["ChassisSimulation"]

_ZERO: Vector = (0.0, 0.0, 0.0)
_BESIDE = 0.01  # [m]; ramps that are farther from its wheels than this and the way of a tick are not met in it


class ChassisSimulation:
    """A robot body, driven in one of three ways: by a velocity to follow, by forces, or by a drivetrain model.

    Args:
        world: Where it stands.
        config: Mass, shape and wheels.
        pose: Start, field frame [m, m, rad].
        drivetrain: A model of motors and tires; None: `follow_velocity` or `apply_forces` drive it.
        mechanisms: What else turns on the robot, and takes current from its battery.
        name: For messages.
        mass: Mass, center and inertia of the whole robot as it starts; None: as the config says.
    """

    def __init__(
        self,
        world: PhysicsWorld,
        config: ChassisConfig,
        *,
        pose: tuple[float, float, float] = (0.0, 0.0, 0.0),
        drivetrain: WheeledDrive[Any] | None = None,
        mechanisms: Sequence[ShaftSim] = (),
        name: str = "robot",
        mass: MassDistribution | None = None,
    ) -> None:
        self.config = config
        self.distribution = mass or MassDistribution(
            config.mass, (0.0, 0.0, config.center_of_mass_height), config.inertia
        )
        """With what it holds and as its mechanisms stand; see `set_mass`."""
        self.name = name
        self._world = world
        self._engine = world.engine
        self._drivetrain = drivetrain
        self._require_finite("pose", pose)
        self.row = world.add_robot_body(
            name,
            config.shape,
            mass=self.distribution.mass,
            surface=config.surface,
            center_of_mass=self.distribution.center,
            inertia=self.distribution.inertia,
            bumpers=config.bumpers,
            pos=(pose[0], pose[1], 0.0),
            quat=from_yaw(pose[2]),
        )
        self._target: tuple[float, float, float] | None = None
        self.needs_steps = False
        """Whether a velocity is followed."""
        self._ground = WheelGround(world, self.row, config)
        world.set_pose(self.row, *self._ground.standing(*pose))
        self._half_diagonal = 0.5 * math.hypot(config.bumper_length, config.bumper_width)
        self._dynamics, self._number = world.robots, len(world.robot_rows) - 1
        self._dynamics.bind(self._number, self, drivetrain, mechanisms)
        self._set_mass()
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
        self._target, self.needs_steps = (vx, vy, omega), True

    def coast(self) -> None:
        """Follow nothing and push nothing."""
        self._target, self.needs_steps = None, False
        record = self._record
        record["force"], record["torque"] = _ZERO, _ZERO

    def apply_forces(self, force: Vector, torque: Vector = _ZERO) -> None:
        """Push at the center of mass, field frame [N, N m], until the next command.

        Raises:
            NonFiniteError: A value is not finite; the last forces stay.
        """
        self._require_finite("force", (*force, *torque))
        self._record["force"], self._record["torque"] = force, torque

    def set_pose(self, x: float, y: float, yaw: float) -> None:
        """Put the robot somewhere at rest, on the carpet or on what robots drive over [m, m, rad].

        Raises:
            NonFiniteError: A value is not finite; the robot stays.
            ConfigError: One is on no field; the robot stays.
        """
        self._require_finite("pose", (x, y, yaw))
        require_row(self.name, "pose", (x, y, yaw), POSE)
        self._world.set_pose(self.row, *self._ground.standing(x, y, yaw))
        record = self._record
        for name in ("h_before", "rest", "followed", "tires", "contact_load"):
            record[name] = 0.0
        self.read()

    def set_mass(self, mass: MassDistribution, vel: Vector, rate: Vector) -> None:
        """Take in another mass, center and inertia, between two steps; its body stays where it is.

        Args:
            mass: From now on.
            vel: Of the new center of mass, field frame [m/s].
            rate: Angular velocity, field frame [rad/s].
        """
        self.distribution, self.vel, self.rate = mass, vel, rate
        self._set_mass()
        self._engine.set_mass(self.row, mass.mass, mass.center, mass.inertia)
        self._world.balls.set_mass(self.row, mass.mass, mass.center, mass.inertia)
        self._engine.set_velocity(self.row, vel, rate)
        self._record["h_before"], self._record["rest"] = 0.0, 0.0

    def _set_mass(self) -> None:
        """Tell record and drivetrain what the robot weighs."""
        mass, center, inertia = self.distribution
        if self._drivetrain is not None:
            self._drivetrain.set_mass_properties(mass, inertia[2], center)
        (cx, cy, _), (xs, ys) = center, zip(*self.config.wheel_positions, strict=True)
        record = self._record
        record["mass"], record["center"], record["inertia"] = mass, center, inertia
        record["half_base"] = max(0.0, min(max(xs) - cx, cx - min(xs), max(ys) - cy, cy - min(ys)))

    # --- one step -----------------------------------------------------------------------------------------------

    @property
    def _record(self) -> Any:
        """Of this robot, in the arrays of the loop."""
        return self._dynamics.robots[self._number]

    def before_step(self, h: float, *, is_level: bool) -> None:
        """Which wheels touch, and what drives a chassis without wheels, before a step of the loop of h [s]."""
        record = self._record
        if is_level:
            self._ground.stand()
        else:
            self._ground.find(tuple(record["pos"].tolist()), tuple(record["quat"].tolist()))
        if self._drivetrain is not None:
            self._drivetrain.wheel_records["is_down"] = self._ground.touching
        elif self._target is not None:
            record["drive"] = self._follow(h, record)

    def begin_tick(self, dt: float) -> None:
        """See whether there will be nothing but the floor under its wheels for dt [s]."""
        self._record["is_on_flat"] = self._world.is_flat(
            self.pos[0], self.pos[1], self._ground.reach + dt * math.hypot(*self.vel[:2]) + _BESIDE
        )

    def read(self) -> None:
        """Take pose and velocity from the engine, with what is to be added to it.

        Raises:
            EngineError: The engine lost the body (a value is not finite).
        """
        self._dynamics.look(self._number)
        record = self._record
        x, y, z, a, b, c, d, vx, vy, vz, wx, wy, wz = record["seen"].tolist()
        rx, ry, rz, qx, qy, qz = record["rest"].tolist()
        px, py, pz = rotate((a, b, c, d), self.distribution.center)
        self.pos, self.quat = (x - px, y - py, z - pz), (a, b, c, d)
        self.vel, self.rate = (vx + rx, vy + ry, vz + rz), (wx + qx, wy + qy, wz + qz)

    # --- questions ----------------------------------------------------------------------------------------------

    @property
    def normal_loads(self) -> list[float]:
        """Load of each wheel in the last sub-step [N]; zeros without a drivetrain."""
        return [0.0] * len(self._ground.touching) if self._drivetrain is None else self._drivetrain.normal_loads

    @property
    def touching(self) -> list[bool]:
        """Which wheels are on the ground."""
        return self._ground.touching

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
        height = self.distribution.center[2]
        return vx - wy * height, vy + wx * height, wz

    @property
    def speed(self) -> float:
        """Speed of the fastest corner [m/s]."""
        return math.hypot(*self.origin_velocity) + abs(self.rate[2]) * self._half_diagonal

    def reach(self, dt: float) -> float:
        """How far from where its origin is now a corner of its bumpers can be within dt [s], from above [m]."""
        return self._half_diagonal + dt * self.speed

    @property
    def origin_velocity(self) -> Vector:
        """Velocity of the point at `pos`, field frame [m/s]."""
        cx, cy, cz = self.distribution.center
        ax, ay, az = rotate(self.quat, (-cx, -cy, -cz))
        (vx, vy, vz), (wx, wy, wz) = self.vel, self.rate
        return vx + wy * az - wz * ay, vy + wz * ax - wx * az, vz + wx * ay - wy * ax

    @property
    def footprint(self) -> tuple[float, float, float, float, float, float]:
        """What the pieces need to know: x, y, yaw, half length, half width [m, rad] and speed of the box [m/s]."""
        x, y, yaw = self.pose
        return x, y, yaw, self.config.bumper_length / 2, self.config.bumper_width / 2, self.speed

    def standing(self, pose: Vector) -> tuple[Vector, Quaternion]:
        """Place of its origin, field frame [m], and attitude as it would stand at a pose [m, m, rad]."""
        return self._ground.standing(*pose)

    def wheel_ground(self) -> tuple[FloatArray, FloatArray]:
        """What is under the wheels.

        Returns:
            Lowest point of each wheel, field frame [m], shape (n, 3), and the height of what carries robots straight
            under it [m], shape (n,); 5 m below the wheel's axle where there is nothing.
        """
        return self._ground.under(self.pos, self.quat)

    # --- inside -------------------------------------------------------------------------------------------------

    def _follow(self, h: float, record: Any) -> Vector:
        """Toward the target by no more than mu g h, and about the yaw axis by what the same grip can turn.

        The wheels that touch carry the whole weight between them, so grip is there in full until the last one lifts.
        What gravity does along a slope is made up for within that grip, so that a robot stands on it. What a wall does
        is not: pushed against a push that is as stiff as a wall's, a robot rattles.

        Returns:
            Acceleration by what drives it, in plan axes, outside forces included [m/s^2, m/s^2, rad/s^2].
        """
        assert self._target is not None
        if not any(self._ground.touching):
            return _ZERO
        yaw, (ax, ay, _) = float(record["yaw"]), record["gravity"].tolist()
        c, s = math.cos(yaw), math.sin(yaw)
        grip = self.config.friction * self._world.gravity
        fx, fy, turn = record["drive"].tolist()
        plan_x, plan_y, omega = float(record["vx"]), float(record["vy"]), float(record["omega"])
        vx, vy = c * plan_x + s * plan_y, c * plan_y - s * plan_x
        cx, cy, _ = self.distribution.center
        wanted_x, wanted_y, wanted_turn = self._target  # of the origin; the center of mass turns about it
        dvx, dvy = wanted_x - wanted_turn * cy - vx - ax * h, wanted_y + wanted_turn * cx - vy - ay * h
        size = math.hypot(dvx, dvy)
        if size > grip * h:
            dvx, dvy = dvx * grip * h / size, dvy * grip * h / size
        spin = self._most_spin(self.config.friction) * h
        domega = max(-spin, min(spin, wanted_turn - omega))
        return fx + (c * dvx - s * dvy) / h, fy + (s * dvx + c * dvy) / h, turn + domega / h

    def _most_spin(self, friction: float) -> float:
        """Angular acceleration of a robot whose wheels all pull across their radius with this grip [rad/s^2]."""
        mass, _, (_, _, yaw_inertia) = self.distribution
        return friction * self._world.gravity * mass * self.config.traction_radius / yaw_inertia

    def _require_finite(self, what: str, values: Sequence[float]) -> None:
        if not all(map(math.isfinite, values)):
            raise NonFiniteError(f"{self.name}: {what} must be finite, got {tuple(values)}")
