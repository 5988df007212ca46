"""Table `[[sensor]]` of `simcore.toml`: encoders, switches, and sensors that detect pieces."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from simcore.errors import ConfigError
from simcore.quantities import (
    DEGREES,
    DELAY,
    DURATION,
    GEARING,
    RATIO,
    ROBOT_HEIGHT,
    ROBOT_PLACE,
    DeviceAddress,
    DeviceKey,
    Quantity,
)  # fmt: skip
from simcore.robot.mechanisms import (
    ArmConfig,
    ElevatorConfig,
    FlywheelConfig,
    PistonConfig,
    RackConfig,
    RollerConfig,
    ServoConfig,
)
from simcore.robot.robot_config import MechanismConfig, build_mechanism, telemetry_name
from simcore.robot_file.key_tables import Key, KeyTable, Named, Several, Table

__all__ = ["SENSORS", "PieceView", "SensorSettings", "read_sensors"]


# --- settings ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True)
class PieceView:
    """Pieces in the robot that a sensor detects; the keys of `_VIEW` explain the fields (`place` is the key `sees`)."""

    place: str
    at_least: int = 1
    kinds: tuple[str, ...] = ()
    delay: float = 0.0
    passing_time: float = 0.1

    def __str__(self) -> str:
        what = " or ".join(self.kinds) or "pieces"
        if self.place == "storage":
            return f"sees {what} in storage from {self.at_least} on"
        return f"sees {what} " + ("in the claw" if self.place == "claw" else f"that pass the {self.place}")


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorSettings:
    """Sensor of any kind; fields that do not apply to the kind keep their defaults."""

    name: str
    kind: str
    """Kind of the sensor, one of `SENSORS`."""
    keys: tuple[DeviceKey, ...]
    """Port or CAN device of the sensor; for a quadrature encoder, the ports of channels A and B."""
    mechanism: str | None = None
    """Name of the measured mechanism; None if the sensor detects pieces."""
    sees: PieceView | None = None
    """Pieces that a beam break or a CANrange detects; None if the sensor measures a mechanism."""
    pin: int = 0
    """Pin of the CANdi to which a switch or beam break is wired, 1 or 2; 0 without a CANdi."""
    normally_closed: bool = False
    """Whether the contact is closed to ground while the sensor is idle, instead of while triggered."""
    pressed: tuple[float, float] = (0.0, 0.0)
    """Range of positions in which a limit switch is pressed [rad], or [m] for a piston."""
    gearing: float = 1.0
    """Encoder turns per turn of the mechanism [-]; negative if the encoder counts down while the mechanism goes up."""
    pulses_per_turn: float = 0.0
    """Pulses per turn of a quadrature encoder [-]."""
    zero: float = 0.0
    """Reading that robot code gets from an absolute encoder with the mechanism at position 0, in the unit of that
    reading."""
    volts: tuple[float, float] = (0.0, 0.0)
    """Voltage of a potentiometer at the mechanism's lower and upper stop [V]."""
    distance: float = 0.0
    """Distance from a CANrange to a piece, or to the mechanism at the lower stop [m]."""
    empty: float = 0.0
    """Reading of a CANrange without a piece [m]."""


# --- keys -------------------------------------------------------------------------------------------------------------

_DIO, _ANALOG = Quantity("", 0, 30, is_whole=True), Quantity("", 0, 7, is_whole=True)
_VOLTS = Quantity("V", 0.0, 5.0)
_KINDS = (
    *("encoder", "duty cycle encoder", "analog encoder", "potentiometer"),
    *("limit switch", "beam break", "canrange"),
)
_MECHANISM = Key(
    "mechanism", Named("mechanism", "[[mechanism]]"), about="mechanism that the sensor measures", example="hood"
)
_TURNING = (
    Key("gearing", GEARING, 1.0, "encoder turns per turn of the mechanism"),
    Key("reversed", bool, False, "whether the encoder counts down while the mechanism moves up"),
)
_ZERO = Key("zero", RATIO, 0.0, "reading in your code at position 0 of the mechanism")

