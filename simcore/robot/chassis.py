"""The robot in the world: what it is driven by, and what the world makes of it.

In each step of the loop tires and bumpers let it move in its plane (`simcore.loop.robots`); the engine adds gravity,
ramps and pieces; what really came of it is what tires and motors see next. Poses are never forced.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from simcore.errors import ConfigError, NonFiniteError
from simcore.geometry.rotation import (
    IDENTITY,
    Quaternion,
    Vector,
    from_rpy,
    from_yaw,
    matrix,
    multiply,
    rotate,
    rotate_back,
    rpy,
    yaw_of,
)
from simcore.physics.world import PhysicsWorld
from simcore.quantities import POSE, checked_number, require_count, require_row
from simcore.robot.chassis_config import ChassisConfig, MassDistribution
from simcore.robot.mechanisms import ShaftSim
from simcore.robot.wheeled_drive import WheeledDrive
from simcore.typing import FloatArray

__all__ = ["ChassisSimulation", "GroundClearance", "ground_clearance"]

_CONTACT_GAP = 0.004  # [m]; a wheel this close to the ground carries load
_SINK = -2e-5  # [m]; a gap of exactly 0 is no contact yet, and the first step would fall
_ABOVE, _BELOW = 2.0, -1.0  # [m]; heights between which ground is looked for
_ROUNDS = 4  # a tilt moves the wheels, which stand elsewhere then


class WheelGround:
    """Which wheels of a robot touch the ground, and how high it is under each.

    Args:
        world: Where the robot is.
        row: Of its body.
        config: Where its wheels are.
    """

    def __init__(self, world: PhysicsWorld, row: int, config: ChassisConfig) -> None:
        self._world, self._row, self._radius = world, row, config.wheel_radius
        self._hubs = np.array([(x, y, config.wheel_radius) for x, y in config.wheel_positions])
        self._soles = np.array([(x, y, -_CONTACT_GAP) for x, y in config.wheel_positions])
        self._contacts = np.array([(x, y, 0.0) for x, y in config.wheel_positions])
        self._all_touching = [True] * len(config.wheel_positions)
        half = 0.5 * config.bumper_length, 0.5 * config.bumper_width
        below = [
            (x * half[0], y * half[1], config.clearance) for x in np.linspace(-1, 1, 9) for y in np.linspace(-1, 1, 9)
        ]
        self._underside = np.array([*self._contacts.tolist(), *below])
        self._half_diagonal = math.hypot(*half)
        self.reach = max(math.hypot(x, y) for x, y in config.wheel_positions)
        """Of the wheels from the robot's origin [m]."""
        self.touching = list(self._all_touching)
        """Which wheels were on the ground in the last `find`."""

    def stand(self) -> None:
        """All wheels touch: it stands level on the flat carpet."""
        self.touching = self._all_touching

    def find(self, pos: Vector, quat: Quaternion) -> None:
        """Which wheels touch, of a robot that does not stand level: those whose short ray down meets something.

        And those that touch what carries robots elsewhere: a wheel at the edge of a bar stands on it and pulls there.

        Args:
            pos: Of the robot's origin, field frame [m].
            quat: Attitude of the robot.
        """
        turn = matrix(quat).T
        start = self._hubs @ turn + pos
        end = self._soles @ turn + pos
        touching = self._world.ground_rays(start, end).row >= 0
        if not touching.all():
            places = self._world.ground_contacts(self._row)
            if len(places):
                away = np.linalg.norm(start[:, None] - places, axis=2).min(axis=1)
                touching |= away < self._radius + _CONTACT_GAP
        self.touching = touching.tolist()

    def standing(self, x: float, y: float, yaw: float) -> tuple[Vector, Quaternion]:
        """How a robot stands somewhere at rest: level on the carpet, tilted on what robots drive over.

        Wheels and underside are above the ground, and its origin as low as that allows: a linear program.

        Args:
            x: Field frame [m].
            y: The same [m].
            yaw: Heading [rad].

        Returns:
            Place of the robot's origin, field frame [m], and its attitude.
        """
        pos, quat, level = (x, y, _SINK), from_yaw(yaw), from_yaw(yaw)
        if self._world.is_flat(x, y, self._half_diagonal):
            return pos, quat
        tilt, rows, heights = IDENTITY, np.empty((0, 3)), np.empty(0)
        for _ in range(_ROUNDS):
            points = self._underside @ matrix(tilt).T
            start = points @ matrix(level).T + (x, y, 0.0)
            end = start.copy()
            start[:, 2], end[:, 2] = _ABOVE, _BELOW
            hits = self._world.ground_rays(start, end)
            is_over = np.asarray(hits.row) >= 0
            if is_over.sum() < 3:
                return (x, y, _SINK), level
            ground = _ABOVE + (_BELOW - _ABOVE) * np.asarray(hits.fraction)[is_over]
            flat = points[is_over]
            lift = flat[:, 2] - _plane_heights(flat, tilt)  # of each point over the plane of the wheels' soles
            rows = np.vstack([rows, np.column_stack([np.ones(len(flat)), flat[:, :2]])])
            heights = np.append(heights, ground - lift)  # those of earlier rounds, too: or it may tilt to and fro
            from scipy.optimize import linprog  # 0.1 s, and on a flat floor not needed

            found = linprog(
                (1.0, 0.0, 0.0),
                A_ub=-rows,
                b_ub=-heights,
                bounds=[(None, None), (-1.0, 1.0), (-1.0, 1.0)],
            )
            if found.x is None:  # all that carries it is on one side
                return (x, y, _SINK), level
            height, along, aside = found.x.tolist()
            size = math.sqrt(1.0 + along * along + aside * aside)
            tilt = from_rpy(math.asin(aside / size), math.atan2(-along, 1.0), 0.0)
            pos, quat = (x, y, height + _SINK), multiply(level, tilt)
        return pos, quat

    def under(self, pos: Vector, quat: Quaternion) -> tuple[FloatArray, FloatArray]:
        """See `ChassisSimulation.wheel_ground`; for the arguments see `find`."""
        soles = self._contacts @ matrix(quat).T + pos
        if self._world.is_flat(pos[0], pos[1], self.reach):
            return soles, np.zeros(len(soles))
        start = soles + np.array((0.0, 0.0, self._radius))
        hits = self._world.ground_rays(start, start - np.array((0.0, 0.0, 5.0)))
        return soles, start[:, 2] - 5.0 * hits.fraction


