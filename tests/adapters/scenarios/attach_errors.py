"""Mistakes with `--simcore` and their error messages, one after the other in one process."""

from __future__ import annotations

import json
import os
import socket
import sys
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import hal
import wpilib
from phoenix6 import hardware, swerve, unmanaged

import simcore.robotcode.makers.phoenix6.swerve as adapter
from simcore.errors import SimcoreError
from simcore.robot.swerve_drive import SwerveDrive
from simcore.robotcode.makers.phoenix6 import require_phoenix6
from simcore.robotcode.makers.phoenix6.built_devices import require_distinct
from simcore.robotcode.program.ownership import Ownership
from simcore.robotcode.sim.attach import is_port_taken
from simcore.robotcode.sim.attached_physics import AttachedPhysics

PORTS = {
    "PWM": '[[mechanism]]\nname = "hood"\nkind = "servo"\npwm = 7\nmin_deg = 0\nmax_deg = 90\ndeg_per_second = 400\n',
    "solenoid": '[[mechanism]]\nname = "deploy"\nkind = "piston"\nsolenoid = 3\nstroke = 0.2\nstroke_time = 0.4\n',
    "DIO": '[[sensor]]\nname = "beam"\nkind = "beam break"\ndio = 5\n',
    "CANrange": '[[sensor]]\nname = "beam"\nkind = "canrange"\nid = 5\n',
}


def message(call) -> str:
    try:
        call()
    except SimcoreError as error:
        return f"{type(error).__name__}: {error}"
    return "no error"


def attach() -> None:
    AttachedPhysics(SimpleNamespace(field=None), SimpleNamespace())


def main() -> None:
    sys.path.insert(0, str(Path(__file__).parents[1] / "robots" / "shared"))
    measures = import_module("measures")
    unmanaged.set_phoenix_diagnostics_start_time(-1)
    hal.initialize(500, 0)
    AttachedPhysics.ownership = Ownership()
    AttachedPhysics.folder = Path.cwd()
    file = Path("simcore.toml")
    said: dict[str, object] = {"lateness_ms": 0.0}
    said["no drivetrain"] = message(attach)

    constants = swerve.SwerveDrivetrainConstants().with_can_bus_name("").with_pigeon2_id(9)
    kinds = (hardware.TalonFX, hardware.TalonFX, hardware.CANcoder)
    two = swerve.SwerveDrivetrain(*kinds, constants, measures.modules()[:2])
    said["two modules"] = message(attach)
    adapter._seen.pop(two)

    whole = measures.build()
    others = measures.modules()
    for module in others:
        module.drive_motor_id += 40
    second = swerve.SwerveDrivetrain(*kinds, constants, others)
    said["two drivetrains"] = message(attach)
    adapter._seen.pop(second)

    config, kept = adapter.swerve_config(whole), adapter._seen.pop(whole)
    said["too early"] = message(lambda: adapter.swerve_config(whole))
    adapter._seen[whole] = kept
    three = SwerveDrive(replace(config, modules=config.modules[:3]))
    said["fewer modules"] = message(lambda: adapter.SwerveDrivetrainSim(whole, three))
    shared = SimpleNamespace(modules=[*whole.modules[:3], whole.modules[0]], pigeon2=whole.pigeon2)
    twice = {"modules": adapter.module_constants(whole)}  # the back right module has the motors of the front left one
    said["one motor twice"] = message(lambda: adapter.SwerveDrivetrainSim(shared, SwerveDrive(config), **twice))

    known = adapter.module_constants(whole)
    radius = known[2].wheel_radius
    known[2].wheel_radius = float("nan")
    said["no wheel radius"] = message(attach)
    known[2].wheel_radius = radius

    file.write_text('[[mechanism]]\nname = "roller"\nkind = "roller"\nleader = 30\ngearing = 2.0\n')
    roller = hardware.TalonFX(31)
    import simcore.robotcode.sim.attached_physics as attached
    from games.rebuilt import REBUILT

    attached.find_game, attached.installed_games = lambda name: REBUILT, lambda: {"rebuilt": REBUILT}
    said["unknown device"] = message(attach)
    ports = (wpilib.Spark(0), wpilib.DigitalInput(4))
    for name, text in PORTS.items():
        file.write_text(text)
        said[name] = message(attach)
    file.write_text("[robot]\nmass = -1\n")
    said["file"] = message(attach)
    file.unlink()

    other_bus = hardware.TalonFX(31, "canivore")
    said["two buses"] = message(attach)
    said["one device"] = [other_bus._device_identifier.device_hash == roller._device_identifier.device_hash]
    assert message(require_distinct) == said["two buses"]
    other_bus.close()
    said["versions"] = [message(lambda v=v: require_phoenix6(v)) for v in ("25.4.0", "27.0.0", None, "26.1.0")]

    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen()
        said["taken"] = is_port_taken(listener.getsockname()[1])
        free = listener.getsockname()[1]
    said["free"] = is_port_taken(free)
    assert roller is not None and ports is not None and other_bus is not None
    print(json.dumps(said), flush=True)
    os._exit(0)


if __name__ == "__main__":
    main()
