"""Which CTRE devices the robot program builds, and which it has on several buses.

Classes are watched as this module is imported: before the robot is built, as physics is.
"""

from __future__ import annotations

from typing import Any

from phoenix6 import hardware

from simcore.devices.recorder import BuiltDevices

__all__ = ["DEVICES", "MODELS", "clashes", "key_of"]

MODELS: dict[str, Any] = {
    model: getattr(hardware, model)
    for model in ("TalonFX", "TalonFXS", "CANcoder", "CANdi", "CANdle", "CANrange", "Pigeon2")
}
"""Classes of robot code."""
DEVICES = BuiltDevices()
"""Those that the program has built; `TalonFX.none()`, with an id below zero, is none."""


def _bus(made: Any) -> str:
    """The bus's name; an empty one and `rio` are the same bus."""
    network = getattr(made, "network", "")
    name = str(getattr(network, "name", network))
    return "rio" if name in ("", "rio") else name


for _model, _cls in MODELS.items():
    DEVICES.record(_cls, _model, lambda made, args, settings: made.device_id, _bus)


def clashes() -> list[str]:
    """Devices that are two on the robot, on different buses, but one in the simulation; a sentence each."""
    buses: dict[tuple[str, int], set[str]] = {}
    for device in DEVICES.objects:
        buses.setdefault(device.key, set()).add(device.bus)
    return [
        f"{model} {number} is on the buses {', '.join(sorted(names))}: the device simulation knows ids only and makes "
        "them one"
        for (model, number), names in buses.items()
        if len(names) > 1
    ]


def key_of(made: Any) -> tuple[str, int]:
    """Model and id of a device object, whatever class a program derived."""
    return next(model for model, cls in MODELS.items() if isinstance(made, cls)), int(made.device_id)
