"""One swerve module: from the state it shall have to requests for its motors.

All rules here are measured at the outputs of Phoenix 6 26.3.0; see `tests/adapters/swerve_reference.json`.
"""

from __future__ import annotations

import math

from simcore.phoenix6_emulator.swerve.constants import ModuleConstants
from simcore.phoenix6_emulator.swerve.ports import ModuleDevices
from simcore.phoenix6_emulator.swerve.pose import wrap

__all__ = ["Module"]

_COUPLING_GAIN = 1.0 - math.exp(-0.004 / 0.05)
"""Share of a new azimuth rate in the smoothed one, per call: a single pole of 50 ms made for 250 Hz, at any rate."""


class Module:
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
        """Travel [m] and azimuth [rad] at this moment; odometry does not notice."""
        drive, _, azimuth, _ = self.devices.sample()
        return (drive - azimuth * self._coupling) / self._per_meter, azimuth * math.tau

    def zero(self) -> None:
        """The drive motor's position is 0 here; odometry does not take that for a move."""
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

        The drive motor turns slower by the cosine of what the azimuth still lacks, and faster by what the azimuth's
        gears take from it.

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
