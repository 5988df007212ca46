"""The text of a new `simcore.toml`: every key with its meaning, those that need a choice commented out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from simcore.robot_file.camera_table import CAMERAS
from simcore.robot_file.drivetrain_table import DRIVETRAIN
from simcore.robot_file.further_robots import FURTHER_ROBOT
from simcore.robot_file.key_tables import KeyTable, table_text
from simcore.robot_file.manipulator_tables import CLAW, CLIMBER, COMPONENT, INTAKE, SHOOTER, STORAGE
from simcore.robot_file.mechanism_names import mechanism_kind
from simcore.robot_file.mechanism_tables import KINDS, MECHANISM, MOTORS, PLACE
from simcore.robot_file.reader import AUTOS, ROBOT, SCATTER, START, TOP
from simcore.robot_file.robot_settings import FILE_NAME
from simcore.robot_file.sensor_tables import SENSOR, SENSORS

__all__ = ["FILE_NAME", "FoundCamera", "FoundMotor", "FoundPort", "reference", "template"]


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundMotor:
    """A motor of the robot program that no table describes yet, and what it is guessed to turn."""

    controller: str
    leader: int | str
    """As a file has it, for this and the others: `DeviceAddress.in_file`."""
    followers: tuple[int | str, ...] = ()
    opposed: tuple[int | str, ...] = ()
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
    channels: tuple[int | str, ...]
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
        TOP.example() if every else "",
        _live(ROBOT, *live, every=every),
        _live(START, *(key.name for key in START.keys), every=every),
        _drivetrain(found),
        _mechanisms(motors or ()),
    ]
    others = [f"camera {c.name or c.maker}" + (f": placed by {c.source}" if c.source else "") for c in cameras]
    others += [port.title for port in ports]
    if others:
        parts.append(_prose("Your program has these too, for [[camera]], [[sensor]] and [[mechanism]]:", *others))
    if every:
        parts += [table.example() for table in _tables() if table not in (TOP, ROBOT, START)]
    return "\n".join(part for part in parts if part)


def _tables() -> list[KeyTable]:
    """All that a file may have."""
    return [
        *(TOP, ROBOT, DRIVETRAIN, START, AUTOS, KeyTable(SCATTER.head, SCATTER.about, SCATTER.keys[:1])),
        *(MECHANISM, MOTORS),
        *(KeyTable(f'[[mechanism]], kind = "{k}"', t.about, t.keys) for k, t in KINDS.items()),
        KeyTable(f"[[mechanism]], {PLACE.head}", PLACE.about, PLACE.keys),
        *(STORAGE, INTAKE, SHOOTER, CLAW, CLIMBER, COMPONENT, FURTHER_ROBOT),
        *(KeyTable(f'[[camera]], maker = "{k}"', t.about, t.keys) for k, t in CAMERAS.items()),
        SENSOR,
        *(KeyTable(f'[[sensor]], kind = "{k}"', t.about, t.keys) for k, t in SENSORS.items()),
    ]


def reference() -> str:
    """The documentation of all tables, in Markdown."""
    return "\n".join(line for table in _tables() for line in table.reference())


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
        return table_text(DRIVETRAIN.head, map(tuple, found["rows"]))
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
        if m.turns_freely:
            text += _motor(m, name, mechanism_kind(m.name))
        else:
            text += _prose(f"{name!r}, {m.controller} {m.leader}, stays a guess: {m.remark}")
    return text


def _names(motors: Sequence[FoundMotor]) -> list[str]:
    places = [str(m.leader).replace(":", "_") for m in motors]
    names = [m.name or f"motor{place}" for m, place in zip(motors, places, strict=True)]
    return [name if names.count(name) == 1 else f"{name}_{place}" for name, place in zip(names, places, strict=True)]


def _motor(m: FoundMotor, name: str, kind: str) -> str:
    is_wheel, about = kind == "flywheel", "a guess"
    if kind not in ("flywheel", "roller"):
        keys = ", ".join(key.name for key in KINDS[kind].keys if key.is_guess)
        about = f'a guess; by its name "{kind}", with {keys}'
    rows = [
        ("name", name, ""),
        ("kind", kind if is_wheel else "roller", about),
        ("leader", m.leader, ""),
        ("followers", m.followers, ""),
        ("opposed", m.opposed, ""),
        ("controller", "" if m.controller == "TalonFX" else m.controller, ""),
        ("motor", m.motor, ""),
        ("gearing", float(f"{m.gearing:.6g}"), ""),
        ("inertia", float(f"{m.inertia:.4g}"), "a guess"),
        ("friction_volts", float(f"{m.friction_volts:.4g}") if is_wheel else "", ""),
    ]
    return table_text("[[mechanism]]", rows)
