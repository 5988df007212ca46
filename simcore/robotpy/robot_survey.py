"""The drivetrain and the motors of a robot program, as a line of JSON: for `simcore check`."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import simcore.phoenix6.swerve as swerve
from simcore.errors import ConfigError
from simcore.phoenix6.built_devices import built_devices, group_followers
from simcore.phoenix6.configuration import talon_configuration
from simcore.robot.motor_controllers import BuiltDevice
from simcore.robot_file.reader import read_settings
from simcore.robot_file.template import FILE_NAME
from simcore.robotpy.attached_physics import described_drivetrain
from simcore.robotpy.surveyed_robot import print_survey

__all__ = ["main"]

_MODELS = ("TalonFX", "TalonFXS")


def main() -> None:
    """Print one line of JSON and leave."""
    print_survey(_look)


def _look(robot_file: Path) -> dict[str, Any]:
    answer: dict[str, Any] = {"drivetrain": None, "why_not": ""}
    try:
        answer["drivetrain"] = asdict(described_drivetrain(read_settings(robot_file.parent / FILE_NAME))[1])
    except ConfigError as error:
        answer["why_not"] = str(error)
    drive = swerve.drivetrain_motors()
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
    try:
        config = talon_configuration(device.hardware, device.model)
    except ConfigError:
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
