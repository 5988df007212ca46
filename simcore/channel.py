"""Telemetry channel; `simcore.match.channels` defines most channels, games and robot programs add others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from simcore.errors import UnknownNameError

__all__ = ["FIELD_OF", "Channel"]

FIELD_OF = {
    "double": "doubles", "int": "integers", "boolean": "booleans", "string": "strings", "Pose3d": "poses",
    "Pose3d[]": "pose_arrays", "SwerveModuleState[]": "state_arrays", "int[]": "integer_arrays",
}  # fmt: skip
"""Field of `simcore.telemetry.snapshot.Snapshot` that holds a channel's value, by kind of channel."""


@dataclass(frozen=True, slots=True)
class Channel:
    """Telemetry channel: a key and a description of the values.

    >>> Channel("Arm/IsHome", "bool", lambda robot: True, "the arm is at its stop")
    Traceback (most recent call last):
    simcore.errors.UnknownNameError: no kind of channel named 'bool'. Did you mean 'boolean'? ...
    """

    key: str
    """Key, without the robot's prefix for a robot channel; the source replaces `<...>` with a name."""
    kind: str
    """Type of the values, a key of `FIELD_OF`."""
    of: Callable[[Any], Any]
    """Function that returns the value, values by name for a key with `<...>`, or None if not published now."""
    meaning: str
    unit: str = ""
    decimals: int | None = None
    """Number of decimal places to which values are rounded; None for no rounding."""
    owner: type = object
    """Type of the mechanisms with this channel, for mechanism channels."""

    def __post_init__(self) -> None:
        if self.kind not in FIELD_OF:
            raise UnknownNameError("kind of channel", self.kind, FIELD_OF)

    @property
    def field(self) -> str:
        """Name of the snapshot field that holds the channel's values."""
        return FIELD_OF[self.kind]
