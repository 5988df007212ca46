"""Chassis of a robot in a world: mass, wheels, pose and velocity.

The loop (`simcore.loop.robots`) moves the chassis under tire forces, contact forces and external forces.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from simcore.errors import ConfigError, NonFiniteError
from simcore.quantities import POSE, checked_number, require_count, require_row
from simcore.robot.chassis_config import ChassisConfig, MassDistribution
from simcore.robot.mechanisms import ShaftSim
from simcore.robot.wheel_config import RobotMass
from simcore.robot.wheeled_drive import WheeledDrive, static_loads
from simcore.typing import FloatArray
from simcore.world.rotation import (
    Quaternion,
    Vector,
    from_yaw,
    matrix,
    rotate,
    rotate_back,
    rpy,
    yaw_of,
)
from simcore.world.world import PhysicsWorld

__all__ = ["ChassisSimulation", "GroundClearance", "ground_clearance"]

_CONTACT_GAP = 0.004  # [m]; a wheel this close to the ground counts as touching
_LOWERED = 0.003  # [m]; drop of the middle wheels of a dropped-center drive
_FAR_BELOW = 5.0  # [m]; depth to which wheels search for ground


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundClearance:
    """Gap between a robot's wheels and the ground, computed by `ground_clearance`."""

    height: float
    """Smallest gap between a wheel and the surface below [m]; slightly negative when a tire is compressed."""
    is_airborne: bool
    """Whether all wheels are more than the tolerance above the ground."""


