"""Builds a robot program, without running it, and prints its drivetrain and its motors: for `simcore check`.

Run it in a process and a folder of its own: devices write their configurations into `./ctre_sim`.
"""

from __future__ import annotations

import json
import logging
import math
import os
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

import hal
from phoenix6 import configs, unmanaged

import simcore.phoenix6.swerve as swerve
from simcore.errors import ConfigError
from simcore.phoenix6.built_devices import BuiltDevice, built_devices, group_followers, key_of
from simcore.phoenix6_emulator import SeamError
from simcore.robot_file.reader import read_settings
from simcore.robot_file.robot_settings import FILE_NAME
from simcore.robotpy.attached_physics import described_drivetrain
from simcore.robotpy.robot_program import load_robot_class
from simcore.robotpy.simulated_phoenix import PhoenixTime, install_simulated_phoenix

__all__ = ["main"]

_MODELS: dict[str, Any] = {
    "TalonFX": configs.TalonFXConfiguration,
    "TalonFXS": configs.TalonFXSConfiguration,
}
_log = logging.getLogger(__name__)

_SETTLE = 0.1  # [s]; until all devices have sent their signals
_PATIENCE, _TRIES = 0.5, 3  # [s], [-]; a device answers within 50 ms, on a busy computer later


def main() -> None:
    """Print one line of JSON and leave, whatever threads the program has started."""
    try:
        answer = _look(Path(sys.argv[1]))
    except Exception as error:  # whatever a team's program raises is the answer
        answer = {"error": f"{type(error).__name__}: {error}"}
    print(json.dumps(answer), flush=True)
    os._exit(0)


def _look(robot_file: Path) -> dict[str, Any]:
    unmanaged.set_phoenix_diagnostics_start_time(-1)
    hal.initialize(500, 0)
    clock: PhoenixTime | None = None
    try:
        clock = install_simulated_phoenix()  # whose devices answer at once, however busy the computer is
    except SeamError:
        _log.warning("the devices are CTRE's own: on a busy computer some do not answer")
    robot = load_robot_class(robot_file)()
    for step in ("robotInit", "_simulationInit"):
        getattr(robot, step, lambda: None)()
    if clock is not None:
        clock.step(_SETTLE)
    answer: dict[str, Any] = {"drivetrain": None, "why_not": ""}
    try:
        answer["drivetrain"] = asdict(described_drivetrain(read_settings(robot_file.parent / FILE_NAME))[1])
    except ConfigError as error:
        answer["why_not"] = str(error)
    drive = {
        key_of(motor) for d in swerve.known_drivetrains() for m in d.modules for motor in (m.drive_motor, m.steer_motor)
    }
    motors = [d for d in built_devices() if d.model in _MODELS and d.key not in drive]
    answer["motors"] = [
        {
            "model": group.leader.model,
            "leader": group.leader.device_id,
            "followers": [f.device_id for f in group.followers],
            "opposed": [group.followers[k].device_id for k in group.opposed],
            "code": _view(group.leader),
        }
        for group in group_followers(motors)
    ]
    return answer


def _view(device: BuiltDevice) -> dict[str, Any] | None:
    """The fields of a `CodeView`; None if the device does not answer."""
    config = _MODELS[device.model]()
    if not any(device.hardware.configurator.refresh(config, _PATIENCE).is_ok() for _ in range(_TRIES)):
        return None
    feedback = config.feedback if device.model == "TalonFX" else config.external_feedback
    source = feedback.feedback_sensor_source if device.model == "TalonFX" else feedback.external_feedback_sensor_source
    on_rotor = source.name in ("ROTOR_SENSOR", "COMMUTATION")
    ratio = feedback.sensor_to_mechanism_ratio * (1.0 if on_rotor else feedback.rotor_to_sensor_ratio)
    soft, amps = config.software_limit_switch, config.current_limits
    reading = device.hardware.get_position()
    reading.wait_for_update(0.1)
    return {
        "clockwise": config.motor_output.inverted.name == "CLOCKWISE_POSITIVE",
        "ratio": abs(ratio) or 1.0,
        "reading": reading.value if on_rotor else None,
        "lower_limit": soft.reverse_soft_limit_threshold if soft.reverse_soft_limit_enable else None,
        "upper_limit": soft.forward_soft_limit_threshold if soft.forward_soft_limit_enable else None,
        "stator_limit": amps.stator_current_limit if amps.stator_current_limit_enable else math.inf,
        "supply_limit": amps.supply_current_limit if amps.supply_current_limit_enable else math.inf,
    }


if __name__ == "__main__":
    main()
