"""Motors, encoders and gyro of the drivetrain among the emulated devices.

A request with other numbers than the last only changes its set points: eight requests 250 times a second took 0.13 ms
of a tick, now 0.04.
"""

from __future__ import annotations

import math

from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6_emulator.control_requests import REQUESTS
from simcore.phoenix6_emulator.emulated_module import ModuleConstants, OutputType
from simcore.phoenix6_emulator.emulator import Emulator
from simcore.phoenix6_emulator.motor_constants import KRAKEN_X60

__all__ = ["PigeonYaw", "TalonModuleDevices"]

_NEUTRAL_MODE = SpnValue.CONFIG_NEUTRAL_MODE.value
_VOLTS = REQUESTS["VoltageOut"]
_TORQUE_PER_AMPERE = 0.0198
"""What a TalonFX reports for a Kraken X60 under field-oriented control [N m/A]."""


class TalonModuleDevices:
    """`ModuleDevices` made of two emulated TalonFX.

    Physics writes rotors once a step, and they do not move in between: the present reading is the latency-compensated
    one.

    Args:
        emulator: All devices.
        constants: Ids and output types.
    """

    def __init__(self, emulator: Emulator, constants: ModuleConstants) -> None:
        self._drive = emulator.talon(constants.drive_motor_id)
        self._steer = emulator.talon(constants.steer_motor_id)
        drives_torque = constants.drive_output == OutputType.TORQUE_CURRENT
        steers_torque = constants.steer_output == OutputType.TORQUE_CURRENT
        self._drive_torque = drives_torque
        self._steer_torque = steers_torque
        self._velocity = REQUESTS["VelocityTorqueCurrentFOC" if drives_torque else "VelocityVoltage"]
        self._position = REQUESTS["PositionTorqueCurrentFOC" if steers_torque else "PositionVoltage"]

    def sample(self) -> tuple[float, float, float, float]:
        """See `ModuleDevices`."""
        drive, steer = self._drive, self._steer
        drive.measure()
        steer.measure()
        return drive.pos, drive.vel, steer.pos, steer.vel

    def drive_volts(self, volts: float, foc: bool) -> None:
        """See `ModuleDevices`."""
        if self._drive.renew(_VOLTS, foc):
            self._drive.output = volts
        else:
            self._drive.apply(_VOLTS.name, update_freq_hz=0.0, output=volts, enable_foc=foc)

    def drive_velocity(self, rps: float, amperes: float, volts: float, foc: bool) -> None:
        """See `ModuleDevices`."""
        drive = self._drive
        if drive.renew(self._velocity, foc):
            drive.goal_v = rps
            drive.feed_forward = amperes if self._drive_torque else volts
        elif self._drive_torque:
            drive.apply(
                self._velocity.name,
                update_freq_hz=0.0,
                velocity=rps,
                feed_forward=amperes,
                override_coast_dur_neutral=True,
            )
        else:
            drive.apply(self._velocity.name, update_freq_hz=0.0, velocity=rps, feed_forward=volts, enable_foc=foc)

    def steer_position(self, rotations: float, rps: float, foc: bool) -> None:
        """See `ModuleDevices`."""
        steer = self._steer
        if steer.renew(self._position, foc):
            steer.goal_p = rotations
            steer.goal_v = rps
        elif self._steer_torque:
            steer.apply(self._position.name, update_freq_hz=0.0, position=rotations, velocity=rps)
        else:
            steer.apply(self._position.name, update_freq_hz=0.0, position=rotations, velocity=rps, enable_foc=foc)

    def steer_profiled(self, rotations: float, foc: bool) -> None:
        """See `ModuleDevices`."""
        if self._steer_torque:
            self._steer.apply("MotionMagicExpoTorqueCurrentFOC", update_freq_hz=0.0, position=rotations)
        else:
            self._steer.apply("MotionMagicExpoVoltage", update_freq_hz=0.0, position=rotations, enable_foc=foc)

    def zero_drive(self) -> None:
        """See `ModuleDevices`."""
        self._drive.set_position(0.0)

    def set_neutral(self, brake: bool) -> int:
        """See `ModuleDevices`."""
        self._drive.configure({_NEUTRAL_MODE: int(brake)})
        return 0

    def torque_constants(self) -> tuple[float, float]:
        """See `ModuleDevices`."""
        return _TORQUE_PER_AMPERE, 12.0 / KRAKEN_X60.stall_current


class PigeonYaw:
    """`YawSensor` made of an emulated Pigeon 2.

    Args:
        emulator: All devices.
        device_id: CAN id.
    """

    def __init__(self, emulator: Emulator, device_id: int) -> None:
        self._pigeon = emulator.pigeon(device_id)

    def yaw(self) -> float:
        """See `YawSensor`."""
        return math.radians(self._pigeon.yaw)
