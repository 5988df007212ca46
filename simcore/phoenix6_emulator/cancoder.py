"""CANcoder: a magnet's angle, with direction, offset and the range of its absolute reading."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, NamedTuple

from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6_emulator.clock import SimulatedClock
from simcore.phoenix6_emulator.device import Device
from simcore.phoenix6_emulator.wire import Setting

__all__ = ["CANcoder", "CANcoderFrame"]

_RANGE = 16384.0


class CANcoderFrame(NamedTuple):
    """What a CANcoder tells robot code [rotations, rotations/s]."""

    position: float
    since_boot: float
    velocity: float
    supply: float
    health: int
    top: float
    """Where the absolute position starts anew, as configured."""

    @property
    def absolute(self) -> float:
        """Absolute position, within one turn below the discontinuity point.

        A new position turns it too; so it is in CTRE's simulation.
        """
        return self.position - math.floor(self.position - self.top + 1.0)


_new = tuple.__new__


class CANcoder(Device):
    """One CANcoder.

    Args:
        device_id: CAN id.
        clock: Simulated time.
        defaults: Factory configuration.
    """

    model = "cancoder"
    type_number = 5

    def __init__(self, device_id: int, clock: SimulatedClock, defaults: Mapping[int, Setting]) -> None:
        super().__init__(device_id, clock, defaults)
        self.raw = 0.0
        """Angle that physics writes, counter-clockwise [rotations]."""
        self.raw_velocity = 0.0
        """[rotations/s]"""
        self.health = 3
        self._shift = 0.0
        self.configured()
        self.send_frame()

    def configured(self) -> None:
        """Take over direction, offset and range."""
        c = self.config
        self._sign = -1.0 if c[SpnValue.CANCODER_SENSOR_DIRECTION.value] else 1.0
        self._offset = c[SpnValue.CAN_CODER_MAGNET_OFFSET.value]
        self._top = c[SpnValue.CONFIG_ABSOLUTE_SENSOR_DISCONTINUITY_POINT.value]

    def command(self, spn: int, value: float) -> None:
        """A new position."""
        if spn == SpnValue.CANCODER_SET_SENSOR_POSITION.value:
            self._shift = value - self._sign * self.raw - self._offset
        else:
            super().command(spn, value)

    def set_input(self, name: str, value: float) -> None:
        """What it measures, and its supply."""
        if name == "RawPosition":
            self.raw = value
        elif name == "Velocity":
            self.raw_velocity = value
        elif name == "AddPosition":
            self.raw += value
        elif name == "MagnetHealth":
            self.health = int(value)
        elif name == "SupplyVoltage":
            self.supply = max(value, 4.0)
        else:
            super().set_input(name, value)

    def get_value(self, name: str) -> float | None:
        """What SimDevices show."""
        if name == "Position":
            return self.position
        return {"RawPosition": self.raw, "Velocity": self.raw_velocity, "SupplyVoltage": self.supply}.get(name)

    @property
    def position(self) -> float:
        """Position now, continuous over turns [rotations]."""
        return self._sign * self.raw + self._offset + self._shift

    def sample(self) -> CANcoderFrame:
        """A frame of this moment; 250 a second, so past CANcoderFrame.__new__, which is a Python function."""
        raw, sign = self.raw, self._sign
        position = sign * raw + self._offset + self._shift
        return _new(CANcoderFrame, (position, raw, sign * self.raw_velocity, self.supply, self.health, self._top))

    signals: ClassVar[Mapping[int, Callable[[Any], float]]] = {
        SpnValue.CANCODER_POSITION.value: lambda f: f.position,
        SpnValue.CANCODER_ABS_POSITION.value: lambda f: f.absolute,
        SpnValue.CANCODER_VELOCITY.value: lambda f: f.velocity,
        SpnValue.CAN_CODER_RAW_VEL.value: lambda f: f.velocity,
        SpnValue.CAN_CODER_RAW_POS.value: lambda f: f.since_boot,
        SpnValue.CAN_CODER_SUPPLY_VOLTAGE.value: lambda f: f.supply,
        SpnValue.CANCODER_MAG_HEALTH.value: lambda f: float(f.health),
    }
