"""What one can get wrong about a drivetrain, and what one is told."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

from phoenix6.swerve import SwerveDrivetrain
from realtime import start
from swerve import build

import simcore.phoenix6.swerve as adapter
from simcore.errors import ConfigError
from simcore.robot.swerve_drive import SwerveDrive


def message(call) -> str:
    try:
        call()
    except ConfigError as error:
        return str(error)
    return "no error"


def main() -> None:
    start()
    robot = build(None)
    config = adapter.swerve_config(robot)
    constants = adapter.module_constants(robot)
    known = adapter._seen.pop(robot)
    early = message(lambda: adapter.swerve_config(robot))
    adapter._seen[robot] = known
    three = replace(config, modules=config.modules[:3])
    fewer = message(lambda: adapter.SwerveDrivetrainSim(robot, SwerveDrive(three)))

    # a drivetrain whose back right module has the front left one's motors
    modules = [*robot.modules[:3], robot.modules[0]]
    shared = SimpleNamespace(modules=modules, pigeon2=robot.pigeon2)
    twice = message(lambda: adapter.SwerveDrivetrainSim(shared, SwerveDrive(config), modules=constants))
    assert isinstance(robot, SwerveDrivetrain)
    print(json.dumps({"lateness_ms": 0.0, "early": early, "fewer": fewer, "twice": twice}), flush=True)


if __name__ == "__main__":
    main()
