"""The text of a new `simcore.toml`: every key with its meaning, those that need a choice commented out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from simcore.robot_file.camera_table import CAMERAS
from simcore.robot_file.drivetrain_table import DRIVETRAIN, drivetrain_text
from simcore.robot_file.further_robots import FURTHER_ROBOT
from simcore.robot_file.key_tables import KeyTable, comment_line, toml
from simcore.robot_file.manipulator_tables import CLAW, CLIMBER, COMPONENT, INTAKE, SHOOTER, STORAGE
from simcore.robot_file.mechanism_names import mechanism_kind, proposed_tables
from simcore.robot_file.mechanism_tables import KINDS, MECHANISM, MOTORS, PLACE
from simcore.robot_file.reader import AUTOS, ROBOT, SCATTER, START, TOP
from simcore.robot_file.robot_settings import FILE_NAME
from simcore.robot_file.sensor_tables import SENSOR, SENSORS

__all__ = ["FILE_NAME", "FoundCamera", "FoundMotor", "FoundPort", "reference", "template"]


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundMotor:
    """A motor of the robot program that no table describes yet, and what it is guessed to turn."""

    controller: str
    leader: int
    followers: tuple[int, ...] = ()
    opposed: tuple[int, ...] = ()
    gearing: float = 1.0
    inertia: float = 0.0
    """At the mechanism [kg m^2]."""
    friction_volts: float = 0.0
    """At which it begins to turn [V]."""
    motor: str = ""
    """One of `simcore.robot.dc_motor.MOTOR_NAMES`; empty: the one that its controller usually has."""
    name: str = ""
    """As the attribute that holds it suggests; empty: it suggests none."""
    turns_freely: bool = True
    """Whether the guess is a shaft without weight, stops and sensors, which a table can say."""
    remark: str = ""
    """What it holds or reads besides, or why its configuration could not be read."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundPort:
    """Something that the robot program has on ports, solenoid channels or CAN, beside its motors on CAN."""

    model: str
    """`PWM`, `DIO`, `Analog`, `Relay`, `REVPH 1 Solenoid`, `CANrange` or `CANdi`."""
    channels: tuple[int, ...]
    """Channels, or the CAN id."""
    made_by: str
    """Its WPILib class; empty if it is not known."""

    @property
    def title(self) -> str:
        """As comments name it."""
        text = f"{self.model} {' '.join(map(str, self.channels))}"
        return f"{text}: {self.made_by}" if self.made_by else text


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundCamera:
    """A camera, or a headset, that a robot program builds or asks for."""

    maker: str
    """As in the file: `limelight`, `photonvision` or `questnav`."""
    name: str = ""
    """Of its table, or as its `PhotonCamera` has it."""
    place: tuple[float, ...] = ()
    """x, y, z [m], roll, pitch, yaw [deg], where the program says where it sits; else empty."""
    source: str = ""
    """Who says so."""


def template(
    motors: Sequence[FoundMotor] | None = None,
    ports: Sequence[FoundPort] = (),
    cameras: Sequence[FoundCamera] = (),
    drivetrain: Mapping[str, Any] | None = None,
    *,
    every: bool = False,
) -> str:
    """The text: what was found with its guesses, which drives as without a file.

    Args:
        motors: Of the robot program; None: nobody has looked.
        ports: What else it has.
        cameras: That it builds or asks for.
        drivetrain: As the survey has it.
        every: Whether all other keys follow in comments.
    """
    found = drivetrain or {}
    live = ("center_of_mass_height",) if found.get("has_mass") else ("mass", "center_of_mass_height")
    parts = [
        _prose(
            "What `robotpy sim --simcore` cannot read from your program. Lengths in meters, angles in degrees,",
            "masses in kg. x is forward, y to the left, z up; a robot's origin is on the floor under its center.",
            "A table [[name]] may come several times. All keys: docs/simcore_toml.md, or simcore init --all.",
        ),
        *(["".join(key.line() for key in TOP.keys if key.name != "field_size")] if every else []),
        _live(ROBOT, *live, every=every),
        _live(START, *(key.name for key in START.keys), every=every),
        _drivetrain(found),
        _mechanisms(motors or ()),
    ]
    if every:
        parts += [
            *(AUTOS.example(), SCATTER.example(only=("scale",)), _kinds(), _proposed(motors or ())),
            *(table.example() for table in (STORAGE, INTAKE, SHOOTER, CLAW, CLIMBER, COMPONENT)),
            FURTHER_ROBOT.example(without=("auto", "script", "log")),  # one of four
            *(*_cameras(cameras), *_sensors(ports)),
        ]
    else:
        rest = [f"camera {c.name or c.maker}" + (f": placed by {c.source}" if c.source else "") for c in cameras]
        rest += [port.title for port in ports]
        parts.append(
            _prose("Your program has these too; simcore init --all writes tables for them:", *rest) if rest else ""
        )
    return "\n".join(part for part in parts if part)


