"""Asks before a team's own simulation writes the simulated state of a CTRE device."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Any

from phoenix6.sim import CANcoderSimState, CANdiSimState, Pigeon2SimState, TalonFXSimState, TalonFXSSimState
from phoenix6.status_code import StatusCode

__all__ = ["own_writer", "watch_simulations"]

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


def own_writer(state: Any, name: str) -> Any:
    """A setter of a simulated state without its wrapper: what physics itself calls."""
    return inspect.unwrap(getattr(type(state), name)).__get__(state)


def watch_simulations(may_write: Callable[[tuple[str, int]], bool]) -> None:
    """Wrap the setters that a team's own simulation calls; see `Maker.watch_simulations`."""
    for model, (cls, names) in _SETTERS.items():
        for name in names:
            setattr(cls, name, _watched(model, inspect.unwrap(getattr(cls, name)), may_write))


def _watched(model: str, write: Any, may_write: Callable[[tuple[str, int]], bool]) -> Any:
    @functools.wraps(write)
    def guarded(state: Any, *args: Any) -> Any:
        return write(state, *args) if may_write((model, state._id)) else StatusCode.OK

    return guarded
