"""Test benches: a robot with only a drivetrain on an unlimited carpet, and a chassis without a drivetrain."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from simcore.loop.robot_state import STEP
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.chassis_config import ChassisConfig, MassDistribution
from simcore.robot.wheeled_drive import WheeledDrive
from simcore.units import GRAVITY
from simcore.world.rotation import Vector, cross, from_yaw, rotate, rotate_back
from simcore.world.world import PhysicsWorld

__all__ = ["DriveBench", "LoneChassis", "hold"]


class DriveBench:
    """Robot with only a drivetrain, on an unlimited carpet that is level or rises along the field's x axis.

    Args:
        drive: Drivetrain to test.
        slope: Slope of the carpet, positive if rising along x [rad].
    """

    def __init__(self, drive: WheeledDrive[Any], *, slope: float = 0.0) -> None:
        self.drive, self.slope, self.time = drive, slope, 0.0
        c, robot = drive.config, drive.robot
        size = 2.0 * max(max(abs(x), abs(y)) for x, y in c.wheel_positions) + 0.2
        body = ChassisConfig(
            mass=robot.mass, bumper_length=size, bumper_width=size, wheel_positions=c.wheel_positions,
            yaw_inertia=robot.yaw_inertia,
        )  # fmt: skip
        self.world = PhysicsWorld()
        roll, pitch, _ = body.inertia
        mass = MassDistribution(robot.mass, robot.center_of_mass, (roll, pitch, robot.yaw_inertia))
        self.chassis = ChassisSimulation(self.world, body, drivetrain=drive, mass=mass)
        self._lifting = 0.0  # upward force [N]
        self.ax = self.ay = 0.0
        """Mean acceleration of the center of mass along x and y during the last step, field frame [m/s^2]."""

    def reset(self, *, yaw: float = 0.0, vx: float = 0.0, vy: float = 0.0, omega: float = 0.0) -> None:
        """Place the robot at the field origin, and set the time of the bench to 0.

        Args:
            yaw: Heading [rad].
            vx: Velocity along the field's x axis [m/s].
            vy: Velocity along the field's y axis [m/s].
            omega: Yaw rate, counter-clockwise positive [rad/s].
        """
        self.world.set_pose(self.chassis.row, (0.0, 0.0, 0.0), from_yaw(yaw))
        self.world.set_velocity(self.chassis.row, (vx, vy, 0.0), (0.0, 0.0, omega))
        self.chassis.read()
        self.chassis.apply_forces((0.0, 0.0, 0.0))
        self._lifting = 0.0
        self.time = 0.0

    def lift(self) -> None:
        """Place the robot 1 m above the carpet, and apply a constant force that cancels the weight of the robot."""
        mass = self.chassis.distribution.mass
        self.world.set_pose(self.chassis.row, (*self.chassis.pos[:2], 1.0), self.chassis.quat)
        self._lifting = mass * GRAVITY
        self.chassis.apply_forces((0.0, 0.0, self._lifting))

    def step(self, h: float, *, force: Vector = (0.0, 0.0, 0.0)) -> None:
        """Advance the bench by one time step.

        Args:
            h: Time step [s].
            force: Force along x and y and yaw torque at the center of mass, field frame [N, N, N m], in addition to
                the force of `lift`.
        """
        weight = self.chassis.distribution.mass * GRAVITY
        along, up = -weight * math.sin(self.slope), weight * (1.0 - math.cos(self.slope)) + self._lifting
        self.chassis.apply_forces((force[0] + along, force[1], up), (0.0, 0.0, force[2]))
        before = self.chassis.vel
        self.world.advance(h)
        self.chassis.read()
        self.ax, self.ay = ((now - then) / h for now, then in zip(self.chassis.vel[:2], before[:2], strict=True))
        self.time += h

    def hold(self, h: float, velocity: Vector, *, in_air: bool = False) -> Vector:
        """Reset the robot, hold the robot at a velocity, and return the velocity change that the tires would cause.

        Args:
            h: Duration [s].
            velocity: Velocity of the center of mass, robot frame [m/s, m/s, rad/s].
            in_air: Whether the wheels are off the carpet.

        Returns:
            Change of velocity [m/s, m/s, rad/s].
        """
        self.reset()
        if in_air:
            self.lift()
        steps, changes = max(1, round(h / STEP)), [0.0, 0.0, 0.0]
        vx, vy, omega = velocity
        for _ in range(steps):
            self.world.set_pose(self.chassis.row, (0.0, 0.0, 1.0 if in_air else 0.0))
            self.world.set_velocity(self.chassis.row, (vx, vy, 0.0), (0.0, 0.0, omega))
            self.world.advance(h / steps)
            self.chassis.read()
            changes[0] += self.vx - vx
            changes[1] += self.vy - vy
            changes[2] += self.omega - omega
        return changes[0], changes[1], changes[2]

    def run(self, seconds: float, *, h: float = 0.005, each: Callable[[], None] | None = None) -> None:
        """Advance by a duration [s] in steps of h [s], and call `each` after every step."""
        for _ in range(round(seconds / h)):
            self.step(h)
            if each is not None:
                each()

    @property
    def x(self) -> float:
        """Position of the center of mass along the field's x axis [m]."""
        return self.chassis.pos[0] + rotate(self.chassis.quat, self.chassis.distribution.center)[0]

    @property
    def y(self) -> float:
        """Position of the center of mass along the field's y axis [m]."""
        return self.chassis.pos[1] + rotate(self.chassis.quat, self.chassis.distribution.center)[1]

    @property
    def yaw(self) -> float:
        """Heading of the robot, field frame [rad]."""
        return self.chassis.pose[2]

    @property
    def vx(self) -> float:
        """Velocity of the center of mass along the field's x axis [m/s]."""
        return self.chassis.vel[0]

    @property
    def vy(self) -> float:
        """Velocity of the center of mass along the field's y axis [m/s]."""
        return self.chassis.vel[1]

    @property
    def omega(self) -> float:
        """Yaw rate of the robot, counter-clockwise positive [rad/s]."""
        return self.chassis.rate[2]

    @property
    def speed(self) -> float:
        """Speed of the center of mass over the carpet [m/s]."""
        return math.hypot(self.vx, self.vy)

    @property
    def loads(self) -> list[float]:
        """Normal force on each wheel in the last step [N]."""
        return self.drive.normal_loads

    @property
    def kinetic_energy(self) -> float:
        """Kinetic energy of the horizontal motion and yaw of the robot, without the rotation of the wheels [J]."""
        mass, _, (_, _, yaw_inertia) = self.chassis.distribution
        return 0.5 * mass * (self.vx**2 + self.vy**2) + 0.5 * yaw_inertia * self.omega**2