def reference() -> str:
    """The documentation of all tables, in Markdown."""
    tables = (
        *(
            TOP,
            ROBOT,
            DRIVETRAIN,
            START,
            AUTOS,
            KeyTable(SCATTER.head, SCATTER.about, SCATTER.keys[:1]),
            MECHANISM,
            MOTORS,
        ),
        *(KeyTable(f'[[mechanism]], kind = "{k}"', t.about, t.keys) for k, t in KINDS.items()),
        KeyTable(f"[[mechanism]], {PLACE.head}", PLACE.about, PLACE.keys),
        *(STORAGE, INTAKE, SHOOTER, CLAW, CLIMBER, COMPONENT, FURTHER_ROBOT),
        *(KeyTable(f'[[camera]], maker = "{k}"', t.about, t.keys) for k, t in CAMERAS.items()),
        SENSOR,
        *(KeyTable(f'[[sensor]], kind = "{k}"', t.about, t.keys) for k, t in SENSORS.items()),
    )
    return "\n".join(line for table in tables for line in table.reference())


def _prose(*lines: str) -> str:
    """Lines in comments."""
    return "".join(f"# {line}".rstrip() + "\n" for line in lines)


def _live(table: KeyTable, *names: str, every: bool) -> str:
    """A table of which some keys are set, and the others in comments or left out."""
    head = KeyTable(table.head, table.about, ()).example().removeprefix("# ")
    keys = [key for key in table.keys if every or key.name in names]
    return head + "".join(key.line(prefix="" if key.name in names else "# ") for key in keys)


def _drivetrain(found: Mapping[str, Any]) -> str:
    """What was found of it; where that is a library's or nothing, one line."""
    if "rows" in found:
        return drivetrain_text([tuple(row) for row in found["rows"]])
    about = found.get("lines", [found.get("problem", "")])[0]
    return _prose(f"[drivetrain]: {about}") if about else ""


# --- mechanisms -------------------------------------------------------------------------------------------------------


def _mechanisms(motors: Sequence[FoundMotor]) -> str:
    """A table for each motor whose guess a table can say, and a line for each of the others."""
    if not motors:
        return ""
    text = _prose(
        "Your program has these motors besides its drivetrain. Each turns freely, as simcore guesses: say what it",
        "is (kind) and weigh and measure it. A key that is left out stays a guess, which `simcore check` lists.",
    )
    for m, name in zip(motors, _names(motors), strict=True):
        kind = mechanism_kind(m.name)
        if m.turns_freely:
            text += "\n".join(_motor(m, name, kind)) + "\n"
        else:
            text += _prose(f"{name!r}, {m.controller} {m.leader}, stays a guess: {m.remark}")
    return text


def _names(motors: Sequence[FoundMotor]) -> list[str]:
    names = [m.name or f"motor{m.leader}" for m in motors]
    return [name if names.count(name) == 1 else f"{name}_{m.leader}" for m, name in zip(motors, names, strict=True)]


