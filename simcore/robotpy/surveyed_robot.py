"""Builds a robot program without running it, in the process of a survey, and prints what the survey found.

Run surveys in a process and a folder of their own: programs and vendors' libraries write files where they are started.
Phoenix 6 is simcore's own, which answers at once and writes nothing; with `real` as second argument it is CTRE's
simulation, for programs that ask for what the other does not model.
"""

from __future__ import annotations

import json
import os
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import hal
from phoenix6 import unmanaged

from simcore.robotpy.robot_program import load_robot_class
from simcore.robotpy.simulated_phoenix import install_simulated_phoenix

__all__ = ["print_survey"]

_SETTLE = 0.1  # [s]; until all devices have sent their signals
_kept: list[Any] = []
"""The robot, which would take its devices with it."""


def print_survey(look: Callable[[Path], dict[str, Any]], before: Callable[[], object] = lambda: None) -> None:
    """Build the program that the command line names, print one line of JSON and leave, whatever threads there are.

    Args:
        look: Is given the path of robot.py once the robot is built, also if it failed after it had built some of its
            devices, and returns the answer.
        before: Is called before the program is imported.
    """
    robot_file = Path(sys.argv[1])
    answer: dict[str, Any] = {}
    try:
        _build(robot_file, before, emulates="real" not in sys.argv[2:])
    except NotImplementedError as error:
        answer["not_modelled"] = str(error)
    except BaseException as error:  # whatever a team's program raises, or exits with, is the answer
        traceback.print_exc()
        answer["error"] = f"{type(error).__name__}: {error}"
    try:
        answer.update(look(robot_file))
    except Exception as error:
        traceback.print_exc()
        answer.setdefault("error", f"{type(error).__name__}: {error}")
    print("\n" + json.dumps(answer), flush=True)  # a library may be in the middle of a line of its own
    os._exit(0)


def _build(robot_file: Path, before: Callable[[], object], *, emulates: bool) -> None:
    clock = install_simulated_phoenix() if emulates else None
    if clock is None:
        unmanaged.set_phoenix_diagnostics_start_time(-1)
    hal.initialize(500, 0)
    before()
    robot = load_robot_class(robot_file)()
    _kept.append(robot)
    for step in ("robotInit", "_simulationInit"):
        getattr(robot, step, lambda: None)()
    if clock is not None:
        clock.step(_SETTLE)
