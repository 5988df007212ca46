"""Reads what `simcore.toml` says of devices that are no motor on CAN: sensors, servos, pistons, PWM controllers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from simcore.errors import ConfigError
from simcore.quantities import (
    DEGREES,
    DELAY,
    DURATION,
    GEARING,
    RATIO,
    ROBOT_HEIGHT,
    ROBOT_LENGTH,
    ROBOT_PLACE,
    Quantity,
)
from simcore.robot.mechanisms import ArmConfig, ElevatorConfig, FlywheelConfig, RackConfig, RollerConfig
from simcore.robot.positioned_mechanisms import PistonConfig, ServoConfig
from simcore.robot.robot_config import MechanismConfig, telemetry_name
from simcore.robot_file.device_settings import (
    BeamBreakSettings,
    EncoderSettings,
    LimitSwitchSettings,
    PieceView,
    PotentiometerSettings,
    RangeSettings,
    SensorSettings,
    SwitchInput,
)
from simcore.robot_file.robot_settings import MechanismSettings
from simcore.robot_file.toml_tables import Table

__all__ = ["POSITIONED_KINDS", "positioned_mechanism", "read_sensors"]

POSITIONED_KINDS = ("servo", "piston")
"""Kinds of mechanisms that are told where to go, and have neither motor nor gearing of their own to describe."""

_MOST_PWM, _MOST_DIO, _MOST_ANALOG, _MOST_CAN_ID, _MOST_SOLENOID = 19, 30, 7, 62, 15
_MODULES = {"REVPH": 1, "CTREPCM": 0}
"""WPILib's names of the pneumatics modules, and the CAN id that each has unless told otherwise."""
_SENSORS = (
    *("encoder", "duty cycle encoder", "analog encoder", "potentiometer"),
    *("limit switch", "beam break", "canrange"),
)
_PLACES = ("storage", "claw", "intake", "shooter")
_ANALOG_VOLTS = 5.0


def positioned_mechanism(t: Table, name: str, kind: str) -> MechanismSettings:
    """A `[[mechanism]]` of one of `POSITIONED_KINDS`.

    Raises:
        ConfigError: A key is missing, unknown, or makes no sense.
    """
    settings = _servo(t, name) if kind == "servo" else _piston(t, name)
    t.finish()
    return settings


def _servo(t: Table, name: str) -> MechanismSettings:
    channel = t.whole("pwm", most=_MOST_PWM)
    low, high = t.number("min_deg", DEGREES), t.number("max_deg", DEGREES)
    if not low < high:
        raise t.error("min_deg", f"must be below max_deg, got {low:g} and {high:g}")
    start = t.number("start_deg", DEGREES, low)
    if not low <= start <= high:
        raise t.error("start_deg", f"must be between min_deg and max_deg, got {start:g}")
    config = ServoConfig(
        min_angle=math.radians(low),
        max_angle=math.radians(high),
        start_angle=math.radians(start),
        speed=math.radians(t.number("deg_per_second", Quantity("deg/s", 0.0, 10_000.0, is_open=True))),
    )
    return MechanismSettings(
        name=name,
        config=config,
        motor="",
        controller="Servo",
        leader=channel,
        reversed=t.flag("reversed", False),
    )


def _piston(t: Table, name: str) -> MechanismSettings:
    channels = _one_or_two(t, "solenoid")
    module = t.choice("module", tuple(_MODULES), "REVPH")
    number = t.whole("module_id", _MODULES[module], most=_MOST_CAN_ID)
    is_reversed = t.flag("reversed", False)
    springs_out = is_reversed and len(channels) == 1
    config = PistonConfig(
        stroke=t.number("stroke", ROBOT_LENGTH),
        stroke_time=t.number("stroke_time", DURATION),
        is_double=len(channels) == 2,
        springs_out=springs_out,
        starts_extended=t.choice("start", ("in", "out"), "out" if springs_out else "in") == "out",
    )
    return MechanismSettings(
        name=name,
        config=config,
        motor="",
        controller="Solenoid",
        leader=channels[0],
        followers=channels[1:],
        module=f"{module} {number}",
        reversed=is_reversed,
    )


