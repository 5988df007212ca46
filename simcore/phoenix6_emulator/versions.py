"""What differs between the native libraries of Phoenix 6 for 2026 (26.3) and for 2027 (26.70).

The emulator is written in the names of 26.70; those of 26.3 are found by these tables. All else is the same in both.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

from phoenix6 import phoenix_native

__all__ = ["ADDED", "FIELDS", "GONE", "IS_2027", "PREFIX", "RENAMED", "Fields", "record"]

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
