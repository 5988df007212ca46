"""Builds a robot program, without running it, and prints the devices that are not its drivetrain's: for `simcore init`.

Run it in a process and a folder of its own: programs and vendors' libraries write files where they are started. Phoenix
6 is simcore's own, which answers at once and writes nothing; with `real` as second argument it is CTRE's simulation,
for programs that ask for what the other does not model.
"""

from __future__ import annotations

import json
import os
import sys
import traceback
from pathlib import Path
from typing import Any

import hal
from phoenix6 import unmanaged

import simcore.phoenix6.swerve as swerve
from simcore.errors import ConfigError
from simcore.phoenix6.built_devices import built_devices, key_of
from simcore.robot.motor_controllers import FollowerGroup
from simcore.robotpy.built_ports import built_ports  # from here on ports are noted; the robot object is built later
from simcore.robotpy.motor_families import FAMILIES, MotorFamily, watch_devices
from simcore.robotpy.robot_program import load_robot_class

__all__ = ["main"]


def main() -> None:
    """Print one line of JSON and leave, whatever threads the program has started."""
    answer: dict[str, Any] = {}
    try:
        _build(Path(sys.argv[1]), emulates="real" not in sys.argv[2:])
    except NotImplementedError as error:
        answer["not_modelled"] = str(error)
    except BaseException as error:  # whatever a team's program raises, or exits with, is the answer
        traceback.print_exc()
        answer["error"] = f"{type(error).__name__}: {error}"
    try:
        answer["motors"] = _motors()  # also what a program had built when it failed
    except Exception as error:
        traceback.print_exc()
        answer.setdefault("error", f"{type(error).__name__}: {error}")
    answer["ports"] = _ports()
    print("\n" + json.dumps(answer), flush=True)  # a library may be in the middle of a line of its own
    os._exit(0)


def _build(robot_file: Path, *, emulates: bool) -> None:
    if emulates:
        from simcore.robotpy.simulated_phoenix import install_simulated_phoenix

        install_simulated_phoenix()
    else:
        unmanaged.set_phoenix_diagnostics_start_time(-1)
    hal.initialize(500, 0)
    watch_devices()
    robot = load_robot_class(robot_file)()
    _kept.append(robot)
    for step in ("robotInit", "_simulationInit"):
        getattr(robot, step, lambda: None)()


_kept: list[Any] = []
"""The robot, which would take its devices with it."""


def _ports() -> list[dict[str, Any]]:
    """What is on ports of the roboRIO and on pneumatics modules, and CTRE's sensors that see switches or pieces."""
    ports = [{"model": p.model, "channels": list(p.channels), "made_by": p.made_by} for p in built_ports()]
    sensors = [d for d in built_devices() if d.model in ("CANrange", "CANdi")]
    return ports + [{"model": d.model, "channels": [d.device_id], "made_by": ""} for d in sensors]


def _motors() -> list[dict[str, Any]]:
    drive = {
        key_of(motor) for d in swerve.known_drivetrains() for m in d.modules for motor in (m.drive_motor, m.steer_motor)
    }
    found = []
    for family in FAMILIES:
        free = [d for d in family.devices() if d.model in family.controllers and d.key not in drive]
        found += [_describe(family, group) for group in family.groups(free)]
    return found


def _describe(family: MotorFamily, group: FollowerGroup) -> dict[str, Any]:
    known: dict[str, Any] = {
        "controller": group.leader.model,
        "leader": group.leader.device_id,
        "followers": [f.device_id for f in group.followers],
        "opposed": [group.followers[k].device_id for k in group.opposed],
    }
    try:
        guess = family.guess(group)
    except (ConfigError, NotImplementedError) as error:  # one motor that does not answer is no reason to know none
        return {**known, "problem": str(error)}
    return {**known, "gearing": guess.mechanism.gearing, "has_gravity": guess.has_weight}


if __name__ == "__main__":
    main()
