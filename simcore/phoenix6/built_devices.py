"""Which CTRE devices the robot program builds, which it has on several buses, and which its own simulation writes.

Classes are watched as this module is imported: before the robot is built, as physics is.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from phoenix6 import hardware
from phoenix6.sim import CANcoderSimState, CANdiSimState, Pigeon2SimState, TalonFXSimState, TalonFXSSimState
from phoenix6.status_code import StatusCode

from simcore.devices.recorder import BuiltDevices, guard

__all__ = ["DEVICES", "MODELS", "clashes", "key_of", "watch_simulations"]

MODELS: dict[str, Any] = {
    model: getattr(hardware, model)
    for model in ("TalonFX", "TalonFXS", "CANcoder", "CANdi", "CANdle", "CANrange", "Pigeon2")
}
"""Classes of robot code."""
DEVICES = BuiltDevices()
"""Those that the program has built; `TalonFX.none()`, with an id below zero, is none."""


_ROTOR = ("set_raw_rotor_position", "add_rotor_position", "set_rotor_velocity")
_SETTERS: dict[str, tuple[Any, tuple[str, ...]]] = {
    "TalonFX": (TalonFXSimState, _ROTOR),
    "TalonFXS": (
        TalonFXSSimState,
        (
            *_ROTOR,
            *("set_raw_quadrature_position", "set_quadrature_velocity"),
            *("set_pulse_width_position", "set_pulse_width_velocity"),
        ),
    ),
    "CANcoder": (CANcoderSimState, ("set_raw_position", "add_position", "set_velocity")),
    "CANdi": (
        CANdiSimState,
        ("set_pwm1_position", "set_pwm1_velocity", "set_pwm2_position", "set_pwm2_velocity"),
    ),
    "Pigeon2": (
        Pigeon2SimState,
        (
            *("set_raw_yaw", "add_yaw", "set_pitch", "set_roll"),
            *("set_angular_velocity_x", "set_angular_velocity_y", "set_angular_velocity_z"),
        ),
    ),
}
"""What a team's own simulation calls to write the simulated state of a device."""


def watch_simulations(may_write: Callable[[tuple[str, int]], bool]) -> None:
    """Ask before a team's own simulation writes; see `Maker.watch_simulations`."""
    for model, (cls, names) in _SETTERS.items():
        for name in names:
            guard(cls, name, _key_by_state(model), may_write, dropped=StatusCode.OK)


def _key_by_state(model: str) -> Callable[[Any], tuple[str, int]]:
    return lambda state: (model, state._id)


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
