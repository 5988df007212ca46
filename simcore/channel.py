"""Row of the telemetry schema; most are in `simcore.match.channels`, games and robot programs add theirs."""

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
"""Field of a `simcore.telemetry.snapshot.Snapshot` by the kind of a channel."""


@dataclass(frozen=True, slots=True)
class Channel:
    """Channel of telemetry: a key with the description of its values.

    >>> Channel("Arm/IsHome", "bool", lambda robot: True, "the arm is at its stop")
    Traceback (most recent call last):
    simcore.errors.UnknownNameError: no kind of channel named 'bool'. Did you mean 'boolean'? ...
    """

    key: str
    """Key, without the prefix of the robot for a robot's channel; the source gives a name for `<...>`."""
    kind: str
    """Type of the values, one of `FIELD_OF`."""
    of: Callable[[Any], Any]
    """Function that gives the value, or values by name for a key with `<...>`; None: not published now."""
    meaning: str
    unit: str = ""
    decimals: int | None = None
    """Decimal places to which values are rounded; None: not rounded."""
    owner: type = object
    """Type of the mechanisms that have it, for a channel of mechanisms."""

    def __post_init__(self) -> None:
        if self.kind not in FIELD_OF:
            raise UnknownNameError("kind of channel", self.kind, FIELD_OF)

    @property
    def field(self) -> str:
        """Snapshot field that has its values."""
        return FIELD_OF[self.kind]