SENSOR = KeyTable("[[sensor]]", "a sensor; without a table, a sensor in the program detects nothing", (
    Key("name", str, about="name of the sensor", example="hood encoder"),
    Key("kind", _KINDS, about="kind of sensor"),
))  # fmt: skip
_INPUT = KeyTable("wiring of a switch or a beam break", "a DIO channel, or a pin of a CANdi", (
    Key("dio", _DIO, None, "DIO channel", 2),
    Key("candi", DeviceAddress, None, "CAN id of a CANdi with pin = 1 or 2, instead of dio", needs=("pin", "<1 or 2>")),
    Key("pin", Quantity("", 1, 2, is_whole=True), None, "pin of the CANdi", needs=("candi", "<CAN id>")),
    Key("normally", ("open", "closed"), "open", "open: a DIO reads True until the switch is pressed or the beam is "
        "broken; closed: the reverse"),
))  # fmt: skip
_VIEW = KeyTable("pieces that a beam break or a CANrange detects", "pieces in the robot, of all kinds or some", (
    Key("sees", ("storage", "claw", "intake", "shooter"), "storage", "location of the detected pieces; intake and "
        "shooter: pieces that pass", field="place"),
    Key("at_least", Quantity("", 1, 500, is_whole=True), 1, "number of stored pieces that triggers the sensor (only "
        "storage)"),
    Key("delay", DELAY, 0.0, "time that a piece takes from the intake to the sensor [s] (only storage)"),
    Key("passing_time", DURATION, 0.1, "time for which a passing piece is detected [s] (only intake and shooter)"),
    Key("kinds", Several(str), (), "kinds of pieces that the sensor detects; left out: all kinds", ["Name"]),
))  # fmt: skip
SENSORS = {table.head: table for table in (
    KeyTable("encoder", "a quadrature encoder, which reads 0 at the start", (
        _MECHANISM,
        Key("dio", Several(_DIO, or_one=False), about="both DIO channels of the encoder", example=[0, 1]),
        Key("pulses_per_turn", GEARING, about="pulses per turn of the encoder", example=2048),
        *_TURNING,
    )),
    KeyTable("duty cycle encoder", "an absolute encoder with a duty-cycle output on a DIO channel", (
        _MECHANISM, Key("dio", _DIO, about="DIO channel", example=4), *_TURNING, _ZERO,
    )),
    KeyTable("analog encoder", "an absolute encoder on an analog input", (
        _MECHANISM, Key("analog", _ANALOG, about="analog channel", example=0), *_TURNING, _ZERO,
    )),
    KeyTable("potentiometer", "a potentiometer or AnalogInput; the voltage is linear between the mechanism's stops", (
        _MECHANISM,
        Key("analog", _ANALOG, about="analog channel", example=1),
        Key("lower_volts", _VOLTS, about="voltage at the mechanism's lower stop [V]", example=0.5),
        Key("upper_volts", _VOLTS, about="voltage at the mechanism's upper stop [V]", example=4.5),
    )),
    KeyTable("limit switch", "a switch that a mechanism presses", (
        _MECHANISM,
        Key("at", ("lower", "upper"), None, "stop at which the switch is pressed; for a position between the stops, "
            "write at_deg, at_height or at_extension instead", "lower"),
        Key("at_deg", DEGREES, None, "angle of an arm, turret or servo at the switch [deg]"),
        Key("at_height", ROBOT_PLACE, None, "height of an elevator at the switch [m]"),
        Key("at_extension", ROBOT_PLACE, None, "extension of a rack or piston at the switch [m]"),
        Key("within", Quantity("", 0.0, 36_000.0, is_open=True), None, "largest distance from the switch at which the "
            "switch is pressed [m or deg]; left out: 1 % of the travel"),
        *_INPUT.keys,
    )),
    KeyTable("beam break", "a light barrier that pieces in the robot interrupt", (*_INPUT.keys, *_VIEW.keys)),
    KeyTable("canrange", "a CANrange that detects pieces or measures a sliding mechanism", (
        Key("id", DeviceAddress, about="CAN id", example=12),
        replace(_MECHANISM, default=None, about="elevator, rack or piston to measure, instead of pieces",
            example="lift"),
        Key("distance", ROBOT_HEIGHT, None, "distance to a piece, or to the mechanism at the lower stop [m]; left out: "
            "0.05 for a piece", 0.05),
        Key("empty", ROBOT_HEIGHT, 0.5, "reading without a piece [m]"),
        *_VIEW.keys,
    )),
)}  # fmt: skip