def ground_clearance(
    wheel_points: FloatArray, surface_heights: FloatArray, *, tolerance: float = 0.01
) -> GroundClearance:
    """Compute the smallest gap between a wheel and the ground, and whether the robot is airborne.

    A robot tilted on a bump is not airborne while a wheel touches the ground.

    Args:
        wheel_points: Lowest point of each wheel, field frame [m], shape (n, 3).
        surface_heights: Height of carpet, bump or ramp under each point, from a ray or a map [m], shape (n,).
        tolerance: Largest gap at which a wheel counts as touching the ground [m].

    Raises:
        ConfigError: If there is no wheel or the shapes do not match.
        NonFiniteError: If a value is NaN or infinite.

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


class ChassisSimulation:
    """Body of a robot in a world, moved by a drivetrain model, contacts and external forces.

    Args:
        world: World to which the constructor adds the robot.
        config: Mass, shape and wheels of the robot.
        pose: Start pose, field frame [m, m, rad].
        drivetrain: Model of motors and tires; None for free-rolling wheels and a body that only `apply_forces` drives.
        mechanisms: Mechanisms that draw current from the robot's battery.
        name: Name of the robot, for messages.
        mass: Mass distribution of the whole robot at the start; None for the mass distribution in `config`.
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
        """Current mass distribution, with held pieces and moving masses; see `set_mass`."""
        self.name = name
        self._world = world
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
        self._half_diagonal = 0.5 * math.hypot(config.bumper_length, config.bumper_width)
        self.soles = np.array([(x, y, 0.0) for x, y in config.wheel_positions])
        """Lowest point of each wheel, robot frame [m], shape (n, 3)."""
        self.wheel_reach = max(math.hypot(x, y) for x, y in config.wheel_positions)
        """Largest horizontal distance from the robot's origin to a wheel center [m]."""
        self._dynamics, self._number = world.robots, len(world.robot_rows) - 1
        self._dynamics.bind(self._number, drivetrain, mechanisms)
        lowered = () if drivetrain is None else drivetrain.robot.lowered
        lift = _LOWERED if lowered else 0.0
        hubs = [
            (x, y, config.wheel_radius + (0.0 if k in lowered else lift))
            for k, (x, y) in enumerate(config.wheel_positions)
        ]
        self._dynamics.set_points(self._number, hubs, config.points, config.wheel_radius)
        self._set_mass()
        world.set_pose(self.row, *self.standing(pose))
        self.pos: Vector = (0.0, 0.0, 0.0)
        """Position of the robot's origin at the last `read`, field frame [m].

        The origin is at the center of the robot, at the height of the lowest points of the wheels.
        """
        self.quat: Quaternion = (0.0, 0.0, 0.0, 1.0)
        """Attitude at the last `read`: rotation from robot to field axes, quaternion x, y, z, w."""
        self.vel: Vector = (0.0, 0.0, 0.0)
        """Velocity of the center of mass at the last `read`, field frame [m/s]."""
        self.rate: Vector = (0.0, 0.0, 0.0)
        """Angular velocity at the last `read`, field frame [rad/s]."""
        self.read()

    # --- driving ------------------------------------------------------------------------------------------------

    def apply_forces(self, force: Vector, torque: Vector = _ZERO) -> None:
        """Apply a force [N] at the center of mass and a torque [N m], both in field axes, until the next call.

        Raises:
            NonFiniteError: If a value is not finite; the old force and torque stay in effect.
        """
        self._require_finite("force", force)
        self._require_finite("torque", torque)
        request = self._record["request"]
        request["force"], request["torque"] = force, torque

    def set_pose(self, x: float, y: float, yaw: float) -> None:
        """Place the robot at rest on the drivable ground, at a planar pose in the field frame [m, m, rad].

        Raises:
            NonFiniteError: If a value is not finite; the robot stays where it is.
            ConfigError: If a coordinate is too large for any field; the robot stays where it is.
        """
        self._require_finite("pose", (x, y, yaw))
        require_row(self.name, "pose", (x, y, yaw), POSE)
        self._world.set_pose(self.row, *self.standing((x, y, yaw)))
        self.read()

    def set_mass(self, mass: MassDistribution, vel: Vector, rate: Vector) -> None:
        """Set the mass distribution and the velocity between two steps, without a change of the pose.

        Args:
            mass: New mass distribution of the whole robot.
            vel: New velocity, at the new center of mass, field frame [m/s].
            rate: New angular velocity, field frame [rad/s].
        """
        self.distribution, self.vel, self.rate = mass, vel, rate
        self._set_mass()
        self._world.set_velocity(self.row, vel, rate)

    def _set_mass(self) -> None:
        """Pass the robot's mass distribution and the static wheel loads to the loop and the drivetrain."""
        mass, center, inertia = self.distribution
        if self._drivetrain is not None:
            self._drivetrain.set_mass_properties(mass, inertia[2], center)
            loads = self._drivetrain.static_loads
        else:
            places = tuple((x - center[0], y - center[1]) for x, y in self.config.wheel_positions)
            loads = static_loads(RobotMass(mass=mass, yaw_inertia=inertia[2], center_of_mass=center, positions=places))
        self._dynamics.set_mass(self._number, mass, center, inertia, self.config.wheel_radius, loads)

    # --- one step -----------------------------------------------------------------------------------------------

    @property
    def _record(self) -> Any:
        """Record of this robot in the arrays of the loop."""
        return self._dynamics.robots[self._number]

    def read(self) -> None:
        """Update `pos`, `quat`, `vel` and `rate` from the robot's body in the arrays of the loop."""
        body = self._world.bodies.of(self.row)
        self.pos, self.quat = tuple(body["pos"][0].tolist()), tuple(body["quat"][0].tolist())
        self.vel, self.rate = tuple(body["vel"][0].tolist()), tuple(body["rate"][0].tolist())
        self._yaw = yaw_of(self.quat)  # stored because it is used eight times per tick

    # --- state -------------------------------------------------------------------------------------------------

    @property
    def normal_loads(self) -> list[float]:
        """Mean normal force on each wheel in the last call of the loop [N]; zeros without a drivetrain."""
        if self._drivetrain is None:
            return [0.0] * len(self.config.wheel_positions)
        return self._drivetrain.normal_loads

    @property
    def touching(self) -> list[bool]:
        """Whether each wheel is less than 4 mm above the ground, one value per wheel."""
        gaps = self._dynamics.wheel_gaps(self._number, len(self.config.wheel_positions))
        return [gap < _CONTACT_GAP for gap in gaps]

    @property
    def pose(self) -> tuple[float, float, float]:
        """Planar pose x, y and heading, field frame [m, m, rad]."""
        return self.pos[0], self.pos[1], self._yaw

    @property
    def roll_pitch_yaw(self) -> Vector:
        """Roll, pitch and yaw as in WPILib's Rotation3d [rad]."""
        return rpy(self.quat)

    @property
    def robot_rate(self) -> Vector:
        """Angular velocity, robot axes [rad/s]."""
        return rotate_back(self.quat, self.rate)

    @property
    def ground_velocity(self) -> tuple[float, float, float]:
        """Velocity of the body at floor height below the center of mass, and yaw rate, robot axes [m/s, m/s, rad/s]."""
        vx, vy, _ = rotate_back(self.quat, self.vel)
        wx, wy, wz = rotate_back(self.quat, self.rate)
        height = self.distribution.center[2]
        return vx - wy * height, vy + wx * height, wz

    @property
    def speed(self) -> float:
        """Upper bound on the horizontal speed of any bumper corner of an upright robot [m/s]."""
        return math.hypot(*self.origin_velocity) + abs(self.rate[2]) * self._half_diagonal

    def reach(self, dt: float) -> float:
        """Return the radius [m], in plan view, around the present origin within which the bumpers stay for `dt`.

        The method assumes the present speed.

        Args:
            dt: Duration from now [s].
        """
        return self._half_diagonal + dt * self.speed

    @property
    def origin_velocity(self) -> Vector:
        """Velocity of the robot origin, field frame [m/s]."""
        cx, cy, cz = self.distribution.center
        ax, ay, az = rotate(self.quat, (-cx, -cy, -cz))
        (vx, vy, vz), (wx, wy, wz) = self.vel, self.rate
        return vx + wy * az - wz * ay, vy + wz * ax - wx * az, vz + wx * ay - wy * ax

    @property
    def footprint(self) -> tuple[float, float, float, float, float, float]:
        """Planar pose in the field frame [m, m, rad], half length and half width of the bumpers [m], `speed` [m/s]."""
        x, y, yaw = self.pose
        return x, y, yaw, self.config.bumper_length / 2, self.config.bumper_width / 2, self.speed

    def standing(self, pose: Vector) -> tuple[Vector, Quaternion]:
        """Return the position of the origin [m] and the attitude of the robot at rest on the ground at a planar pose.

        Args:
            pose: Planar pose, field frame [m, m, rad].
        """
        return self._world.standing(self._number, pose)

    def wheel_ground(self) -> tuple[FloatArray, FloatArray]:
        """Return the lowest point of each wheel and the ground height under each wheel.

        Returns:
            Lowest point of each wheel, field frame [m], shape (n, 3), and height of the drivable ground below each
            axle, field frame [m], shape (n,). Without ground within 5 m below an axle, the height is that of the axle
            minus 5 m.
        """
        soles = self.soles @ matrix(self.quat).T + self.pos
        if self._world.is_flat(self.pos[0], self.pos[1], self.wheel_reach):
            return soles, np.zeros(len(soles))
        hubs = soles + np.array((0.0, 0.0, self.config.wheel_radius))
        return soles, self._world.ground_under(hubs, _FAR_BELOW)

    # --- checks -------------------------------------------------------------------------------------------------

    def _require_finite(self, what: str, values: Sequence[float]) -> None:
        require_count(f"{self.name}: {what}", values, 3, "axes")
        for value in values:
            checked_number(f"{self.name}: {what}", value)
