"""Survey of a robot program's devices and drivetrain, printed as a line of JSON for `simcore init` and `simcore check`.

`python -m simcore.robotcode.sim.robot_survey robot.py` builds the robot without running the robot's loop. Run this
command in a separate process and folder, because programs and vendors' libraries write files to the current folder.
The command has these options after the path:

- `described` uses the description of the drivetrain in simcore.toml.
- `started` also builds the physics with the robot on the field.
- `real` uses CTRE's simulation of Phoenix 6, for programs with unmodelled features. By default, the survey uses
  simcore's emulator, which responds immediately and writes no files.
"""

from __future__ import annotations

import json
import math
import os
import sys
import traceback
from collections.abc import Sequence
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from simcore import season
from simcore.errors import ConfigError, SimcoreError
from simcore.quantities import DeviceKey
from simcore.robot_file.mechanism_names import mechanism_name
from simcore.robot_file.mechanism_tables import usual_motor
from simcore.robot_file.reader import read_settings
from simcore.robot_file.robot_settings import RobotSettings
from simcore.robot_file.template import FILE_NAME
from simcore.robotcode.program.drivetrain_discovery import find_drivetrain
from simcore.robotcode.program.found_drivetrain import drivetrain_lines, drivetrain_rows
from simcore.robotcode.program.makers import Maker, makers
from simcore.robotcode.program.motor_controllers import BuiltDevice, FollowerGroup
from simcore.robotcode.program.object_graph import ObjectGraph
from simcore.robotcode.program.simulation_questions import answering_keys
from simcore.robotcode.sim.attach import watch_program
from simcore.robotcode.sim.attached_physics import AttachedPhysics, physics_or_none
from simcore.robotcode.sim.built_ports import built_ports
from simcore.robotcode.sim.robot_cameras import surveyed_cameras
from simcore.robotcode.sim.robot_program import load_robot_class

__all__ = ["main"]

_SETTLE = 0.1  # time for all devices to send their signals [s]
_kept: list[Any] = []
"""References to robot objects, because Python would delete the devices together with an unreferenced robot object."""


def main() -> None:
    """Survey the robot program, print the result or the error as JSON, and end the process despite running threads."""
    robot_file, options = Path(sys.argv[1]), sys.argv[2:]
    answer: dict[str, Any] = {}
    try:
        _build(robot_file, emulates="real" not in options)
    except NotImplementedError as error:
        answer["not_modelled"] = str(error)
    except BaseException as error:  # any exception or exit of a team's program is the result
        traceback.print_exc()
        answer["error"] = f"{type(error).__name__}: {error}"
    try:
        answer.update(_survey(robot_file.parent, is_described="described" in options))
    except Exception as error:
        traceback.print_exc()
        answer.setdefault("error", f"{type(error).__name__}: {error}")
    if "started" in options and "error" not in answer:
        answer["start_problem"] = _start(robot_file.parent)
    print("\n" + json.dumps(answer), flush=True)  # a library may have printed half a line
    os._exit(0)


def _build(robot_file: Path, *, emulates: bool) -> None:
    watch_program(simulated=emulates)
    clock = None
    if find_spec("phoenix6") is not None:
        from phoenix6 import unmanaged

        from simcore.robotcode.sim.simulated_phoenix import phoenix_time

        clock = phoenix_time()
        if clock is None:
            unmanaged.set_phoenix_diagnostics_start_time(-1)
    season.initialize_hal()
    robot = load_robot_class(robot_file)()
    _kept.append(robot)
    for step in ("robotInit", "_simulationInit", "simulation_init"):  # names of 2026, then 2027
        getattr(robot, step, lambda: None)()
    if clock is not None:
        clock.step(_SETTLE)


def _start(folder: Path) -> str:
    """Build the physics as at program start, and return simcore's error message; empty without an error."""
    AttachedPhysics.folder, AttachedPhysics.ownership = folder, watch_program()
    try:
        physics_or_none(SimpleNamespace(field=season.wpilib.Field2d()), _kept[0])
    except SimcoreError as error:
        return str(error)
    return ""


