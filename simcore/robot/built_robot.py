"""A robot as it is built: what its config and its program believe, and what motors, wheels and sensors really are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from simcore.pieces.shot_schedule import ShotErrors
from simcore.robot.battery import BatteryConfig
from simcore.robot.gyro import GyroConfig
from simcore.robot.robot_config import MechanismConfig, RobotConfig
from simcore.robot.swerve_config import SwerveConfig
from simcore.robot.tank_config import TankConfig

__all__ = ["BuiltRobot"]


@dataclass(frozen=True, slots=True, kw_only=True)
class BuiltRobot:
    """What may differ from a `RobotConfig` in the robot that was built after it."""

    drivetrain: SwerveConfig | tuple[TankConfig, TankConfig]
    """Of a tank drive the left and the right side."""
    battery: BatteryConfig
    gyro: GyroConfig
    mechanisms: Mapping[str, MechanismConfig]
    shot_errors: tuple[ShotErrors | None, ...]
    """Of each shooter."""

    @classmethod
    def exactly(cls, config: RobotConfig) -> BuiltRobot:
        """One that is what its config says."""
        drivetrain = config.drivetrain
        return cls(
            drivetrain=drivetrain if isinstance(drivetrain, SwerveConfig) else (drivetrain, drivetrain),
            battery=config.battery,
            gyro=config.gyro,
            mechanisms=config.mechanisms,
            shot_errors=(None,) * len(config.shooters),
        )