# --- reading ----------------------------------------------------------------------------------------------------------


def read_sensors(tables: Sequence[Table], mechanisms: Mapping[str, MechanismConfig]) -> tuple[SensorSettings, ...]:
    """Return the sensors in the `[[sensor]]` tables.

    Args:
        tables: Tables of the file.
        mechanisms: Mechanisms of the file, by name.

    Raises:
        ConfigError: A key is missing, unknown or invalid, or two sensors have the same name or port.
    """
    sensors: list[SensorSettings] = []
    names: dict[str, str] = {}
    owners: dict[tuple[DeviceKey, int], str] = {}
    for table in tables:
        sensor = _sensor(table, mechanisms)
        key = telemetry_name(sensor.name)
        if not key or key in names:
            other = f"; {names[key]!r} has that already" if key else ""
            raise table.error("name", f"is {key!r} in telemetry, where each sensor needs its own key{other}")
        names[key] = sensor.name
        for key_of_port in sensor.keys:
            port = (key_of_port, sensor.pin)
            if port in owners:
                model, address = key_of_port
                raise ConfigError(f"{table.where}: {model} {address} already belongs to {owners[port]!r}")
            owners[port] = sensor.name
        sensors.append(sensor)
    return tuple(sensors)


def _sensor(t: Table, mechanisms: Mapping[str, MechanismConfig]) -> SensorSettings:
    head = SENSOR.read(t)
    kind = head["kind"]
    v = SENSORS[kind].read(t, {"mechanism": tuple(mechanisms)})
    t.finish()
    mechanism = v.get("mechanism")
    head["mechanism"] = mechanism
    config = None if mechanism is None else mechanisms[mechanism]
    if kind == "beam break":
        return SensorSettings(**head, sees=_piece_view(t, v), **_wired(t, v))
    if kind == "canrange":
        return SensorSettings(**head, keys=(("CANrange", v["id"]),), **_range(t, config, v))
    assert config is not None
    if kind == "limit switch":
        return SensorSettings(**head, pressed=_pressed_range(t, config, v), **_wired(t, v))
    if kind == "potentiometer":
        _stops(t, config)
        volts = (v["lower_volts"], v["upper_volts"])
        return SensorSettings(**head, keys=(("Analog", DeviceAddress(v["analog"])),), volts=volts)
    if isinstance(config, PistonConfig):
        raise t.error("mechanism", f"must turn, and {mechanism!r} is a piston: a limit switch sees where it is")
    model, channels = ("DIO", v["dio"]) if "dio" in v else ("Analog", v["analog"])
    if kind != "encoder":
        channels = (channels,)
    elif len(channels) != 2 or channels[0] == channels[1]:
        raise t.error("dio", f"must be the two channels of the encoder, e.g. [0, 1]; got {list(channels)}")
    return SensorSettings(
        **head,
        keys=tuple((model, DeviceAddress(channel)) for channel in channels),
        gearing=-v["gearing"] if v["reversed"] else v["gearing"],
        **{name: v[name] for name in ("pulses_per_turn", "zero") if name in v},
    )


