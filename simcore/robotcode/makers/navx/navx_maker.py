"""Simulated Studica gyros for robot code that uses Studica's library: navX, with clockwise positive yaw, and navX3.

The library reads a navX's SimDevice on its own thread, 50 times a second on the wall clock. This module therefore
provides the return values of robot code's calls, in real and in simulated time. The module also writes the SimDevice,
for other readers. Displacement, velocity, accelerometer and compass are not simulated.

navX axes: x right, y forward, z up; pitch is positive nose up, roll left side down, yaw clockwise. Source: Studica's
navX-MXP manual, "Orientation", for a board that lies flat.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import navx
from wpilib.simulation import SimDeviceSim
from wpimath.geometry import Quaternion, Rotation2d, Rotation3d

from simcore.quantities import DeviceAddress
from simcore.robotcode.program.makers import Maker
from simcore.robotcode.program.motor_controllers import BuiltDevice
from simcore.robotcode.program.motor_ports import GyroPort
from simcore.robotcode.program.recorder import Answers, after_call

__all__ = ["MAKER", "Navx3Port", "NavxPort"]


class NavxPort:
    """Port of one navX, the `AHRS` object of robot code.

    `reset()` and `zeroYaw()` zero yaw and angle, but not quaternion and fused heading.

    Args:
        ahrs: Device object of robot code.
    """

    def __init__(self, ahrs: navx.AHRS) -> None:
        self.adjustment = float(ahrs.getAngleAdjustment())
        """Angle adjustment added to `angle` [deg]."""
        self._zero = self._turned = 0.0  # clockwise [deg]
        self.rate = self.pitch = self.roll = 0.0
        """Yaw rate [deg/s], pitch and roll [deg] with the navX's signs."""
        self._attitude = Rotation3d()
        sim = SimDeviceSim(f"navX-Sensor[{ahrs.getPort()}]")
        self._shown = [sim.getDouble(name) for name in ("Yaw", "Pitch", "Roll", "Rate", "FusedHeading")]
        _answers.attach(ahrs, self)

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """Write the angles since power-on [rad] and body rates [rad/s], counter-clockwise positive as in `GyroPort`."""
        self._turned = -math.degrees(yaw)
        self.pitch, self.roll, self.rate = -math.degrees(pitch), -math.degrees(roll), -math.degrees(rates[2])
        self._attitude = Rotation3d(roll, pitch, yaw)
        shown = math.remainder(self._turned, 360.0), self.pitch, self.roll, self.rate, self.fused_heading
        for value, reading in zip(self._shown, shown, strict=True):
            value.set(reading)

    @property
    def yaw(self) -> float:
        """Yaw since the last reset, clockwise, from -180 to 180 [deg]."""
        return math.remainder(self._turned - self._zero, 360.0)

    @property
    def angle(self) -> float:
        """Yaw since the last reset, clockwise and continuous over turns, plus the adjustment [deg]."""
        return self._turned - self._zero + self.adjustment

    @property
    def fused_heading(self) -> float:
        """Heading since power-on, clockwise, from 0 to 360 [deg]."""
        return self._turned % 360.0

    @property
    def quaternion(self) -> Quaternion:
        """Attitude since power-on, in navX axes."""
        q = self._attitude.getQuaternion()
        return Quaternion(q.W(), -q.Y(), q.X(), q.Z())

    def zero(self) -> None:
        """Set the yaw to zero, and the angle to the adjustment."""
        self._zero = self._turned

    def adjust(self, adjustment: float) -> None:
        """Set the angle adjustment [deg]."""
        self.adjustment = float(adjustment)


_NAVX3_ANGLES = ("Yaw", "Angle", "Pitch", "Roll")
_NAVX3_RATES = ("Velocity X", "Velocity Y", "Velocity Z")
_NAVX3_QUATERNIONS = ("Quaternion6", "Quaternion9")


