"""What a drivetrain is built with, as the numbers pass the native seam."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from simcore.errors import ConfigError

__all__ = ["DrivetrainConstants", "ModuleConstants", "OutputType"]

_FEEDBACK = (
    *("FUSED_CANCODER", "SYNC_CANCODER", "REMOTE_CANCODER"),
    *("FUSED_CANDI_PWM1", "FUSED_CANDI_PWM2", "SYNC_CANDI_PWM1", "SYNC_CANDI_PWM2"),
    *("REMOTE_CANDI_PWM1", "REMOTE_CANDI_PWM2", "TALON_FXS_PULSE_WIDTH"),
)
_CANCODERS = 3  # of them read a CANcoder


class OutputType:
    """Values of `phoenix6.swerve.ClosedLoopOutputType`."""

    VOLTAGE: ClassVar[int] = 0
    TORQUE_CURRENT: ClassVar[int] = 1


@dataclass(frozen=True, slots=True)
class ModuleConstants:
    """One module, in the order of the native function's arguments."""

    steer_motor_id: int
    drive_motor_id: int
    encoder_id: int
    encoder_offset: float
    """[rotations]"""
    x: float
    """From the robot's center [m]."""
    y: float
    drive_inverted: bool
    steer_inverted: bool
    encoder_inverted: bool
    drive_gearing: float
    """Rotor turns per turn of the wheel."""
    steer_gearing: float
    coupling: float
    """Rotor turns of the drive motor per turn of the azimuth."""
    wheel_radius: float
    """[m]"""
    steer_output: int
    drive_output: int
    slip_current: float
    """[A]"""
    speed_at_12_volts: float
    """[m/s]"""
    drive_motor_type: int
    steer_motor_type: int
    feedback_source: int
    steer_inertia: float
    drive_inertia: float
    steer_friction_voltage: float
    drive_friction_voltage: float

    def __post_init__(self) -> None:
        where = f"swerve module with drive motor {self.drive_motor_id}"
        for name in ("drive_gearing", "wheel_radius", "speed_at_12_volts"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value != 0.0):
                raise ConfigError(f"{where}: {name} must be a finite number other than 0, got {value}")
        if self.drive_motor_type != 0 or self.steer_motor_type != 0:
            raise NotImplementedError(
                f"{where}: only TalonFX motors are modelled in simulated time, got motor arrangements "
                f"{self.drive_motor_type} (drive) and {self.steer_motor_type} (steer); use --phoenix=real"
            )
        if not 0 <= self.feedback_source < _CANCODERS:
            known = 0 <= self.feedback_source < len(_FEEDBACK)
            name = _FEEDBACK[self.feedback_source] if known else str(self.feedback_source)
            raise NotImplementedError(
                f"{where}: steer feedback {name} is not modelled in simulated time, "
                f"{', '.join(_FEEDBACK[:_CANCODERS])} are; use --phoenix=real"
            )

    @property
    def rotations_per_meter(self) -> float:
        """Rotor turns of the drive motor per meter on the carpet."""
        return self.drive_gearing / (math.tau * self.wheel_radius)


@dataclass(frozen=True, slots=True)
class DrivetrainConstants:
    """What the modules have in common."""

    can_bus: str
    pigeon_id: int
