"""Which model writes a device's simulated state: simcore's physics, or a team's own.

If two models write one rotor, robot code reads both in turn. So the setters of the simulated states are wrapped: a
write from outside to a device that physics has claimed is dropped, with one warning; a write to any other device is
recorded, and physics does not write that device.
"""

from __future__ import annotations

import functools
import inspect
import logging
from typing import Any

from phoenix6.sim import CANcoderSimState, CANdiSimState, Pigeon2SimState, TalonFXSimState, TalonFXSSimState
from phoenix6.status_code import StatusCode

from simcore.errors import ConfigError

__all__ = ["DRIVETRAIN", "Ownership", "own_writer"]

_log = logging.getLogger(__name__)

Key = tuple[str, int]

_MANY = 100  # dropped writes; fewer may come from a model that was at work in another thread when it was switched off

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


DRIVETRAIN = "drivetrain"
"""Who owns the devices of the drivetrain."""


class Ownership:
    """Wraps the setters when it is created; create one per program, before the robot is built."""

    def __init__(self) -> None:
        self._claimed: dict[Key, str] = {}
        self._dropped: dict[str, int] = {}
        self.foreign: set[Key] = set()
        """Devices that another model has written, as (model, id)."""
        for model, (cls, names) in _SETTERS.items():
            for name in names:
                setattr(cls, name, self._watched(model, inspect.unwrap(getattr(cls, name))))

    def claim(self, key: Key, owner: str) -> None:
        """Let only physics write this device from now on; `owner` is its name in messages.

        Raises:
            ConfigError: It is a mechanism's and the drivetrain's.
        """
        before = self._claimed.get(key, owner)
        if before != owner and DRIVETRAIN in (before, owner):
            mechanism = before if owner == DRIVETRAIN else owner
            raise ConfigError(
                f"mechanism {mechanism!r}: {key[0]} {key[1]} is the drivetrain's; "
                "give the device that moves the mechanism"
            )
        self._claimed[key] = owner

    def may_write(self, key: Key) -> bool:
        """Note a write from outside to a device; False if it is to be dropped, as physics has claimed the device."""
        if key in self._claimed:
            self._drop(key)
            return False
        self.foreign.add(key)
        return True

    def _watched(self, model: str, write: Any) -> Any:
        may_write = self.may_write

        @functools.wraps(write)
        def guarded(state: Any, *args: Any) -> Any:
            return write(state, *args) if may_write((model, state._id)) else StatusCode.OK

        return guarded

    def _drop(self, key: Key) -> None:
        owner = self._claimed[key]
        self._dropped[owner] = count = self._dropped.get(owner, 0) + 1
        if count == _MANY:
            _log.warning(
                "%s %d belongs to simcore's %s: what the project's own simulation writes into it is dropped",
                *key,
                owner,
            )