def _motor(m: FoundMotor, name: str, kind: str) -> list[str]:
    is_wheel = kind == "flywheel"
    values = {
        "name": name,
        "kind": kind if is_wheel else "roller",
        "leader": m.leader,
        "followers": m.followers,
        "opposed": m.opposed,
        "controller": "" if m.controller == "TalonFX" else m.controller,
        "motor": m.motor,
        "gearing": float(f"{m.gearing:.6g}"),
        "inertia": float(f"{m.inertia:.4g}"),
        "friction_volts": float(f"{m.friction_volts:.4g}") if is_wheel else "",
    }
    remarks = {"inertia": "a guess", "kind": "a guess"}
    if kind not in ("flywheel", "roller"):
        keys = ", ".join(key.name for key in KINDS[kind].keys if key.is_guess)
        remarks["kind"] = f'a guess; by its name "{kind}", with {keys}'
    return _found("[[mechanism]]", values, remarks)


def _proposed(motors: Sequence[FoundMotor]) -> str:
    """Tables of an intake and a shooter, as far as names mean them."""
    kinds = [mechanism_kind(m.name) for m in motors]
    tables = proposed_tables(list(zip(_names(motors), kinds, strict=True)))
    about = _prose(
        "Proposed by the names of motors. Which way it faces, its box, heights and angles are guesses: measure",
        "them, and look at the picture of `simcore check`.",
        "",
    )
    return f"{about}{tables}" if tables else ""


def _kinds() -> str:
    text = _prose("What each kind has besides (in brackets: may be left out):")
    for kind, table in KINDS.items():
        text += f"# Kind {kind}: {table.about}\n{table.meanings()}"
    more = [key for key in MOTORS.keys if key.name not in ("leader", "followers", "opposed", "motor", "gearing")]
    text += "# and all that motors turn:\n" + KeyTable("", "", tuple(more)).meanings()
    return text + f"# {PLACE.head}: {PLACE.about}\n{PLACE.meanings()}"


# --- cameras and ports ------------------------------------------------------------------------------------------------


def _cameras(cameras: Sequence[FoundCamera]) -> list[str]:
    texts = [
        KeyTable("[[camera]]", table.about, table.keys).example(without=("horizontal_fov_deg",), maker=maker)
        for maker, table in CAMERAS.items()
    ]
    if cameras:
        texts.append(_prose("Your program has these cameras. Take the # off those that it does not place itself, and",
                            "fill in where they sit."))  # fmt: skip
    for camera in cameras:
        x, y, z, roll, pitch, yaw = camera.place or (0.3, 0.0, 0.4, 0.0, -20.0, 0.0)
        values = {
            "maker": camera.maker,
            "name": camera.name,
            "type": "LL4" if camera.maker == "limelight" else "",
            **dict(zip(("x", "y", "z"), (float(f"{one:.3g}") for one in (x, y, z)), strict=True)),
            **({"roll_deg": roll} if roll else {}),
            **{"pitch_deg": pitch, "yaw_deg": yaw},
        }
        placed = f"placed already: {camera.source} says so, so it needs no table" if camera.source else ""
        texts.append(_prose(*_found("[[camera]]", values, {
            "maker": placed,
            "type": "not known: LL3, LL3A, LL3G or LL4",
            "x": "" if camera.place else "not known, nor the next lines",
        })))  # fmt: skip
    return texts


_NO_MOTORS = ("PWM", "Servo", "AddressableLED")
"""Classes on PWM ports; any other is a motor controller."""
_SENSOR_KINDS = {
    **{"Encoder": "encoder", "DutyCycleEncoder": "duty cycle encoder", "DutyCycle": "duty cycle encoder"},
    **{"AnalogEncoder": "analog encoder", "AnalogPotentiometer": "potentiometer", "DigitalInput": "beam break"},
    **{"CANrange": "canrange", "CANdi": "beam break"},
}


