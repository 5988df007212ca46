"""Emulated encoders: the magnet of a CANcoder, and what is wired to the two pins of a CANdi."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, NamedTuple

from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6_emulator.emulated_device import EmulatedDevice, Setting, SimulatedClock

__all__ = ["CANcoderFrame", "CANdiFrame", "EmulatedCANcoder", "EmulatedCANdi"]


class CANcoderFrame(NamedTuple):
    """Status frame of a CANcoder [rotations, rotations/s]."""

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

        `set_position` changes it too, as in CTRE's simulation.
        """
        return self.position - math.floor(self.position - self.top + 1.0)


_new = tuple.__new__


class EmulatedCANcoder(EmulatedDevice):
    """One CANcoder."""

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
        """Apply direction, offset and range."""
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
        """What it measures."""
        if name == "RawPosition":
            self.raw = value
        elif name == "Velocity":
            self.raw_velocity = value
        elif name == "AddPosition":
            self.raw += value
        elif name == "MagnetHealth":
            self.health = int(value)
        else:
            super().set_input(name, value)

    def get_value(self, name: str) -> float | None:
        """What SimDevices read."""
        if name == "Position":
            return self.position
        return {"RawPosition": self.raw, "Velocity": self.raw_velocity, "SupplyVoltage": self.supply}.get(name)

    @property
    def position(self) -> float:
        """Position now, continuous over turns [rotations]."""
        return self._sign * self.raw + self._offset + self._shift

    def sample(self) -> CANcoderFrame:
        """A frame of this moment; 250 a second, so without CANcoderFrame.__new__, which is a Python function."""
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


_FLOATING, _LOW, _HIGH = 0, 1, 2
_CLOSED: tuple[Callable[[int], bool], ...] = (
    lambda state: state != _FLOATING,
    lambda state: state == _FLOATING,
    lambda state: state != _HIGH,
    lambda state: state == _HIGH,
    lambda state: state != _LOW,
    lambda state: state == _LOW,
)
"""When a pin counts as closed, by `S1CloseStateValue`."""


class CANdiFrame(NamedTuple):
    """Status frame of a CANdi; pairs are pins 1 and 2."""

    states: tuple[int, int]
    closed: tuple[bool, bool]
    positions: tuple[float, float]
    velocities: tuple[float, float]
    rises: tuple[float, float]
    quadrature: float
    quadrature_velocity: float
    supply: float
    current: float


