"""Builds a robot program, without running it, and prints the motors that are not its drivetrain's: for `simcore init`.

Run it in a process and a folder of its own: devices write their configurations into `./ctre_sim`.
"""

from __future__ import annotations

import importlib.util
import json
import os
import sys
from pathlib import Path
from typing import Any

import hal
from phoenix6 import unmanaged
from wpilib import RobotBase

import simcore.phoenix6.swerve as swerve
from simcore.errors import ConfigError
from simcore.phoenix6.built_devices import BuiltDevice, FollowerGroup, built_devices, group_followers, key_of
from simcore.phoenix6.fallback import guess_mechanism

__all__ = ["main"]


def main() -> None:
    """Print one line of JSON and leave, whatever threads the program has started."""
    try:
        answer: dict[str, Any] = {"motors": _look()}
    except Exception as error:  # whatever a team's program raises is the answer
        answer = {"error": f"{type(error).__name__}: {error}"}
    print(json.dumps(answer), flush=True)
    os._exit(0)


def _look() -> list[dict[str, Any]]:
    path = Path(sys.argv[1])
    sys.path.insert(0, str(path.parent))
    unmanaged.set_phoenix_diagnostics_start_time(-1)
    hal.initialize(500, 0)
    robot = _robot_class(path)()
    for step in ("robotInit", "_simulationInit"):
        getattr(robot, step, lambda: None)()
    return [_describe(group) for group in group_followers(_free_motors())]


def _robot_class(path: Path) -> Any:
    """The robot class of robot.py: the last one that it defines itself."""
    spec = importlib.util.spec_from_file_location("robot", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["robot"] = module
    spec.loader.exec_module(module)
    classes = [
        value
        for value in vars(module).values()
        if isinstance(value, type) and issubclass(value, RobotBase) and value.__module__ == "robot"
    ]
    if not classes:
        raise ConfigError("robot.py defines no robot class")
    return classes[-1]


def _free_motors() -> list[BuiltDevice]:
    drive = {
        key_of(motor) for d in swerve.known_drivetrains() for m in d.modules for motor in (m.drive_motor, m.steer_motor)
    }
    return [d for d in built_devices() if d.model in ("TalonFX", "TalonFXS") and d.key not in drive]


def _describe(group: FollowerGroup) -> dict[str, Any]:
    guess = guess_mechanism(group)
    return {
        "controller": group.leader.model,
        "leader": group.leader.device_id,
        "followers": [f.device_id for f in group.followers],
        "opposed": [group.followers[k].device_id for k in group.opposed],
        "gearing": guess.mechanism.gearing,
        "has_gravity": guess.has_weight,
    }


if __name__ == "__main__":
    main()
