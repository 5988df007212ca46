"""The devices of a robot program that are not its drivetrain's, as a line of JSON: for `simcore init`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import simcore.phoenix6.swerve as swerve
from simcore.errors import ConfigError
from simcore.phoenix6.built_devices import built_devices
from simcore.robot.motor_controllers import FollowerGroup
from simcore.robotpy.built_ports import built_ports  # from here on ports are noted; the robot object is built later
from simcore.robotpy.camera_survey import surveyed_cameras
from simcore.robotpy.motor_families import FAMILIES, MotorFamily, watch_devices
from simcore.robotpy.robot_cameras import watch_cameras
from simcore.robotpy.surveyed_robot import print_survey

__all__ = ["main"]


def main() -> None:
    """Print one line of JSON and leave."""
    print_survey(_look, before=_watch)


def _watch() -> None:
    watch_devices()
    watch_cameras()


def _look(robot_file: Path) -> dict[str, Any]:
    return {"motors": _motors(), "ports": _ports(), "cameras": surveyed_cameras(robot_file.parent)}


def _ports() -> list[dict[str, Any]]:
    """What is on ports of the roboRIO and on pneumatics modules, and CTRE's sensors that see switches or pieces."""
    ports = [{"model": p.model, "channels": list(p.channels), "made_by": p.made_by} for p in built_ports()]
    sensors = [d for d in built_devices() if d.model in ("CANrange", "CANdi")]
    return ports + [{"model": d.model, "channels": [d.device_id], "made_by": ""} for d in sensors]


def _motors() -> list[dict[str, Any]]:
    drive = swerve.drivetrain_motors()
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
