"""Reads configurations from devices, which on a computer that is busy starting do not answer at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from phoenix6 import configs

from simcore.errors import ConfigError

__all__ = ["PATIENCE", "Feedback", "feedback_of", "read_configuration", "talon_configuration"]

PATIENCE = (0.05, 0.1, 0.25, 0.5, 1.0)
"""Time that a device gets for each try [s]; it answers in 50 ms, but not while it starts or the computer is busy."""


def read_configuration(device: Any, config: Any) -> None:
    """Fill a configuration object, or one group of it, from its device; tried again if there is no answer.

    Args:
        device: The robot code's object.
        config: For example `TalonFXConfiguration()` or `MotorOutputConfigs()`; it is changed.

    Raises:
        ConfigError: The device does not answer.
    """
    for timeout in PATIENCE:
        status = device.configurator.refresh(config, timeout)
        if status.is_ok():
            return
    raise ConfigError(
        f"{type(device).__name__} {device.device_id}: could not read its configuration ({status.name}, asked "
        f"{len(PATIENCE)} times)"
    )


def talon_configuration(device: Any, model: str) -> Any:
    """All of a motor controller's configuration.

    Args:
        device: The robot code's object, of whatever class the program derived.
        model: `TalonFX` or `TalonFXS`.

    Raises:
        ConfigError: The device does not answer.
    """
    make: Any = configs.TalonFXConfiguration if model == "TalonFX" else configs.TalonFXSConfiguration
    config = make()
    read_configuration(device, config)
    return config


@dataclass(frozen=True, slots=True, kw_only=True)
class Feedback:
    """Where a motor controller's position comes from."""

    source: str
    """As CTRE names it: `ROTOR_SENSOR`, `FUSED_CANCODER`."""
    rotor_per_sensor: float
    """Rotor turns per turn of the sensor; 1 of that on the rotor [-]."""
    sensor_per_mechanism: float
    """Turns of the sensor per turn that robot code reads [-]."""
    remote_id: int
    """CAN id of the sensor, where it is a device of its own."""

    @property
    def on_rotor(self) -> bool:
        """Whether the sensor is the rotor's own."""
        return self.source in ("ROTOR_SENSOR", "COMMUTATION")

    @property
    def ratio(self) -> float:
        """Rotor turns per turn that robot code reads [-]."""
        return self.rotor_per_sensor * self.sensor_per_mechanism


def feedback_of(config: Any) -> Feedback:
    """That of a motor controller's configuration, a `TalonFXConfiguration` or `TalonFXSConfiguration`."""
    is_fx = hasattr(config, "feedback")
    group = config.feedback if is_fx else config.external_feedback
    source = str((group.feedback_sensor_source if is_fx else group.external_feedback_sensor_source).name)
    on_rotor = source in ("ROTOR_SENSOR", "COMMUTATION")
    return Feedback(
        source=source,
        rotor_per_sensor=1.0 if on_rotor else abs(float(group.rotor_to_sensor_ratio)) or 1.0,
        sensor_per_mechanism=abs(float(group.sensor_to_mechanism_ratio)) or 1.0,
        remote_id=int(group.feedback_remote_sensor_id),
    )
