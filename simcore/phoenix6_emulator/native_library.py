"""What emulated native libraries share: the names of functions, ctypes arguments, and callbacks.

The emulator is written in the names of 26.70 (2027); those of 26.3 (2026) are found by tables here.

A ctypes callback prints an exception and goes on. In a test the exception of a request or of a telemetry function shall
reach whoever runs the test, so the function itself is called, not the C function that ctypes made of it.
"""

from __future__ import annotations

import ctypes
import gc
from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

from phoenix6 import phoenix_native

__all__ = [
    "ADDED",
    "FIELDS",
    "GONE",
    "IS_2027",
    "PREFIX",
    "RENAMED",
    "Fields",
    "Held",
    "NativeLibrary",
    "always",
    "python_function",
    "record",
    "target_of",
]

IS_2027 = hasattr(phoenix_native, "CANBusStatus_t")
"""Whether the installed phoenix6 is of 2027."""

PREFIX = "c_ctre_phoenix6_"
"""First part of the names of nearly all native functions."""

_SWERVE = PREFIX + "swerve_"
RENAMED = {
    # 26.3: 26.70
    PREFIX + "get_system_time_seconds": PREFIX + "get_monotonic_time_seconds",
    _SWERVE + "drivetrain_set_operator_perspective_forward": _SWERVE + "drivetrain_set_operator_forward_direction",
    _SWERVE + "module_get_current_state": _SWERVE + "module_get_current_velocity",
    _SWERVE + "module_get_target_state": _SWERVE + "module_get_target_velocity",
    **{
        f"{_SWERVE}{what}_apply_{frame}_speeds": f"{_SWERVE}{what}_apply_{frame}_velocity"
        for what in ("drivetrain_set_control", "request_apply")
        for frame in ("robot", "field")
    },
}
"""Functions with another name and the same arguments."""
GONE = frozenset({"c_ctre_phoenix_report_error"})
"""Functions of 26.3 alone."""
ADDED = frozenset(
    PREFIX + name
    for name in (
        "report_error",
        "report_status_code",
        "unmanaged_set_transmit_enable",
        "unmanaged_get_transmit_enable",
        *(f"{kind}_{what}" for kind in ("alert", "multi_alert") for what in ("create", "set_debounce")),
        *(f"{kind}_{what}" for kind in ("alert", "multi_alert") for what in ("set_active", "set_inactive")),
        "swerve_module_reset_target_velocity",
    )
)
"""Functions of 26.70 alone."""


@dataclass(frozen=True, slots=True)
class Fields:
    """Names of the fields of swerve's structures."""

    chassis: str
    """Of a drivetrain's state: velocity of the robot."""
    modules: str
    """Of a drivetrain's state: velocities of the modules."""
    module: str
    """Of a module's velocity: meters per second along its wheel."""
    wanted: str
    """Of a module's request: its velocity."""
    current: str
    """Of a request's parameters: velocity of the robot."""


FIELDS = (
    Fields("velocity", "moduleVelocities", "velocity", "velocity", "currentChassisVelocity")
    if IS_2027
    else Fields("speeds", "moduleStates", "speed", "state", "currentChassisSpeed")
)
"""Of the installed phoenix6."""


def record(named: dict[str, Any], **same: Any) -> SimpleNamespace:
    """A structure for callbacks of the Python library: fields by the names of `FIELDS`, and others."""
    return SimpleNamespace(**named, **same)


_C_FUNCTION = type(ctypes.CFUNCTYPE(None))


class NativeLibrary:
    """An object with functions, as phoenix6 expects a native library; functions that are not modelled raise."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        if name in RENAMED:
            return getattr(self, RENAMED[name])
        plain = name.removeprefix(PREFIX).removeprefix("RequestControl")
        raise NotImplementedError(
            f"Phoenix 6 function {plain} is not modelled in simulated time; --phoenix=real runs the test on CTRE's own "
            "simulation, on the wall clock"
        )


def always(answer: Any) -> Callable[..., Any]:
    """A function of such an object whose answer is the same for whatever arguments."""

    def function(self: NativeLibrary, *values: Any) -> Any:
        return answer

    return function


class Held:
    """A pointer argument of a callback, with its `contents`."""

    __slots__ = ("contents",)

    def __init__(self, contents: Any) -> None:
        self.contents = contents


def target_of(reference: Any) -> Any:
    """The target of a ctypes argument: of `byref(x)` x, and an array itself."""
    return getattr(reference, "_obj", reference)


def python_function(callback: Any) -> Callable[..., Any]:
    """The function that a ctypes callback was made of.

    Args:
        callback: Made by `ctypes.CFUNCTYPE(...)(function)`; anything else is returned as it is.

    Raises:
        TypeError: A C function that no Python function stands behind.
    """
    if not isinstance(type(callback), _C_FUNCTION):
        return callback  # type: ignore[no-any-return]
    # callback -> its keep-alive table -> ctypes' thunk -> the function
    for thunk in (callback._objects or {}).values():
        for found in gc.get_referents(thunk):
            if callable(found) and not isinstance(found, type):
                return found  # type: ignore[no-any-return]
    raise TypeError(f"{callback!r} is not made of a Python function; the simulated drivetrain cannot call it")