def _wired(t: Table, v: Mapping[str, Any]) -> dict[str, Any]:
    """Return port, pin and contact type of a switch or beam break, by field of `SensorSettings`."""
    closed = v["normally"] == "closed"
    if v["candi"] is not None and v["dio"] is not None:
        raise t.error("dio", "and candi exclude each other: a switch is wired to one of them")
    if v["candi"] is None and v["dio"] is None:
        raise t.error("dio", "is missing; it must be a DIO channel, or candi = <CAN id> and pin = 1 or 2 instead")
    if v["candi"] is None:
        return {"keys": (("DIO", DeviceAddress(v["dio"])),), "normally_closed": closed}
    return {"keys": (("CANdi", v["candi"]),), "pin": v["pin"], "normally_closed": closed}


def _piece_view(t: Table, v: Mapping[str, Any]) -> PieceView:
    place = v["place"]
    of = {"at_least": ("storage",), "delay": ("storage",), "passing_time": ("intake", "shooter")}
    for key, places in of.items():
        if key in t and place not in places:
            raise t.error(key, f"goes with sees = {' or '.join(map(repr, places))}, not with {place!r}")
    return PieceView(**{key.target: v[key.target] for key in _VIEW.keys})


def _range(t: Table, config: MechanismConfig | None, v: Mapping[str, Any]) -> dict[str, Any]:
    """Return the distances and the detected pieces of a CANrange, by field of `SensorSettings`."""
    if config is None:
        near = 0.05 if v["distance"] is None else v["distance"]
        return {"distance": near, "empty": v["empty"], "sees": _piece_view(t, v)}
    if not isinstance(config, (ElevatorConfig, RackConfig, PistonConfig)):
        raise t.error("mechanism", f"must be an elevator, rack or piston, which slide; got {v['mechanism']!r}")
    for key in ("empty", *(key.name for key in _VIEW.keys)):
        if key in t:
            raise t.error(key, "is for a CANrange that detects pieces; this one measures a mechanism")
    if v["distance"] is None:
        raise t.error("distance", f"is missing; it must be {ROBOT_HEIGHT}")
    return {"distance": v["distance"]}


def _stops(t: Table, config: MechanismConfig) -> tuple[float, float]:
    """Return the lower and upper stop of a mechanism's shaft [rad] or of a piston's rod [m]."""
    if isinstance(config, (FlywheelConfig, RollerConfig)):
        raise t.error("mechanism", "must have stops, like an arm or an elevator; flywheels and rollers have none")
    return build_mechanism(config).stops


def _pressed_range(t: Table, config: MechanismConfig, v: Mapping[str, Any]) -> tuple[float, float]:
    """Return the positions between which a switch is pressed [rad], or [m] for a piston.

    The default distance is 1 % of the mechanism's travel on either side of the switch.
    """
    low, high = _stops(t, config)
    if isinstance(config, (ArmConfig, ServoConfig)):
        key, per_unit, unit = "at_deg", math.pi / 180.0, "deg"
    elif isinstance(config, ElevatorConfig):
        key, per_unit, unit = "at_height", 1.0 / config.drum_radius, "m"
    else:
        key, per_unit, unit = "at_extension", 1.0 / getattr(config, "pinion_radius", 1.0), "m"
    for other in ("at_deg", "at_height", "at_extension"):
        if other in t and other != key:
            raise t.error(other, f"does not fit this mechanism: it must be {key}, or at = 'lower' or 'upper'")
    within = 0.01 * (high - low) if v["within"] is None else v["within"] * per_unit
    if key in t and "at" in t:
        raise t.error("at", f"and {key} exclude each other: a switch has one place")
    if key in t:
        place = v[key] * per_unit
        if low <= place <= high:
            return place - within, place + within
        ends = f"{low / per_unit:g} and {high / per_unit:g} {unit}"
        raise t.error(key, f"must be between the stops, {ends}; got {v[key]:g}")
    at = v["at"]
    if at is None:
        raise t.error("at", f'is missing; it must be "lower" or "upper", or {key} a place')
    return (-math.inf, low + within) if at == "lower" else (high - within, math.inf)
