"""What `[[sensor]]` tables of `simcore.toml` say, in SI units and checked by their reader."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

__all__ = [
    "BeamBreakSettings",
    "EncoderSettings",
    "LimitSwitchSettings",
    "PieceView",
    "PotentiometerSettings",
    "RangeSettings",
    "SensorSettings",
    "SwitchInput",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class SwitchInput:
    """Where a switch, or a beam break, is wired to."""

    model: str
    """`DIO` or `CANdi`."""
    number: int
    """Channel, or CAN id."""
    pin: int = 0
    """Of a CANdi: 1 or 2."""
    normally_closed: bool = False
    """Whether its contact connects to ground while nothing touches it; else while something does."""

    @property
    def keys(self) -> list[tuple[str, int]]:
        """The port, as (model, number)."""
        return [(self.model, self.number)]


@dataclass(frozen=True, slots=True, kw_only=True)
class EncoderSettings:
    """An encoder on a mechanism."""

    name: str
    mechanism: str
    kind: str
    """`encoder` (quadrature), `duty cycle encoder` or `analog encoder`."""
    channels: tuple[int, ...]
    """DIO channels A and B, the DIO channel, or the analog channel."""
    gearing: float
    """Turns of the encoder per turn of the mechanism [-]."""
    reversed: bool
    """Whether it counts down while the mechanism goes up."""
    pulses_per_turn: float = 0.0
    """Of a quadrature encoder, per turn of itself."""
    zero: float = 0.0
    """What an absolute one reads with the mechanism at its zero, in the unit of robot code."""

    @property
    def keys(self) -> list[tuple[str, int]]:
        """Its ports, as (model, number)."""
        model = "Analog" if self.kind == "analog encoder" else "DIO"
        return [(model, channel) for channel in self.channels]


@dataclass(frozen=True, slots=True, kw_only=True)
class PotentiometerSettings:
    """A potentiometer on a mechanism, linear between its stops."""

    name: str
    mechanism: str
    channel: int
    """Analog channel."""
    lower_volts: float
    """At the mechanism's lower stop [V]."""
    upper_volts: float
    """At its upper stop [V]."""

    @property
    def keys(self) -> list[tuple[str, int]]:
        """Its port, as (model, number)."""
        return [("Analog", self.channel)]


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitSwitchSettings:
    """A switch that a mechanism presses."""

    name: str
    mechanism: str
    low: float
    """It is pressed from this position of the mechanism's shaft on [rad], or of a piston's rod [m]."""
    high: float
    """Up to this one."""
    input: SwitchInput

    @property
    def keys(self) -> list[tuple[str, int]]:
        """Its port, as (model, number)."""
        return self.input.keys


@dataclass(frozen=True, slots=True, kw_only=True)
class PieceView:
    """Which pieces in the robot a sensor sees."""

    place: str
    """`storage`, `claw`, `intake` or `shooter`."""
    at_least: int = 1
    """Of storage: it sees something when so many pieces are there."""
    kinds: tuple[str, ...] = ()
    """Kinds of pieces that it sees; none named: all."""
    delay: float = 0.0
    """Of storage: time that a piece takes from the intake to the sensor [s]."""
    passing_time: float = 0.1
    """Of intake and shooter: how long a piece that passes is seen [s]."""

    def __str__(self) -> str:
        what = " or ".join(self.kinds) or "pieces"
        if self.place == "storage":
            return f"sees {what} in storage from {self.at_least} on"
        return f"sees {what} " + ("in the claw" if self.place == "claw" else f"that pass the {self.place}")


@dataclass(frozen=True, slots=True, kw_only=True)
class BeamBreakSettings:
    """A light barrier that pieces in the robot break."""

    name: str
    sees: PieceView
    input: SwitchInput

    @property
    def keys(self) -> list[tuple[str, int]]:
        """Its port, as (model, number)."""
        return self.input.keys


@dataclass(frozen=True, slots=True, kw_only=True)
class RangeSettings:
    """A CANrange that looks at pieces in the robot, or at a mechanism that slides."""

    name: str
    device_id: int
    distance: float
    """To a piece, or to the mechanism at its lower stop [m]."""
    sees: PieceView | None = None
    """The pieces; None: it looks at a mechanism."""
    empty: float = 0.0
    """Where there is no piece [m]."""
    mechanism: str | None = None
    """An elevator, rack or piston, which goes away from it."""

    @property
    def keys(self) -> list[tuple[str, int]]:
        """The device, as (model, id)."""
        return [("CANrange", self.device_id)]


SensorSettings: TypeAlias = (
    EncoderSettings | PotentiometerSettings | LimitSwitchSettings | BeamBreakSettings | RangeSettings
)
"""Any of them; `name` and `keys` are common to all."""
