"""Guesses of the name and kind of a mechanism from attribute names in robot code."""

from __future__ import annotations

import re

__all__ = ["mechanism_kind", "mechanism_name"]

_OF_MOTORS = {
    *("motor", "motors", "talon", "talonfx", "fx", "fxs", "spark", "max", "flex", "controller", "device", "leader"),
    *("main", "master", "primary", "kraken", "neo", "falcon", "vortex", "minion", "hardware", "the", "m", "k", "s"),
}
_OF_CLASSES = {
    *("subsystem", "component", "mechanism", "system", "robot", "container", "map", "hardware", "io", "real", "my"),
    *("main", "constants", "devices"),
}
_SIDES = {
    *("left", "right", "top", "bottom", "upper", "lower", "front", "back", "rear", "inner", "outer", "one", "two"),
    *("first", "second", "1", "2", "3", "4", "a", "b"),
}
_KINDS: dict[str, tuple[str, ...]] = {
    "turret": ("turret",),
    "arm": ("arm", "wrist", "pivot", "hood", "tilt", "shoulder", "elbow", "angle", "joint"),
    "elevator": ("elevator", "lift"),
    "rack": ("rack", "slide", "extension", "extender", "deploy"),
    "flywheel": ("flywheel", "shooter", "launcher"),
}
"""Words that indicate each kind of mechanism, in order of priority; other names indicate a roller."""


def mechanism_name(path: str) -> str:
    """Return a mechanism's name in snake case, without words for motors; empty if no other word is left.

    Args:
        path: Attributes that lead from the robot to the motor, joined by dots. If the last attribute names only a
            motor or a side, the names of the owners are added.

    >>> mechanism_name("Feeder1Motor"), mechanism_name("shooterMotorTop"), mechanism_name("arms.m_wristTalonFX")
    ('feeder1', 'shooter_top', 'wrist')
    >>> mechanism_name("container.intake_subsystem.motors.0"), mechanism_name("climber.io._left_motor")
    ('intake', 'climber_left')
    """
    *owners, attribute = (part for part in path.split(".") if not part.isdecimal())
    words = [word for word in _words(attribute) if word not in _OF_MOTORS]
    while owners and not set(words) - _SIDES:
        words = [word for word in _words(owners.pop()) if word not in _OF_CLASSES | _OF_MOTORS | {*words}] + words
    return "_".join(words) if set(words) - _SIDES else ""


def mechanism_kind(name: str) -> str:
    """Return the probable kind of a mechanism in `simcore.toml`.

    Args:
        name: Name of the mechanism, from `mechanism_name`.

    >>> [mechanism_kind(name) for name in ("intake_pivot", "shooter_top", "feeder1")]
    ['arm', 'flywheel', 'roller']
    """
    words = set(re.findall(r"[a-z]+", name))
    return next((kind for kind, those in _KINDS.items() if words.intersection(those)), "roller")


def _words(name: str) -> list[str]:
    """Split a name such as `shooterMotorTop` or `SHOOTER_MOTOR_TOP` into words in lower case."""
    apart = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name)
    return [word.lower() for word in apart.split("_") if word]
