"""The part of a new `simcore.toml` about what is on ports: servos, solenoids, encoders, switches, beam breaks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

__all__ = ["FoundPort", "ports_text"]


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundPort:
    """Something that the robot program has on ports, solenoid channels or CAN, beside its motors on CAN."""

    model: str
    """`PWM`, `DIO`, `Analog`, `Relay`, `REVPH 1 Solenoid`, `CANrange` or `CANdi`."""
    channels: tuple[int, ...]
    """Channels, or the CAN id."""
    made_by: str
    """Its WPILib class; empty if it is not known."""


_SENSORS = """\

# Sensors: one [[sensor]] each, of any name. What is not named here reads as if nothing were there.
#
# [[sensor]]                    # a quadrature encoder
# name = "hood encoder"
# kind = "encoder"
# mechanism = "hood"
# dio = [0, 1]
# pulses_per_turn = 2048        # of the encoder
# gearing = 1.0                 # turns of the encoder per turn of the mechanism
# reversed = false              # true if it counts down while the mechanism goes up
#
# [[sensor]]
# name = "turret encoder"
# kind = "duty cycle encoder"   # or "analog encoder" with analog = 0 instead of dio
# mechanism = "turret"
# dio = 4
# zero = 0.0                    # what your code reads with the mechanism at 0
#
# [[sensor]]
# name = "pivot pot"
# kind = "potentiometer"
# mechanism = "pivot"
# analog = 1
# lower_volts = 0.5             # at the mechanism's lower stop
# upper_volts = 4.5             # at its upper stop
#
# [[sensor]]
# name = "hood down"
# kind = "limit switch"
# mechanism = "hood"
# at = "lower"                  # or "upper"; or a place: at_deg = 30, at_height = 0.5 or at_extension = 0.1
# dio = 2                       # or candi = 30 and pin = 1 or 2
# normally = "open"             # a DIO reads True until it is pressed; "closed": False until it is pressed
#
# [[sensor]]                    # a light barrier that pieces in the robot break
# name = "feeder beam"
# kind = "beam break"
# dio = 3                       # or candi and pin
# normally = "open"             # a DIO reads True until the beam is broken; "closed": the other way round
# at_least = 1                  # broken when so many pieces are in the robot
# delay = 0.0                   # seconds that a piece takes from the intake to the beam
# kinds = ["Name"]              # kinds of pieces that it sees; left out: all
#
# [[sensor]]
# name = "intake beam"
# kind = "beam break"
# dio = 5
# sees = "intake"               # pieces that pass there; or "shooter"; or "claw": the piece in a claw
# passing_time = 0.1            # of intake and shooter: seconds for which a piece breaks it
#
# [[sensor]]
# name = "hopper range"
# kind = "canrange"             # sees pieces by the same keys; or a mechanism that slides: mechanism = "lift"
# id = 12
# distance = 0.05               # to a piece, or to the mechanism at its lower stop
# empty = 0.5                   # where there is no piece
"""

_FOUND = """\

