"""Builds a robot program, without running it, and prints the devices that are not its drivetrain's: for `simcore init`.

Run it in a process and a folder of its own: devices write their configurations into `./ctre_sim`.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any

import hal
from phoenix6 import unmanaged

import simcore.phoenix6.swerve as swerve
from simcore.phoenix6.built_devices import BuiltDevice, FollowerGroup, built_devices, group_followers, key_of
from simcore.phoenix6.fallback import guess_mechanism
from simcore.robotpy.built_ports import built_ports  # from here on ports are noted; the robot object is built later
from simcore.robotpy.robot_program import load_robot_class

__all__ = ["main"]


def main() -> None:
    """Print one line of JSON and leave, whatever threads the program has started."""
    try:
        robot = _built_robot()
        answer: dict[str, Any] = {"motors": _motors(), "ports": _ports()}
        del robot  # now its devices may go
    except Exception as error:  # whatever a team's program raises is the answer
        answer = {"error": f"{type(error).__name__}: {error}"}
    print("\n" + json.dumps(answer), flush=True)  # a library may be in the middle of a line of its own
    os._exit(0)


def _built_robot() -> Any:
    unmanaged.set_phoenix_diagnostics_start_time(-1)
    hal.initialize(500, 0)
    robot = load_robot_class(Path(sys.argv[1]))()
    for step in ("robotInit", "_simulationInit"):
        getattr(robot, step, lambda: None)()
    return robot


def _motors() -> list[dict[str, Any]]:
    return [_describe(group) for group in group_followers(_free_motors())]


def _ports() -> list[dict[str, Any]]:
    """What is on ports of the roboRIO and on pneumatics modules, and CTRE's sensors that see switches or pieces."""
    ports = [{"model": p.model, "channels": list(p.channels), "made_by": p.made_by} for p in built_ports()]
    sensors = [d for d in built_devices() if d.model in ("CANrange", "CANdi")]
    return ports + [{"model": d.model, "channels": [d.device_id], "made_by": ""} for d in sensors]


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
