"""Text of a new `simcore.toml`: the devices of a robot program, and on request all other keys in comments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from simcore.robot_file.camera_table import CAMERAS
from simcore.robot_file.drivetrain_table import DRIVETRAIN
from simcore.robot_file.further_robots import FURTHER_ROBOT
from simcore.robot_file.key_tables import KeyTable, comment_line, table_text, toml
from simcore.robot_file.manipulator_tables import CLAW, CLIMBER, COMPONENT, INTAKE, SHOOTER, STORAGE
from simcore.robot_file.mechanism_names import mechanism_kind
from simcore.robot_file.mechanism_tables import KINDS, MECHANISM, MOTORS, PLACE
from simcore.robot_file.reader import AUTOS, ROBOT, SCATTER, START, TOP
from simcore.robot_file.robot_settings import FILE_NAME
from simcore.robot_file.sensor_tables import SENSOR, SENSORS

__all__ = ["FILE_NAME", "reference", "template"]

Found = Mapping[str, Any]
"""Results of the survey of a robot program, or a row of the results for one device."""


def template(found: Found | None = None, *, game: str = "", every: bool = False) -> str:
    """Return the text of a new `simcore.toml` with the results of a survey.

    The drivetrain in the file behaves like the drivetrain without a file.

    Args:
        found: Results of `simcore.robotcode.sim.robot_survey`; None without a survey.
        game: Name of the game to play; empty for no game in the file.
        every: Whether to add all other keys in comments.
    """
    found = found or {}
    drivetrain = found.get("drivetrain", {})
    live = ("center_of_mass_height",) if drivetrain.get("has_mass") else ("mass", "center_of_mass_height")
    others = [_camera(camera) for camera in found.get("cameras", ())] + [_port(port) for port in found.get("ports", ())]
    parts = [
        _prose(
            "Values that `robotpy sim --simcore` cannot read from your program. Lengths are in meters, angles in",
            "degrees, masses in kg. x is forward, y to the left, z up; the origin of the robot frame is on the floor",
            "under the robot's center. A table [[name]] may appear several times. `simcore init --all` writes all",
            "keys.",
        ),
        comment_line(f"game = {toml(game)}", "game to play; left out: the newest installed game") if game else "",
        KeyTable(TOP.head, TOP.about, TOP.keys[1:] if game else TOP.keys).example() if every else "",
        _live(ROBOT, *live, every=every, shown=found.get("answering_keys", ())),
        _live(START, *(key.name for key in START.keys), every=every),
        _drivetrain(drivetrain),
        _mechanisms(found.get("motors", ())),
        _prose("Other devices in your program, for tables [[camera]], [[sensor]] and [[mechanism]]:", *others)
        if others
        else "",
    ]
    if every:
        parts += [table.example() for table in _tables() if table not in (TOP, ROBOT, START)]
    return "\n".join(part for part in parts if part)


def _camera(camera: Found) -> str:
    """Return a comment about a camera, with the source of the camera's position if known."""
    placed = f": placed by {camera['source']}" if "source" in camera else ""
    return f"camera {camera.get('name') or camera['maker']}{placed}"


def _port(port: Found) -> str:
    """Return a comment about a device on ports, with the class of the device if known."""
    text = f"{port['model']} {' '.join(map(str, port['channels']))}"
    return f"{text}: {port['made_by']}" if port["made_by"] else text


def _tables() -> list[KeyTable]:
    """Return all tables that a file may have, in the order of the documentation."""
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
    """Return the documentation of all tables, in Markdown."""
    return "\n".join(line for table in _tables() for line in table.reference())


def _prose(*lines: str) -> str:
    """Format lines of text as TOML comments."""
    return "".join(f"# {line}".rstrip() + "\n" for line in lines)


def _live(table: KeyTable, *names: str, every: bool, shown: Sequence[str] = ()) -> str:
    """Format a table with active lines for `names`, and comment lines for `shown` or, with `every`, all other keys.

    Args:
        table: Table to format.
        names: Keys with active lines.
        every: Whether all other keys of the table become comment lines.
        shown: Keys with comment lines.
    """
    head = KeyTable(table.head, table.about, ()).example().removeprefix("# ")
    keys = [key for key in table.keys if every or key.name in (*names, *shown)]
    return head + "".join(key.line(prefix="" if key.name in names else "# ") for key in keys)


def _drivetrain(found: Found) -> str:
    """Format the drivetrain of a survey as a table, or as a comment line if the survey has no values."""
    if "rows" in found:
        return table_text(DRIVETRAIN.head, map(tuple, found["rows"]))
    about = found.get("lines", [found.get("problem", "")])[0]
    return _prose(f"[drivetrain]: {about}") if about else ""


# --- mechanisms -------------------------------------------------------------------------------------------------------


def _mechanisms(motors: Sequence[Found]) -> str:
    """Return the text of a `[[mechanism]]` table for each freely turning motor, and a comment for each other motor."""
    if not motors:
        return ""
    text = _prose(
        "Motors in your program outside the drivetrain. simcore guesses that the mechanism of each motor turns freely:",
        "enter the kind and the measured values. A missing key stays a guess, which `simcore check` lists.",
    )
    places = [str(m["leader"]).replace(":", "_") for m in motors]
    names = [m["name"] or f"motor{place}" for m, place in zip(motors, places, strict=True)]
    for m, own, place in zip(motors, names, places, strict=True):
        name = own if names.count(own) == 1 else f"{own}_{place}"
        if m["turns_freely"]:
            text += _motor(m, name, mechanism_kind(m["name"]))
        else:
            text += _prose(f"{name!r}, {m['controller']} {m['leader']}, stays a guess: {m['remark']}")
    return text


def _motor(m: Found, name: str, kind: str) -> str:
    is_wheel, about = kind == "flywheel", "a guess"
    if kind not in ("flywheel", "roller"):
        keys = ", ".join(key.name for key in KINDS[kind].keys if key.is_guess)
        about = f'a guess; by its name "{kind}", with {keys}'
    rows = [
        ("name", name, ""),
        ("kind", kind if is_wheel else "roller", about),
        *((key, m[key], "") for key in ("leader", "followers", "opposed")),
        ("controller", "" if m["controller"] == "TalonFX" else m["controller"], ""),
        ("motor", m["motor"], ""),
        ("gearing", float(f"{m['gearing']:.6g}"), ""),
        ("inertia", float(f"{m['inertia']:.4g}"), "a guess"),
        ("friction_volts", float(f"{m['friction_volts']:.4g}") if is_wheel else "", ""),
    ]
    return table_text("[[mechanism]]", rows)