def _plane_heights(points: FloatArray, tilt: Quaternion) -> FloatArray:
    """Heights of the tilted plane through the origin at the places of points [m], shape (n,)."""
    nx, ny, nz = matrix(tilt)[:, 2].tolist()
    return np.asarray(-(nx * points[:, 0] + ny * points[:, 1]) / nz)


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundClearance:
    """Result of `ground_clearance`."""

    height: float
    """Of the lowest wheel above the surface under it [m]; a little below 0 when a tire is pressed in."""
    is_airborne: bool
    """No wheel touches."""


def ground_clearance(
    wheel_points: FloatArray, surface_heights: FloatArray, *, tolerance: float = 0.01
) -> GroundClearance:
    """Clearance of a robot from its wheels' lowest points, so that a tilted robot on a bump is not in the air.

    Args:
        wheel_points: Where each wheel would touch, field frame [m], shape (n, 3).
        surface_heights: Height of carpet, bump or ramp under each point, from a ray or a map [m], shape (n,).
        tolerance: A wheel within this of its surface touches it [m].

    Raises:
        ConfigError: No wheel, or shapes that do not belong together.
        NonFiniteError: A NaN or an infinity.

    >>> ground_clearance(np.array([[0.3, 0.0, 0.12], [-0.3, 0.0, 0.10]]), np.array([0.0, 0.0]))
    GroundClearance(height=0.1, is_airborne=True)
    """
    points, heights = np.asarray(wheel_points, dtype=np.float64), np.asarray(surface_heights, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or not len(points) or heights.shape != (len(points),):
        raise ConfigError(
            f"wheel_points need shape (n, 3) and surface_heights (n,), got {points.shape}, {heights.shape}"
        )
    gap = (points[:, 2] - heights).tolist()
    if not all(map(math.isfinite, gap)):
        raise NonFiniteError(f"height of wheels over the ground must be finite, got {gap}")
    height = min(gap)
    return GroundClearance(height=height, is_airborne=height > tolerance)


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
        self._require_finite("force", force)
        self._require_finite("torque", torque)
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
        record["is_put"] = 1
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
        require_count(f"{self.name}: {what}", values, 3, "axes")
        for value in values:
            checked_number(f"{self.name}: {what}", value)
