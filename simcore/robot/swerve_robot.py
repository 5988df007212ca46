"""A swerve robot in the world: body, drivetrain, battery, gyro and odometry as one thing to place and to read."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from simcore.physics.world import PhysicsWorld
from simcore.robot.battery import Battery, BatteryConfig
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.chassis_config import ChassisConfig
from simcore.robot.gyro import Gyro, GyroConfig
from simcore.robot.odometry import SwerveOdometry
from simcore.robot.swerve_config import SwerveConfig
from simcore.robot.swerve_drive import SwerveDrive

__all__ = ["SwerveRobot"]


class SwerveRobot:
    """What every swerve robot has, whatever the game. Several in one world share nothing but the world.

    Args:
        world: Where it stands.
        chassis: Mass, shape and wheels.
        swerve: Modules, motors and tires; its mass is the chassis'.
        pose: Start, field frame [m, m, rad].
        battery: Of this robot alone; None: a stiff 12 V supply.
        gyro: Its errors.
        rng: For the noise of its sensors.
        name: For messages.
    """

    def __init__(
        self,
        world: PhysicsWorld,
        chassis: ChassisConfig,
        swerve: SwerveConfig,
        *,
        pose: tuple[float, float, float],
        gyro: GyroConfig,
        rng: np.random.Generator,
        battery: BatteryConfig | None = None,
        name: str = "robot",
    ) -> None:
        self.battery = Battery(battery or BatteryConfig.stiff(12.0))
        self.drive = self._build_drive(swerve)
        self.chassis = ChassisSimulation(world, chassis, pose=pose, drivetrain=self.drive, name=name)
        self.gyro = Gyro(gyro, rng)
        self.odometry = SwerveOdometry(self.drive.config.positions)
        self._wheel_radii = [module.wheel_radius for module in swerve.modules]
        self.reset(pose)

    def reset(self, pose: tuple[float, float, float]) -> None:
        """Put the robot somewhere at rest, and let its sensors know: truth, gyro and odometry agree again [m, m, rad].

        Robot code that only wants to believe something else calls `odometry.reset`; the robot then stays where it is.

        Raises:
            NonFiniteError: The pose is not finite; nothing has changed.
        """
        self.chassis.set_pose(*pose)
        self.drive.reset()
        self.gyro.reset(yaw=pose[2], true_yaw=pose[2])
        self.odometry.reset(pose, gyro_yaw=pose[2])

    def sense(self, dt: float) -> None:
        """Let gyro and odometry follow what happened in the last dt [s]."""
        roll, pitch, yaw = self.chassis.roll_pitch_yaw
        self.gyro.step(dt, yaw, pitch, roll, self.chassis.robot_rate)
        distances, angles = self._wheels()
        self.odometry.update(distances, angles, self.gyro.yaw)

    def _build_drive(self, swerve: SwerveConfig) -> SwerveDrive:
        """The drivetrain, on this robot's battery."""
        return SwerveDrive(swerve, battery=self.battery)

    def _wheels(self) -> tuple[Sequence[float], Sequence[float]]:
        """How far each wheel has rolled [m], and where it points [rad]."""
        state = self.drive.state
        return [a * r for a, r in zip(state.wheel_angle, self._wheel_radii, strict=True)], state.steer_angle
