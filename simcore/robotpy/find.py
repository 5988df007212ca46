"""Finds a part of the robot object, or says what is there instead."""

from __future__ import annotations

from typing import Any

from simcore.errors import UnknownNameError

__all__ = ["part_of"]


def part_of(robot: object, path: str) -> Any:
    """The attribute at a dotted path, e.g. `part_of(robot, "container.drivetrain")`.

    Raises:
        UnknownNameError: A step of the path is not there; it names the nearest attributes.

    >>> part_of("frc", "upper").__name__
    'upper'
    >>> part_of("frc", "uper")
    Traceback (most recent call last):
    simcore.errors.UnknownNameError: no attribute of str named 'uper'. Did you mean 'upper' ...
    """
    found: Any = robot
    walked = type(robot).__name__
    for name in path.split("."):
        if not hasattr(found, name):
            known = [n for n in (*vars(type(found)), *getattr(found, "__dict__", ())) if not n.startswith("_")]
            raise UnknownNameError(f"attribute of {walked}", name, known)
        found = getattr(found, name)
        walked += f".{name}"
    return found
