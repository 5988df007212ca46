"""Pigeon 2: yaw, pitch, roll and rates as physics writes them, and the yaw that robot code has set."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, NamedTuple

from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6_emulator.clock import SimulatedClock
from simcore.phoenix6_emulator.device import Device
from simcore.phoenix6_emulator.wire import Setting

__all__ = ["Pigeon2", "PigeonFrame"]


class PigeonFrame(NamedTuple):
    """What a Pigeon 2 tells robot code [deg, deg/s]."""

    yaw: float
    pitch: float
    roll: float
    rate_x: float
    rate_y: float
    rate_z: float
    supply: float
    time_ns: int

    @property
    def quaternion(self) -> tuple[float, float, float, float]:
        """Attitude (w, x, y, z): yaw, then pitch, then roll."""
        y, p, r = (math.radians(a) / 2.0 for a in (self.yaw, self.pitch, self.roll))
        cy, sy, cp, sp, cr, sr = math.cos(y), math.sin(y), math.cos(p), math.sin(p), math.cos(r), math.sin(r)
        return (
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        )


_new = tuple.__new__


class Pigeon2(Device):
    """One Pigeon 2.

    Args:
        device_id: CAN id.
        clock: Simulated time.
        defaults: Factory configuration.
    """

    model = "pigeon 2"
    type_number = 6

    def __init__(self, device_id: int, clock: SimulatedClock, defaults: Mapping[int, Setting]) -> None:
        super().__init__(device_id, clock, defaults)
        self.raw_yaw = 0.0
        """Yaw since switched on, continuous over turns [deg]."""
        self.pitch = self.roll = 0.0
        self.rates = [0.0, 0.0, 0.0]
        """About x, y and z [deg/s]."""
        self._offset = 0.0
        self.send_frame()

    def command(self, spn: int, value: float) -> None:
        """A new yaw."""
        if spn == SpnValue.PIGEON2_SET_YAW.value:
            self._offset = value - self.raw_yaw
        else:
            super().command(spn, value)

    def set_input(self, name: str, value: float) -> None:
        """What it measures, and its supply."""
        if name == "RawYaw":
            # The device takes the short way round.
            self.raw_yaw += math.remainder(value - self.raw_yaw, 360.0)
        elif name == "AddYaw":
            self.raw_yaw += value
        elif name == "Pitch":
            self.pitch = value
        elif name == "Roll":
            self.roll = value
        elif name.startswith("AngularVelocity"):
            self.rates["XYZ".index(name[-1])] = value
        elif name == "SupplyVoltage":
            self.supply = max(value, 4.0)
        else:
            super().set_input(name, value)

    def get_value(self, name: str) -> float | None:
        """What SimDevices show."""
        if name.startswith("AngularVelocity"):
            return self.rates["XYZ".index(name[-1])]
        return {
            "Yaw": self.yaw,
            "RawYaw": self.raw_yaw,
            "Pitch": self.pitch,
            "Roll": self.roll,
            "SupplyVoltage": self.supply,
        }.get(name)

    @property
    def yaw(self) -> float:
        """Yaw now, as robot code knows it [deg]."""
        return self.raw_yaw + self._offset

    def sample(self) -> PigeonFrame:
        """A frame of this moment; 250 a second, so past PigeonFrame.__new__, which is a Python function."""
        yaw, rates = self.raw_yaw + self._offset, self.rates
        return _new(PigeonFrame, (yaw, self.pitch, self.roll, rates[0], rates[1], rates[2], self.supply, self.clock.ns))

    signals: ClassVar[Mapping[int, Callable[[Any], float]]] = {
        SpnValue.PIGEON2_YAW.value: lambda f: f.yaw,
        SpnValue.PIGEON2_PITCH.value: lambda f: f.pitch,
        SpnValue.PIGEON2_ROLL.value: lambda f: f.roll,
        SpnValue.PIGEON2_ANGULAR_VELOCITY_X.value: lambda f: f.rate_x,
        SpnValue.PIGEON2_ANGULAR_VELOCITY_Y.value: lambda f: f.rate_y,
        SpnValue.PIGEON2_ANGULAR_VELOCITY_Z.value: lambda f: f.rate_z,
        SpnValue.PIGEON2_ANGULAR_VELOCITY_X_WORLD.value: lambda f: f.rate_x,
        SpnValue.PIGEON2_ANGULAR_VELOCITY_Y_WORLD.value: lambda f: f.rate_y,
        SpnValue.PIGEON2_ANGULAR_VELOCITY_Z_WORLD.value: lambda f: f.rate_z,
        SpnValue.PIGEON2_QUAT_W.value: lambda f: f.quaternion[0],
        SpnValue.PIGEON2_QUAT_X.value: lambda f: f.quaternion[1],
        SpnValue.PIGEON2_QUAT_Y.value: lambda f: f.quaternion[2],
        SpnValue.PIGEON2_QUAT_Z.value: lambda f: f.quaternion[3],
        SpnValue.PIGEON2_SUPPLY_VOLTAGE.value: lambda f: f.supply,
        SpnValue.PIGEON2_UP_TIME.value: lambda f: float(int(f.time_ns * 1e-9)),
    }