def hold(drive: WheeledDrive[Any], h: float, velocity: Vector, *, in_air: bool = False) -> Vector:
    """Call `DriveBench.hold` for a drivetrain on a new, level bench, and return the velocity change."""
    return DriveBench(drive).hold(h, velocity, in_air=in_air)


class LoneChassis:
    """Chassis without a drivetrain that accelerates toward a commanded velocity within the friction limit.

    `Motion` can advance this chassis in place of a robot.

    Args:
        chassis: Chassis in a physics world.
    """

    def __init__(self, chassis: ChassisSimulation) -> None:
        self.chassis = chassis
        self._wanted: Vector | None = None

    def follow(self, vx: float, vy: float, omega: float) -> None:
        """Command a velocity of the chassis origin, robot frame [m/s, m/s, rad/s], until the next command."""
        self._wanted = (vx, vy, omega)

    def step_devices(self, h: float) -> None:
        """Apply a force and a yaw torque that lead to the commanded velocity after h [s], within the friction limit.

        The force is at most mu m g, and the torque is at most mu m g times the traction radius. Without a wheel on the
        carpet, the force is 0.
        """
        chassis = self.chassis
        chassis.read()
        if self._wanted is None:
            return
        if not any(chassis.touching):
            chassis.apply_forces((0.0, 0.0, 0.0))
            return
        mass, center, (_, _, inertia) = chassis.distribution
        vx, vy, omega = self._wanted
        ux, uy, _ = rotate_back(chassis.quat, chassis.vel)
        fx, fy = mass * (vx - omega * center[1] - ux) / h, mass * (vy + omega * center[0] - uy) / h
        most = chassis.config.friction * mass * GRAVITY
        share = min(1.0, most / max(math.hypot(fx, fy), 1e-9))
        spin = most * chassis.config.traction_radius
        turn = max(-spin, min(spin, inertia * (omega - chassis.robot_rate[2]) / h))
        force = rotate(chassis.quat, (share * fx, share * fy, 0.0))
        lever = rotate(chassis.quat, (0.0, 0.0, -center[2]))
        tx, ty, tz = cross(lever, force)
        ax, ay, az = rotate(chassis.quat, (0.0, 0.0, turn))
        chassis.apply_forces(force, (tx + ax, ty + ay, tz + az))

    def sense(self, dt: float) -> None:
        """Read the pose and velocity of the chassis from the world at the end of a tick."""
        self.chassis.read()
