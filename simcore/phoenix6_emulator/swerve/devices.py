"""The drivetrain's motors, encoders and gyro among the devices of the stand-in."""

from __future__ import annotations

import math

from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6_emulator.electrical import KRAKEN_X60
from simcore.phoenix6_emulator.requests import REQUESTS, RequestKind
from simcore.phoenix6_emulator.swerve.constants import ModuleConstants, OutputType
from simcore.phoenix6_emulator.talon import ONE_SHOT_NS, Talon
from simcore.phoenix6_emulator.world import StandIn

__all__ = ["StandInGyro", "StandInModule"]

_NEUTRAL_MODE = SpnValue.CONFIG_NEUTRAL_MODE.value
_VOLTS = REQUESTS["VoltageOut"]
_TORQUE_PER_AMPERE = 0.0198
"""What a TalonFX reports for a Kraken X60 under field-oriented control [N m/A]."""


class StandInModule:
    """`ModuleDevices` made of two simulated TalonFX.

    Physics writes rotors once a step and they do not move in between, so the present reading is the compensated one.

    Args:
        standin: All devices.
        constants: Ids and output types.
    """

    def __init__(self, standin: StandIn, constants: ModuleConstants) -> None:
        self._drive = standin.talon(constants.drive_motor_id)
        self._steer = standin.talon(constants.steer_motor_id)
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
        if _repeats(self._drive, _VOLTS, foc):
            self._drive.output = volts
        else:
            self._drive.apply(_VOLTS.name, update_freq_hz=0.0, output=volts, enable_foc=foc)

    def drive_velocity(self, rps: float, amperes: float, volts: float, foc: bool) -> None:
        """See `ModuleDevices`."""
        drive = self._drive
        if _repeats(drive, self._velocity, foc):
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
        if _repeats(steer, self._position, foc):
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


def _repeats(talon: Talon, kind: RequestKind, foc: bool) -> bool:
    """Whether a request is the last one with other numbers, which then are all there is to change.

    Keeps the request from timing out. Eight requests 250 times a second: 0.13 ms of a tick became 0.04.
    """
    if talon.kind is not kind or talon._pending is not None or talon._expires is None:
        return False
    place = kind.slots.get("enable_foc")
    if place is not None and bool(talon.args[place]) != foc:
        return False
    talon._expires = talon.clock.ns + ONE_SHOT_NS
    return True


class StandInGyro:
    """`Gyro` made of a simulated Pigeon 2.

    Args:
        standin: All devices.
        device_id: CAN id.
    """

    def __init__(self, standin: StandIn, device_id: int) -> None:
        self._pigeon = standin.pigeon(device_id)

    def yaw(self) -> float:
        """See `Gyro`."""
        return math.radians(self._pigeon.yaw)