def _one_or_two(t: Table, key: str) -> tuple[int, ...]:
    """A channel, or the two of a double solenoid: forward, reverse."""
    wanted = f"a channel from 0 to {_MOST_SOLENOID}, or two: [forward, reverse]"
    if key not in t:
        raise t.error(key, f"is missing; it must be {wanted}")
    values = t.one_or_more_wholes(key, most=_MOST_SOLENOID)
    if len(values) > 2 or len(set(values)) < len(values):
        raise t.error(key, f"must be {wanted}; got {list(values)}")
    return values


# --- sensors ------------------------------------------------------------------------------------------------------


def read_sensors(tables: Sequence[Table], mechanisms: Mapping[str, MechanismSettings]) -> tuple[SensorSettings, ...]:
    """The `[[sensor]]` tables.

    Args:
        tables: Of the file.
        mechanisms: Of the file, by name.

    Raises:
        ConfigError: A key is missing, unknown, or makes no sense; or two sensors have one name or one port.
    """
    sensors: list[SensorSettings] = []
    names: dict[str, str] = {}
    owners: dict[tuple[str, int, int], str] = {}
    for table in tables:
        sensor = _sensor(table, mechanisms)
        key = telemetry_name(sensor.name)
        if not key or key in names:
            other = f"; {names[key]!r} has that already" if key else ""
            raise table.error("name", f"is {key!r} in telemetry, where each sensor needs a key of its own{other}")
        names[key] = sensor.name
        for model, number in sensor.keys:
            port = (model, number, sensor.input.pin if hasattr(sensor, "input") else 0)
            if port in owners:
                raise ConfigError(f"{table.where}: {model} {number} already belongs to {owners[port]!r}")
            owners[port] = sensor.name
        table.finish()
        sensors.append(sensor)
    return tuple(sensors)


def _sensor(t: Table, mechanisms: Mapping[str, MechanismSettings]) -> SensorSettings:
    name, kind = t.text("name"), t.choice("kind", _SENSORS)
    if kind == "beam break":
        return BeamBreakSettings(name=name, sees=_piece_view(t), input=_switch_input(t))
    if kind == "canrange":
        return _range(t, name, mechanisms)
    if not mechanisms:
        raise t.error("mechanism", "must name a mechanism, but there is no [[mechanism]] in the file")
    mechanism = t.choice("mechanism", tuple(mechanisms))
    config = mechanisms[mechanism].config
    if kind == "limit switch":
        low, high = _pressed_range(t, config)
        return LimitSwitchSettings(name=name, mechanism=mechanism, low=low, high=high, input=_switch_input(t))
    if kind == "potentiometer":
        _stops(t, config)
        return PotentiometerSettings(
            name=name,
            mechanism=mechanism,
            channel=t.whole("analog", most=_MOST_ANALOG),
            lower_volts=_volts(t, "lower_volts"),
            upper_volts=_volts(t, "upper_volts"),
        )
    if isinstance(config, PistonConfig):
        raise t.error("mechanism", f"must turn, and {mechanism!r} is a piston: a limit switch sees where it is")
    return _encoder(t, name, kind, mechanism)


def _volts(t: Table, key: str) -> float:
    return float(t.number(key, Quantity("V", 0.0, _ANALOG_VOLTS)))


def _encoder(t: Table, name: str, kind: str, mechanism: str) -> EncoderSettings:
    pulses = 0.0
    if kind == "encoder":
        channels = t.wholes("dio", most=_MOST_DIO)
        if len(channels) != 2 or channels[0] == channels[1]:
            raise t.error("dio", f"must be the two channels of the encoder, e.g. [0, 1]; got {list(channels)}")
        pulses = t.number("pulses_per_turn", GEARING)
    elif kind == "analog encoder":
        channels = (t.whole("analog", most=_MOST_ANALOG),)
    else:
        channels = (t.whole("dio", most=_MOST_DIO),)
    return EncoderSettings(
        name=name,
        mechanism=mechanism,
        kind=kind,
        channels=channels,
        gearing=t.number("gearing", GEARING, 1.0),
        reversed=t.flag("reversed", False),
        pulses_per_turn=pulses,
        zero=0.0 if kind == "encoder" else t.number("zero", RATIO, 0.0),
    )


