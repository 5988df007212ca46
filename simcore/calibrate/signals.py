"""Identification of the quantity, side and unit of logged signals by the names of the signals."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from simcore.typing import FloatArray

__all__ = ["ROLES", "SIZES", "Signal", "find_roles", "quantity_of", "unit_of"]

ROLES = ("volts", "way", "speed", "yaw", "ground", "bus", "amps")
"""Roles of signals: measured quantities. On the command line, a role may have the prefix `left_` or `right_`."""


@dataclass(frozen=True, slots=True, eq=False)
class Signal:
    """Time series of a logged number."""

    times: FloatArray
    """Sample times in ascending order [s], shape (n,)."""
    values: FloatArray
    """Sample values in the signal's unit, shape (n,)."""
    unit: str = ""
    """Unit given by the log; empty if the log gives no unit."""
    is_kept: bool = False
    """Whether the log contains a sample of the signal only for each change of the value."""


_NOT = {
    "setpoint", "goal", "target", "desired", "reference", "error", "turn", "turning", "steer", "azimuth", "absolute",
    "temp", "temperature", "acceleration", "odometry", "measured", "rate", "autospeed",
}  # fmt: skip
"""Words that exclude a signal if the name contains one of the words, e.g. words for setpoints and steer motors."""
_SIDES = {
    **dict.fromkeys(("left", "l", "fl", "bl", "rl", "lf", "lr", "lb"), "left"),
    **dict.fromkeys(("right", "r", "fr", "br", "rr", "rf", "rb"), "right"),
}
_WORDS = {
    "ground": {"ground", "truth", "tape"},
    "yaw": {"yaw", "heading", "gyro"},
    "amps": {"current", "amps", "amp", "a", "amperes"},
    "speed": {"velocity", "speed", "vel", "mps", "rpm", "rps"},
    "volts": {"volts", "volt", "voltage", "v"},
    "way": {
        "position",
        "pos",
        "distance",
        "way",
        "m",
        "meters",
        "rotations",
        "turns",
        "rad",
        "angle",
        "deg",
        "encoder",
    },
}
"""Words that identify each quantity. If a name has words of several quantities, the first quantity applies."""
_SUPPLIED = {"battery", "bus", "input", "supply", "total", "pdh", "pdp"}
"""Words that identify a voltage or current of the battery rather than of a motor."""
_UNITS = {
    **dict.fromkeys(("m", "meter", "meters", "mps", "metre"), "m"),
    **dict.fromkeys(("in", "inch", "inches"), "in"),
    **dict.fromkeys(("ft", "foot", "feet"), "ft"),
    **dict.fromkeys(("rad", "radian", "radians"), "rad"),
    **dict.fromkeys(("deg", "degree", "degrees"), "deg"),
    **dict.fromkeys(("rot", "rotation", "rotations", "turn", "turns", "rev", "revs", "rps"), "turns"),
    "rpm": "rpm",
}


def _words(name: str) -> list[str]:
    """Return the words of a name in lower case.

    >>> _words("Drive/Module0/DrivePositionRad"), _words("left_V"), _words("Spark-3/AppliedOutputVoltage")
    (['drive', 'module', 'drive', 'position', 'rad'], ['left', 'v'], ['spark', 'applied', 'output', 'voltage'])
    """
    return [w.lower() for w in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name)]


def unit_of(name: str, said: str = "") -> str:
    """Return the unit of a signal: the unit that the log gives, or the unit in the name of the signal.

    The result is a key of `SIZES`, or empty if the unit is unknown.

    Args:
        name: Name of the signal.
        said: Unit given by the log.

    >>> unit_of("DrivePositionRad"), unit_of("left position", "Rotation"), unit_of("x", "Meter per Second")
    ('rad', 'turns', 'm')
    """
    found = [_UNITS[word] for word in (*_words(said), *reversed(_words(name))) if word in _UNITS]
    return found[0] if found else ""


def quantity_of(name: str) -> tuple[str, str]:
    """Return the quantity and the side that the name of a signal contains.

    The quantity is one of `ROLES`, `total` for a battery current, or empty if unknown or excluded. The side is `left`,
    `right` or empty.

    >>> quantity_of("left_V"), quantity_of("Drive/LeftPositionRad"), quantity_of("SystemStats/BatteryVoltage")
    (('volts', 'left'), ('way', 'left'), ('bus', ''))
    >>> quantity_of("Drive/Module0/TurnAppliedVolts"), quantity_of("voltage-left-drive")
    (('', ''), ('volts', 'left'))
    """
    words = _words(name)
    if _NOT & {*words}:
        return "", ""
    sides = [_SIDES[word] for word in words if word in _SIDES]
    quantity = next((quantity for quantity, known in _WORDS.items() if known & {*words}), "")
    if _SUPPLIED & {*words}:
        quantity = {"volts": "bus", "bus": "bus", "amps": "total"}.get(quantity, "")
    return quantity, sides[-1] if sides else ""


def find_roles(
    names: Iterable[str], devices: Mapping[str, str], said: Mapping[str, str], about: str
) -> dict[tuple[str, str], list[str]]:
    """Return the names of the best matching signals for each quantity and side; the side is empty if unknown.

    Args:
        names: Names of all signals.
        devices: Side of each drive motor by the motor's name in logs (`Spark-3`); empty sides for a swerve drive.
        said: Signal by role (e.g. `left_volts`) from the user, in place of all other signals of the role.
        about: Word in the names of the mechanism's signals; signals with this word are preferred. Empty for none.
    """
    found: dict[tuple[str, str], list[str]] = {}
    for name in names:
        quantity, side = quantity_of(name)
        own = [key for key in devices if re.search(rf"(^|/){re.escape(key)}/", name)]
        if quantity and (own or "spark" not in _words(name) or not devices):
            found.setdefault((quantity, devices[own[0]] if own else side), []).append(name)
    for role, name in said.items():
        side, _, quantity = role.rpartition("_")
        found[quantity, side] = [name]
        if quantity in ("way", "speed") and ("speed" if quantity == "way" else "way", side) in found:
            del found["speed" if quantity == "way" else "way", side]
    for key, some in found.items():
        for word in (about.lower(), "drive", "drivetrain", "output"):
            best = [name for name in some if word and word in _words(name)]
            some = best or some
        found[key] = some
    return found


SIZES = {"m": 1.0, "in": 0.0254, "ft": 0.3048, "rad": 1.0, "deg": math.pi / 180.0, "turns": math.tau,
         "rpm": math.tau / 60.0}  # fmt: skip
"""Factor that converts each unit to SI units [m, rad or rad/s]."""
