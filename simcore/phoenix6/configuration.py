"""Reads configurations from devices, which on a computer that is busy starting do not answer at once."""

from __future__ import annotations

from typing import Any

from phoenix6 import configs

from simcore.errors import ConfigError

__all__ = ["PATIENCE", "read_configuration", "talon_configuration"]

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
