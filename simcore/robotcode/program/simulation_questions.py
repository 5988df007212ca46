"""Interception of the program's `isReal`, `isSimulation` and `getSerialNumber` calls.

Code that makes these calls may behave differently in simulation. With `real = true` under `[robot]` of simcore.toml,
`isReal` returns True and `isSimulation` False, so the program builds the robot's devices. Libraries still get the
actual values.
"""

from __future__ import annotations

import logging
import sys
import types
from functools import cache
from pathlib import Path
from typing import Any

from simcore import season
from simcore.errors import ConfigError
from simcore.robot_file.reader import read_settings
from simcore.robot_file.robot_settings import FILE_NAME, RobotSettings

__all__ = ["answering_keys", "is_of_program", "place_of_question", "simulation_code", "watch_questions"]

_log = logging.getLogger(__name__)

_HERE = str(Path(__file__).resolve().parents[2])
_HOOKS = ("simulationperiodic", "simulation_periodic", "update_sim", "updatesim")
_asked: dict[types.CodeType, str] = {}
_serial_numbers: set[str] = set()
"""File and line of each call that reads the roboRIO's serial number."""


def is_of_program(code: types.CodeType) -> bool:
    """Return whether code belongs to the robot program instead of a library."""
    file = code.co_filename
    return not (file.startswith(("<", _HERE)) or "site-packages" in file)


def simulation_code(code: types.CodeType) -> bool:
    """Return whether a function is simulation code, by a typical name or by calls of `isReal` or `isSimulation`."""
    return code in _asked or code.co_name.lower().strip("_") in _HOOKS


def place_of_question() -> str:
    """Return file and line of the program's first `isReal` or `isSimulation` call; empty without such a call."""
    return next(iter(_asked.values()), "")


def answering_keys() -> list[str]:
    """Return the `[robot]` keys that set the results of the calls that the program has made."""
    return ["real"] * bool(_asked) + ["serial_number"] * bool(_serial_numbers)


@cache
def _settings(folder: Path) -> RobotSettings:
    """Return the settings in simcore.toml of the project that contains a folder; the defaults without a valid file."""
    for place in (folder, *folder.parents):
        if (place / "robot.py").is_file():
            try:
                return read_settings(place / FILE_NAME)
            except ConfigError:
                break  # the start of the simulation reports an invalid file
    return RobotSettings()


def watch_questions() -> None:
    """Intercept `isReal`, `isSimulation` and `getSerialNumber` from now on; safe to call more than once."""
    cls = season.wpilib.RobotBase
    for name, is_real in (("is_simulation", False), ("is_real", True)):
        own = season.own_name(cls, name)
        if hasattr(getattr(cls, own), "_asks"):
            continue
        setattr(cls, own, staticmethod(_question(getattr(cls, own), is_real)))
    controller = season.wpilib.RobotController
    own = season.own_name(controller, "get_serial_number")
    if not hasattr(getattr(controller, own), "_asks"):
        setattr(controller, own, staticmethod(_serial_number(getattr(controller, own))))


def _question(original: Any, is_real: bool) -> Any:
    def ask(*args: Any) -> bool:
        frame = sys._getframe(1)
        if not is_of_program(frame.f_code):
            return bool(original())
        path = Path(frame.f_code.co_filename)
        _asked.setdefault(frame.f_code, f"{path.name}:{frame.f_lineno}")
        return is_real if _settings(path.resolve().parent).real else bool(original())

    ask._asks = True  # type: ignore[attr-defined]
    return ask


def _serial_number(original: Any) -> Any:
    def ask(*args: Any) -> str:
        frame = sys._getframe(1)
        path = Path(frame.f_code.co_filename)
        if not is_of_program(frame.f_code):
            return str(original())
        place = f"{path.name}:{frame.f_lineno}"
        _serial_numbers.add(place)
        said = _settings(path.resolve().parent).serial_number
        if not said:
            _log.warning(
                "%s: the program asks for the serial number of the roboRIO, which has none in simulation: set "
                "serial_number under [robot] in %s to say which robot it is",
                *(place, FILE_NAME),
            )
        return said or str(original())

    ask._asks = True  # type: ignore[attr-defined]
    return ask
