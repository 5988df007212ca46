"""Functions that load a robot program's robot class and find parts of the robot object."""

from __future__ import annotations

import importlib.util
import inspect
import sys
from pathlib import Path
from typing import Any

from simcore.errors import ConfigError, UnknownNameError

__all__ = ["load_robot_class", "part_of"]


def load_robot_class(robot_file: Path) -> Any:
    """Import a robot.py as the RobotPy command line does, and return the robot class.

    Errors in the robot code propagate to the caller.

    Raises:
        ConfigError: robot.py does not define exactly one robot class.
    """
    import robotpy.main
    import wpilib

    robotpy.main.robot_py_path = robot_file  # wpilib.getDeployDirectory uses it
    folder = str(robot_file.parent)
    if folder not in sys.path:
        sys.path.insert(0, folder)
    name = robot_file.stem
    spec = importlib.util.spec_from_file_location(name, robot_file)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    found = [
        value
        for value in vars(module).values()
        if inspect.isclass(value) and issubclass(value, wpilib.RobotBase) and value.__module__ == name
    ]
    if len(found) != 1:
        raise ConfigError(
            f"{robot_file}: there must be one class derived from wpilib.RobotBase, got {[c.__name__ for c in found]}"
        )
    return found[0]


def part_of(robot: object, path: str) -> Any:
    """Return the attribute at a dotted path, e.g. `part_of(robot, "container.drivetrain")`.

    Raises:
        UnknownNameError: An attribute of the path is missing; the message suggests similar names.

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