# Your program has these besides. Take the # off what simcore shall simulate, and fill in what only you know.
"""

_MOTORS = (
    *("Koors40", "PWMSparkFlex", "PWMSparkMax", "PWMTalonFX", "PWMTalonSRX", "PWMVenom", "PWMVictorSPX"),
    *("Spark", "Talon", "VictorSP"),
)


def ports_text(ports: Sequence[FoundPort] = ()) -> str:
    """The text: every key of a sensor with its meaning, and a table for each thing that was found.

    Args:
        ports: Of the robot program; none if nobody could look.
    """
    part_of_another = {
        (port.model, channel) for port in ports if port.made_by != "DigitalInput" for channel in port.channels
    }
    ports = [p for p in ports if p.made_by != "DigitalInput" or (p.model, p.channels[0]) not in part_of_another]
    tables = {port: _table(port) for port in ports}
    text = _SENSORS
    if any(tables.values()):
        text += _FOUND
    for lines in tables.values():
        text += "".join(f"# {line}".rstrip() + "\n" for line in ["", *lines]) if lines else ""
    others = [_title(port) for port, lines in tables.items() if not lines]
    if others:
        text += "".join(f"# {line}".rstrip() + "\n" for line in ("", "And these, which no table describes:", *others))
    return text


def _table(port: FoundPort) -> list[str]:
    """The lines for one of them; none for what simcore cannot simulate, or shows by itself."""
    if port.model.endswith("Solenoid"):
        return _piston(port)
    if port.model == "PWM" and port.made_by in _MOTORS:
        return [*_mechanism(port, "roller"), 'controller = "PWM"', f"leader = {port.channels[0]}", "gearing = 1.0"]
    if port.model == "Relay":
        return [*_mechanism(port, "roller"), 'controller = "Relay"', f"leader = {port.channels[0]}", "gearing = 1.0"]
    make = _TABLES.get(port.made_by or port.model)
    return [] if make is None else make(port)


def _title(port: FoundPort) -> str:
    text = f"{port.model} {' '.join(map(str, port.channels))}"
    return f"{text}: {port.made_by}" if port.made_by else text


def _name(port: FoundPort) -> str:
    return f"{port.model} {port.channels[0]}".lower()


def _mechanism(port: FoundPort, kind: str) -> list[str]:
    return [f"[[mechanism]]  # {_title(port)}", f'name = "{_name(port)}"', f'kind = "{kind}"']


def _sensor(port: FoundPort, kind: str) -> list[str]:
    return [f"[[sensor]]  # {_title(port)}", f'name = "{_name(port)}"', f'kind = "{kind}"']


def _piston(port: FoundPort) -> list[str]:
    module, number, _ = port.model.split()
    channels = port.channels[0] if len(port.channels) == 1 else list(port.channels)
    return [
        *_mechanism(port, "piston"),
        f"solenoid = {channels}",
        f'module = "{module}"',
        f"module_id = {number}",
        "stroke = 0.2",
        "stroke_time = 0.4",
    ]


def _servo(port: FoundPort) -> list[str]:
    return [
        *_mechanism(port, "servo"),
        f"pwm = {port.channels[0]}",
        "min_deg = 0.0",
        "max_deg = 180.0",
        "deg_per_second = 400.0",
    ]


def _encoder(port: FoundPort) -> list[str]:
    return [
        *_sensor(port, "encoder"),
        'mechanism = "name"',
        f"dio = {list(port.channels)}",
        "pulses_per_turn = 2048",
    ]


def _absolute(port: FoundPort) -> list[str]:
    kind, key = ("analog encoder", "analog") if port.model == "Analog" else ("duty cycle encoder", "dio")
    return [*_sensor(port, kind), 'mechanism = "name"', f"{key} = {port.channels[0]}", "zero = 0.0"]


def _potentiometer(port: FoundPort) -> list[str]:
    return [
        *_sensor(port, "potentiometer"),
        'mechanism = "name"',
        f"analog = {port.channels[0]}",
        "lower_volts = 0.0",
        "upper_volts = 5.0",
    ]


def _beam_break(port: FoundPort) -> list[str]:
    kind = 'kind = "beam break"             # or "limit switch" with mechanism and at'
    return [*_sensor(port, "beam break")[:2], kind, f"dio = {port.channels[0]}", "at_least = 1"]


def _range(port: FoundPort) -> list[str]:
    return [*_sensor(port, "canrange"), f"id = {port.channels[0]}", "at_least = 1", "distance = 0.05", "empty = 0.5"]


def _candi(port: FoundPort) -> list[str]:
    kind = 'kind = "beam break"             # or "limit switch" with mechanism and at; pin 2 needs a table of its own'
    return [*_sensor(port, "beam break")[:2], kind, f"candi = {port.channels[0]}", "pin = 1", "at_least = 1"]


_TABLES: dict[str, Callable[[FoundPort], list[str]]] = {
    "Servo": _servo,
    "Encoder": _encoder,
    "DutyCycleEncoder": _absolute,
    "DutyCycle": _absolute,
    "AnalogEncoder": _absolute,
    "AnalogPotentiometer": _potentiometer,
    "DigitalInput": _beam_break,
    "CANrange": _range,
    "CANdi": _candi,
}