def _switch_input(t: Table) -> SwitchInput:
    closed = t.choice("normally", ("open", "closed"), "open") == "closed"
    if "candi" in t and "dio" not in t:
        return SwitchInput(
            model="CANdi",
            number=t.whole("candi", most=_MOST_CAN_ID),
            pin=t.whole("pin", least=1, most=2),
            normally_closed=closed,
        )
    if "candi" in t:
        raise t.error("dio", "and candi cannot both be: a switch is wired to one of them")
    if "dio" not in t:
        raise t.error("dio", "is missing; it must be a DIO channel, or candi = <CAN id> and pin = 1 or 2 instead")
    return SwitchInput(model="DIO", number=t.whole("dio", most=_MOST_DIO), normally_closed=closed)


def _piece_view(t: Table) -> PieceView:
    place = t.choice("sees", _PLACES, _PLACES[0])
    of = {"at_least": ("storage",), "delay": ("storage",), "passing_time": ("intake", "shooter")}
    for key, places in of.items():
        if key in t and place not in places:
            raise t.error(key, f"goes with sees = {' or '.join(map(repr, places))}, not with {place!r}")
    return PieceView(
        place=place,
        at_least=t.whole("at_least", 1, least=1, most=500),
        kinds=t.texts("kinds"),
        delay=t.number("delay", DELAY, 0.0),
        passing_time=t.number("passing_time", DURATION, 0.1),
    )


def _range(t: Table, name: str, mechanisms: Mapping[str, MechanismSettings]) -> RangeSettings:
    number = t.whole("id", most=_MOST_CAN_ID)
    if "mechanism" not in t:
        near, far = t.number("distance", ROBOT_HEIGHT, 0.05), t.number("empty", ROBOT_HEIGHT, 0.5)
        return RangeSettings(name=name, device_id=number, distance=near, empty=far, sees=_piece_view(t))
    mechanism = t.choice("mechanism", tuple(mechanisms))
    if not isinstance(mechanisms[mechanism].config, (ElevatorConfig, RackConfig, PistonConfig)):
        raise t.error("mechanism", f"must be an elevator, rack or piston, which slide; got {mechanism!r}")
    return RangeSettings(name=name, device_id=number, distance=t.number("distance", ROBOT_HEIGHT), mechanism=mechanism)


# --- where mechanisms are -----------------------------------------------------------------------------------------


def _stops(t: Table, config: MechanismConfig) -> tuple[float, float]:
    """Lower and upper stop of a mechanism's shaft [rad], or of a piston's rod [m]."""
    if isinstance(config, (FlywheelConfig, RollerConfig)):
        raise t.error("mechanism", "must have stops, like an arm or an elevator; flywheels and rollers have none")
    if isinstance(config, (ArmConfig, ServoConfig)):
        return config.min_angle, config.max_angle
    if isinstance(config, ElevatorConfig):
        return config.min_height / config.drum_radius, config.max_height / config.drum_radius
    if isinstance(config, RackConfig):
        return 0.0, config.travel / config.pinion_radius
    return 0.0, config.stroke


def _pressed_range(t: Table, config: MechanismConfig) -> tuple[float, float]:
    """From where to where a switch is pressed: the last hundredth of the way to a stop, or around a place."""
    low, high = _stops(t, config)
    if isinstance(config, (ArmConfig, ServoConfig)):
        key, per_unit, quantity = "deg", math.pi / 180.0, DEGREES
    elif isinstance(config, ElevatorConfig):
        key, per_unit, quantity = "height", 1.0 / config.drum_radius, ROBOT_PLACE
    else:
        radius = config.pinion_radius if isinstance(config, RackConfig) else 1.0
        key, per_unit, quantity = "extension", 1.0 / radius, ROBOT_PLACE
    least = 0.01 * (high - low) / per_unit
    within = t.number("within", replace(quantity, least=0.0, is_open=True), least) * per_unit
    if f"at_{key}" in t and "at" not in t:
        place = t.number(f"at_{key}", quantity) * per_unit
        if not low <= place <= high:
            raise t.error(
                f"at_{key}", f"must be between the stops, {low / per_unit:g} and {high / per_unit:g} {quantity.unit}; "
                f"got {place / per_unit:g}"
            )  # fmt: skip
        return place - within, place + within
    at = t.choice("at", ("lower", "upper"))
    return (-math.inf, low + within) if at == "lower" else (high - within, math.inf)
