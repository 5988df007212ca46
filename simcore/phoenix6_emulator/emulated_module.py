"""One emulated swerve module: its constants, its devices, and the requests to its motors for a wanted state.

All rules here are measured at the outputs of Phoenix 6 26.3.0; see `tests/adapters/swerve_reference.json`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Protocol

from simcore.errors import ConfigError
from simcore.phoenix6_emulator.swerve_kinematics import wrap

__all__ = ["EmulatedModule", "ModuleConstants", "ModuleDevices", "OutputType"]

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


class ModuleDevices(Protocol):
    """Two motors and an encoder; closed loops drive with volts or amperes, by the module's constants."""

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


_COUPLING_GAIN = 1.0 - math.exp(-0.004 / 0.05)
"""Share of a new azimuth rate in the smoothed one, per call: a single pole of 50 ms made for 250 Hz, at any rate."""


class EmulatedModule:
    """State and control of one module.

    Args:
        constants: What it is built of.
        devices: Its motors and encoder.
    """

    def __init__(self, constants: ModuleConstants, devices: ModuleDevices) -> None:
        self.constants = constants
        self.devices = devices
        self.distance = 0.0
        """Travel of the wheel on the carpet, without what steering alone turned it [m]."""
        self.angle = 0.0
        """Azimuth, continuous [rad]."""
        self.cos, self.sin = 1.0, 0.0
        """Of the azimuth."""
        self.speed = 0.0
        """From the drive motor alone, steering included, as `SwerveModuleState` has it [m/s]."""
        self.target = (0.0, 0.0)
        """Last speed [m/s] and direction [rad], turned the short way round."""
        self._per_meter = constants.rotations_per_meter
        self._coupling = constants.coupling
        self._volts_per_rps = 12.0 / (self._per_meter * constants.speed_at_12_volts)
        self._torque_per_force = constants.wheel_radius / constants.drive_gearing
        self._steer_rate = 0.0
        self._smooth_steer_rate = 0.0

    def refresh(self) -> float:
        """Read the sensors; returns the travel since the last call [m]."""
        drive, drive_rate, azimuth, self._steer_rate = self.devices.sample()
        before = self.distance
        self.distance = (drive - azimuth * self._coupling) / self._per_meter
        self.angle = angle = azimuth * math.tau
        self.cos, self.sin = math.cos(angle), math.sin(angle)
        self.speed = drive_rate / self._per_meter
        return self.distance - before

    def look(self) -> tuple[float, float]:
        """Travel [m] and azimuth [rad] at this moment; odometry is not affected."""
        drive, _, azimuth, _ = self.devices.sample()
        return (drive - azimuth * self._coupling) / self._per_meter, azimuth * math.tau

    def zero(self) -> None:
        """Set the drive motor's position to 0 here; odometry does not count that as travel."""
        self.devices.zero_drive()
        self.distance = self.look()[0]

    def apply(
        self,
        speed: float,
        angle: float,
        *,
        closed_loop: bool,
        profiled: bool,
        period: float = 0.0,
        force_x: float = 0.0,
        force_y: float = 0.0,
        foc: bool = True,
    ) -> None:
        """Drive at `speed` [m/s] in the direction `angle` [rad], the wheel turned backwards where that is shorter.

        The drive speed is multiplied by the cosine of the azimuth's error, and corrected for the coupling of steer and
        drive gears.

        Args:
            speed: [m/s]
            angle: Robot frame [rad].
            closed_loop: Velocity control rather than volts in proportion.
            profiled: Steer under Motion Magic Expo.
            period: Time since the last call, for the azimuth's feed-forward; 0 for none [s].
            force_x: That the wheel shall put on the carpet beyond friction, robot frame [N].
            force_y: To the left [N].
            foc: Field-oriented commutation where the output is a voltage.
        """
        lack = wrap(angle - self.angle)
        if abs(lack) > 0.5 * math.pi:
            speed, angle, lack = -speed, angle + math.pi, wrap(lack + math.pi)
        angle = wrap(angle)
        rate = wrap(angle - self.target[1]) / (period * math.tau) if period > 0.0 else 0.0
        self.target = (speed, angle)
        devices = self.devices
        if profiled:
            devices.steer_profiled(angle / math.tau, foc)
        else:
            devices.steer_position(angle / math.tau, rate, foc)

        self._smooth_steer_rate += _COUPLING_GAIN * (self._steer_rate - self._smooth_steer_rate)
        rps = speed * self._per_meter * max(math.cos(lack), 0.0) + self._smooth_steer_rate * self._coupling
        amperes = volts = 0.0
        if force_x != 0.0 or force_y != 0.0:
            force = force_x * self.cos + force_y * self.sin
            per_ampere, ohms = devices.torque_constants()
            amperes = force * self._torque_per_force / per_ampere
            volts = amperes * ohms
        if closed_loop:
            devices.drive_velocity(rps, amperes, volts, foc)
        else:
            devices.drive_volts(rps * self._volts_per_rps + volts, foc)