class Navx3Port:
    """Port of one navX3, the `Navx` object of robot code; counter-clockwise positive like `Navx.getRotation2D`.

    The library reads the SimDevice without delay; `resetYaw()` zeroes the yaw but not the continuous angle. The other
    axes are assumed to match the robot axes: x forward, y left.

    Args:
        number: CAN ID of the device.
    """

    def __init__(self, number: int) -> None:
        sim = SimDeviceSim(f"NavX3[{number}]")
        self._yaw, *self._angles = (sim.getDouble(name) for name in _NAVX3_ANGLES)
        self._rates = [sim.getDouble(name) for name in _NAVX3_RATES]
        self._quaternions = [[sim.getDouble(f"{name} {part}") for part in "WXYZ"] for name in _NAVX3_QUATERNIONS]
        self._turned = self._zero = 0.0  # [deg]
        _navx3[number] = self

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """Write the angles since power-on [rad] and body rates [rad/s], counter-clockwise positive as in `GyroPort`."""
        self._turned = turned = math.degrees(yaw)
        self._yaw.set(math.remainder(turned - self._zero, 360.0))
        for value, angle in zip(self._angles, (turned, math.degrees(pitch), math.degrees(roll)), strict=True):
            value.set(angle)
        for value, rate in zip(self._rates, rates, strict=True):
            value.set(math.degrees(rate))
        q = Rotation3d(roll, pitch, yaw).getQuaternion()
        for parts in self._quaternions:
            for value, part in zip(parts, (q.W(), q.X(), q.Y(), q.Z()), strict=True):
                value.set(part)

    def zero(self) -> None:
        """Set the current yaw to zero, but not the continuous angle."""
        self._zero = self._turned


_navx3: dict[int, Navx3Port] = {}  # by CAN ID


def _note_reset(made: Any, _: Any, args: tuple[Any, ...], settings: dict[str, Any]) -> None:
    device = MAKER.device_of(made)
    if device is not None and device.address.number in _navx3:
        _navx3[device.address.number].zero()


_answers = Answers[NavxPort]()
_ANSWERS: dict[str, Any] = {
    "getYaw": lambda port: port.yaw,
    "getAngle": lambda port: port.angle,
    "getRotation2d": lambda port: Rotation2d.fromDegrees(-port.angle),
    "getRate": lambda port: port.rate,
    "getPitch": lambda port: port.pitch,
    "getRoll": lambda port: port.roll,
    "getFusedHeading": lambda port: port.fused_heading,
    "getRotation3d": lambda port: Rotation3d(port.quaternion),
    "getQuaternionW": lambda port: port.quaternion.W(),
    "getQuaternionX": lambda port: port.quaternion.X(),
    "getQuaternionY": lambda port: port.quaternion.Y(),
    "getQuaternionZ": lambda port: port.quaternion.Z(),
    "getAngleAdjustment": lambda port: port.adjustment,
    "isConnected": lambda port: True,
    "isCalibrating": lambda port: False,
}
_COMMANDS: dict[str, Any] = {
    "reset": lambda port: port.zero(),
    "zeroYaw": lambda port: port.zero(),
    "setAngleAdjustment": lambda port, angle: port.adjust(angle),
}


def _address_of_navx3(made: Any, args: tuple[Any, ...], settings: dict[str, Any]) -> DeviceAddress:
    return DeviceAddress(int(settings.get("deviceId", args[0] if args else settings.get("port", 0))))


def _create_spi() -> navx.AHRS:
    """Construct an `AHRS` on the MXP port's SPI bus with default settings."""
    return navx.AHRS(navx.AHRS.NavXComType.kMXP_SPI)


class _Studica(Maker):
    name = "Studica"
    gyros = ("navX", "navX3")
    gyro_errors = "navx2"
    sim_devices = ("navX-Sensor[", "NavX3[")

    def watch(self) -> None:
        self.devices.record(navx.AHRS, "navX", lambda made, args, settings: DeviceAddress(int(made.getPort())))
        ahrs: Any = navx.AHRS
        ahrs.create_spi = staticmethod(_create_spi)  # the library's own factory bypasses the recorded constructor
        self.devices.record(navx.Navx, "navX3", _address_of_navx3)
        after_call(navx.Navx, "resetYaw", _note_reset)
        _answers.wrap(navx.AHRS, _ANSWERS)
        _answers.wrap(navx.AHRS, _COMMANDS, also_original=True)

    def gyro_port(self, gyro: BuiltDevice) -> GyroPort:
        return NavxPort(gyro.hardware) if gyro.model == "navX" else Navx3Port(gyro.address.number)


MAKER = _Studica()
"""`Maker` of Studica's gyros, for `simcore.robotcode.program.makers`."""