def _sensors(ports: Sequence[FoundPort]) -> list[str]:
    """An example of each kind, and a table for each thing that was found."""
    examples: dict[str, dict[str, Any]] = {  # of names and ports that differ
        "duty cycle encoder": {"name": "turret encoder", "mechanism": "turret"},
        "analog encoder": {"name": "arm encoder", "mechanism": "arm"},
        "potentiometer": {"name": "pivot pot", "mechanism": "pivot"},
        "limit switch": {"name": "hood down"},
        "beam break": {"name": "feeder beam", "dio": 3},
        "canrange": {"name": "hopper range"},
    }
    without = ("at_deg", "at_height", "at_extension", "within", "candi", "pin")
    texts = []
    for kind, table in SENSORS.items():
        hidden = (*without, "passing_time", *(("mechanism",) if kind == "canrange" else ()))
        whole = KeyTable(SENSOR.head, table.about, (*SENSOR.keys, *table.keys))
        texts.append(whole.example(without=hidden, **{"kind": kind, **examples.get(kind, {})}))
    inside = {(p.model, channel) for p in ports if p.made_by != "DigitalInput" for channel in p.channels}
    ports = [p for p in ports if p.made_by != "DigitalInput" or (p.model, p.channels[0]) not in inside]
    tables = [(port, _port(port)) for port in ports]
    if any(lines for _, lines in tables):
        texts.append(_prose("Your program has these besides. Take the # off what simcore shall simulate, and fill in",
                            "what only you know."))  # fmt: skip
    texts += [_prose(*lines) for _, lines in tables if lines]
    others = [port.title for port, lines in tables if not lines]
    return [*texts, _prose("And these, which no table describes:", *others)] if others else texts


def _port(port: FoundPort) -> list[str]:
    """The lines for one of them; none for what simcore cannot simulate, or shows by itself."""
    first, what = port.channels[0], port.made_by or port.model
    name = f"{port.model} {first}".lower()
    head = f"[[mechanism]]  # {port.title}"
    values: dict[str, Any]
    if port.model.endswith("Solenoid"):
        module, number, _ = port.model.split()
        values = {"solenoid": first if len(port.channels) == 1 else port.channels, "module": module}
        return _found(head, {"name": name, "kind": "piston", **values, "module_id": int(number), "stroke": 0.2,
                             "stroke_time": 0.4}, {})  # fmt: skip
    if (port.model == "PWM" and what not in _NO_MOTORS) or port.model == "Relay":
        values = {"controller": port.model, "leader": first, "gearing": 1.0}
        return _found(head, {"name": name, "kind": "roller", **values}, {})
    if what == "Servo":
        values = {"pwm": first, "min_deg": 0.0, "max_deg": 180.0, "deg_per_second": 400.0}
        return _found(head, {"name": name, "kind": "servo", **values}, {})
    if what not in _SENSOR_KINDS:
        return []
    kind = _SENSOR_KINDS[what]
    kind = "analog encoder" if kind == "duty cycle encoder" and port.model == "Analog" else kind
    of_kinds: dict[str, dict[str, Any]] = {
        "encoder": {"mechanism": "name", "dio": port.channels, "pulses_per_turn": 2048},
        "duty cycle encoder": {"mechanism": "name", "dio": first, "zero": 0.0},
        "analog encoder": {"mechanism": "name", "analog": first, "zero": 0.0},
        "potentiometer": {"mechanism": "name", "analog": first, "lower_volts": 0.0, "upper_volts": 5.0},
        "beam break": {"candi": first, "pin": 1, "at_least": 1} if what == "CANdi" else {"dio": first, "at_least": 1},
        "canrange": {"id": first, "at_least": 1, "distance": 0.05, "empty": 0.5},
    }
    more = "; pin 2 needs a table of its own" if what == "CANdi" else ""
    about = {"kind": f'or "limit switch" with mechanism and at{more}'} if kind == "beam break" else {}
    return _found(f"[[sensor]]  # {port.title}", {"name": name, "kind": kind, **of_kinds[kind]}, about)


def _found(head: str, values: Mapping[str, Any], about: Mapping[str, str]) -> list[str]:
    """Lines of a table of what was found; values that are empty are left out."""
    lines = [
        comment_line(f"{key} = {toml(value)}", about.get(key, "")).rstrip()
        for key, value in values.items()
        if value not in ("", (), [])
    ]
    return [head, *lines]