class EmulatedCANdi(EmulatedDevice):
    """One CANdi."""

    model = "candi"
    type_number = 9

    def __init__(self, device_id: int, clock: SimulatedClock, defaults: Mapping[int, Setting]) -> None:
        super().__init__(device_id, clock, defaults)
        self.states = [_FLOATING, _FLOATING]
        """`S1StateValue` of each pin."""
        self._positions = [0.0, 0.0]
        self._velocities = [0.0, 0.0]
        self._rises = [4000.0, 4000.0]
        self._edges = 0.0
        self._edge_rate = 0.0
        self._shift = 0.0
        self._current = 0.0
        self.configured()
        self.send_frame()

    def configured(self) -> None:
        """Apply directions, offsets and close states."""
        c = self.config
        self._signs = [
            -1.0 if c[spn.value] else 1.0
            for spn in (SpnValue.CONFIG_PWM1_SENSOR_DIRECTION, SpnValue.CONFIG_PWM2_SENSOR_DIRECTION)
        ]
        self._offsets = [
            c[SpnValue.CONFIG_PWM1_ABSOLUTE_SENSOR_OFFSET.value],
            c[SpnValue.CONFIG_PWM2_ABSOLUTE_SENSOR_OFFSET.value],
        ]
        self._close = [int(c[SpnValue.CONFIG_S1_CLOSE_STATE.value]), int(c[SpnValue.CONFIG_S2_CLOSE_STATE.value])]
        sign = -1.0 if c[SpnValue.CONFIG_QUAD_SENSOR_DIRECTION.value] else 1.0
        self._per_edge = sign / (c[SpnValue.CONFIG_QUADRATURE_EDGES_PER_ROTATION.value] or 4096)

    def command(self, spn: int, value: float) -> None:
        """A new quadrature position."""
        if spn == SpnValue.CANDI_SET_QUAD_POSITION.value:
            self._shift = value - self._edges * self._per_edge
        else:
            super().command(spn, value)

    def set_input(self, name: str, value: float) -> None:
        """What is on the pins."""
        if name.startswith("PWM"):
            pin, what = int(name[3]) - 1, name[4:]
            if what == "Position":
                self._positions[pin] = value
            elif what == "Velocity":
                self._velocities[pin] = value
            elif what == "RiseRise":
                self._rises[pin] = value * 1e6
            elif what not in ("RiseFall", "Connected"):  # the simulated device shows no difference
                super().set_input(name, value)
        elif name in ("S1State", "S2State"):
            self.states[int(name[1]) - 1] = int(value)
        elif name == "RawQuadraturePosition":
            self._edges = value
        elif name == "AddQuadraturePosition":
            self._edges += value
        elif name == "QuadratureVelocity":
            self._edge_rate = value
        elif name == "RequestedOutputCurrent":
            self._current = value
        else:
            super().set_input(name, value)

    def get_value(self, name: str) -> float | None:
        """What `sim_state` reads."""
        return self._current if name == "OutputCurrent" else None

    def is_closed(self, pin: int) -> bool:
        """Whether pin 0 or 1 is closed now, as configured."""
        return _CLOSED[self._close[pin]](self.states[pin])

    def pwm_position(self, pin: int) -> float:
        """Of the pulse-width sensor on pin 0 or 1 now [rotations]."""
        return self._signs[pin] * self._positions[pin] + self._offsets[pin]

    def pwm_velocity(self, pin: int) -> float:
        """Of the pulse-width sensor on pin 0 or 1 now [rotations/s]."""
        return self._signs[pin] * self._velocities[pin]

    @property
    def quadrature(self) -> float:
        """Quadrature position now [rotations]."""
        return self._edges * self._per_edge + self._shift

    @property
    def quadrature_velocity(self) -> float:
        """Quadrature velocity now [rotations/s]."""
        return self._edge_rate * self._per_edge

    def sample(self) -> CANdiFrame:
        """A frame of this moment."""
        return CANdiFrame(
            (self.states[0], self.states[1]),
            (self.is_closed(0), self.is_closed(1)),
            (self.pwm_position(0), self.pwm_position(1)),
            (self.pwm_velocity(0), self.pwm_velocity(1)),
            (self._rises[0], self._rises[1]),
            self.quadrature,
            self.quadrature_velocity,
            self.supply,
            self._current,
        )

    signals: ClassVar[Mapping[int, Callable[[Any], float]]] = {
        SpnValue.CANDI_PIN1_STATE.value: lambda f: f.states[0],
        SpnValue.CANDI_PIN2_STATE.value: lambda f: f.states[1],
        SpnValue.CANDI_S1_CLOSED.value: lambda f: f.closed[0],
        SpnValue.CANDI_S2_CLOSED.value: lambda f: f.closed[1],
        SpnValue.CANDI_PWM1_POSITION.value: lambda f: f.positions[0],
        SpnValue.CANDI_PWM2_POSITION.value: lambda f: f.positions[1],
        SpnValue.CANDI_PWM1_VELOCITY.value: lambda f: f.velocities[0],
        SpnValue.CANDI_PWM2_VELOCITY.value: lambda f: f.velocities[1],
        SpnValue.CANDI_PWM1_RISE_TO_RISE.value: lambda f: f.rises[0],
        SpnValue.CANDI_PWM2_RISE_TO_RISE.value: lambda f: f.rises[1],
        SpnValue.CANDI_QUAD_POSITION.value: lambda f: f.quadrature,
        SpnValue.CANDI_QUAD_VELOCITY.value: lambda f: f.quadrature_velocity,
        SpnValue.CANDI_V_SENSE.value: lambda f: f.supply,
        SpnValue.CANDI_OUTPUT_CURRENT.value: lambda f: f.current,
        SpnValue.CANDI_OVERCURRENT.value: lambda f: 0.0,
    }