def _survey(folder: Path, *, is_described: bool) -> dict[str, Any]:
    drivetrain: dict[str, Any] = {}
    taken: set[DeviceKey] = set()
    on_ports: list[Any] = []
    try:
        settings = read_settings(folder / FILE_NAME) if is_described else RobotSettings()
        ready = find_drivetrain(_kept[0] if _kept else None, folder, settings)
        settings.require_effect(ready.config)
        found = ready.found
        taken, on_ports = set(found.keys), found.hardware
        drivetrain = {"lines": drivetrain_lines(found), "has_mass": "mass" in found.measures}
        drivetrain["model"] = {"kind": found.kind, **asdict(ready.config)}
        if not found.drives_itself:
            drivetrain["rows"] = drivetrain_rows(found)
    except ConfigError as error:
        drivetrain["problem"] = str(error)
    return {
        "drivetrain": drivetrain,
        "motors": _motors(taken, ObjectGraph(_kept[0] if _kept else None, folder)),
        "built": [(d.model, d.address.in_file) for maker in makers() for d in maker.built()],
        "ports": _ports(on_ports),
        "cameras": surveyed_cameras(folder),
        "answering_keys": answering_keys(),
    }


def _ports(taken: Sequence[Any]) -> list[dict[str, Any]]:
    """Return the model, channels and class of each port device and of each CANrange and CANdi.

    The result excludes the port devices in `taken`, which the drivetrain uses.
    """
    ports = [
        {"model": p.model, "channels": list(p.channels), "made_by": p.made_by}
        for p in built_ports()
        if not any(p.device is device for device in taken)
    ]
    sensors = [d for maker in makers() for d in maker.built() if d.model in ("CANrange", "CANdi")]
    return ports + [{"model": d.model, "channels": [d.address.in_file], "made_by": ""} for d in sensors]


def _motors(drive: set[DeviceKey], graph: ObjectGraph) -> list[dict[str, Any]]:
    found = []
    for maker in makers():
        free = [d for d in maker.built() if d.model in maker.motors and d.key not in drive]
        found += [] if maker.on_ports else [_describe(maker, group, graph) for group in maker.groups(free)]
    return found


def _describe(maker: Maker, group: FollowerGroup, graph: ObjectGraph) -> dict[str, Any]:
    known: dict[str, Any] = {
        "name": mechanism_name(graph.name_of(group.leader)),
        "controller": group.leader.model,
        "leader": group.leader.address.in_file,
        "followers": [f.address.in_file for f in group.followers],
        "opposed": [group.followers[k].address.in_file for k in group.opposed],
        "code": None,
    }
    try:
        known["code"] = _view(group.leader)
        guess = maker.guess(group)
    except (ConfigError, NotImplementedError) as error:  # continue with the other motors
        return {**known, "remark": str(error), "turns_freely": False}
    m, box = guess.mechanism, guess.mechanism.gearbox
    reads = [f"{model} {address}" for model, address in guess.sensors]
    reads += ["an encoder that is wired to it"] if guess.has_wired_sensor else []
    remarks = ["it holds a weight"] * guess.has_weight + [f"it reads {one}" for one in reads]
    return {
        **known,
        "gearing": m.gearing,
        "inertia": m.inertia,
        "friction_volts": box.friction_torque * box.resistance / box.torque_per_amp,
        "motor": "" if guess.motor == usual_motor(group.leader.model) else guess.motor,
        "turns_freely": not remarks,
        "remark": ", ".join(remarks),
    }


def _view(device: BuiltDevice) -> dict[str, Any] | None:
    """Return the `CodeView` fields of a TalonFX or TalonFXS; None for any other device.

    Raises:
        ConfigError: The device does not respond.
    """
    if device.model not in ("TalonFX", "TalonFXS"):
        return None
    from simcore.robotcode.makers.phoenix6.built_devices import feedback_of, talon_configuration

    config = talon_configuration(device.hardware, device.model)
    feedback, soft, amps = feedback_of(config), config.software_limit_switch, config.current_limits
    reading = device.hardware.get_position()
    reading.wait_for_update(0.1)
    return {
        "clockwise": config.motor_output.inverted.name == "CLOCKWISE_POSITIVE",
        "ratio": feedback.ratio,
        "reading": reading.value if feedback.on_rotor else None,
        "lower_limit": soft.reverse_soft_limit_threshold if soft.reverse_soft_limit_enable else None,
        "upper_limit": soft.forward_soft_limit_threshold if soft.forward_soft_limit_enable else None,
        "stator_limit": amps.stator_current_limit if amps.stator_current_limit_enable else math.inf,
        "supply_limit": amps.supply_current_limit if amps.supply_current_limit_enable else math.inf,
    }


if __name__ == "__main__":
    main()
