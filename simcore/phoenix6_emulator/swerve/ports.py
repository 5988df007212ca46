"""What the swerve drivetrain needs of its devices, and nothing more."""

from __future__ import annotations

from typing import Protocol

__all__ = ["Gyro", "ModuleDevices"]


class ModuleDevices(Protocol):
    """Two motors and an encoder; closed loops drive with what the module's constants ask for (volts or amperes)."""

    def sample(self) -> tuple[float, float, float, float]:
        """Drive rotor and azimuth as robot code reads them, positions carried on to the present by their velocities.

        Returns:
            Drive position [rotor rotations], drive velocity [1/s], azimuth [rotations], its velocity [1/s].
        """
        ...

    def drive_volts(self, volts: float, foc: bool) -> None:
        """Open loop [V]."""
        ...

    def drive_velocity(self, rps: float, amperes: float, volts: float, foc: bool) -> None:
        """Closed loop [rotor rotations/s], with a feed-forward in the unit that the loop drives with."""
        ...

    def steer_position(self, rotations: float, rps: float, foc: bool) -> None:
        """Closed loop, the short way round."""
        ...

    def steer_profiled(self, rotations: float, foc: bool) -> None:
        """The same under Motion Magic Expo."""
        ...

    def zero_drive(self) -> None:
        """The drive motor's position is 0 here."""
        ...

    def set_neutral(self, brake: bool) -> int:
        """Brake or coast the drive motor when it is not driven; returns a status code, 0 for OK."""
        ...

    def torque_constants(self) -> tuple[float, float]:
        """Of the drive motor: torque per current [N m/A], winding resistance [ohm]."""
        ...


class Gyro(Protocol):
    """The Pigeon 2."""

    def yaw(self) -> float:
        """As robot code reads it, carried on to the present, continuous [rad]."""
        ...
