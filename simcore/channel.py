"""Definition of a telemetry channel.

`simcore.match.channels` defines most channels. Games and robot programs define additional channels.
"""

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
"""Name of the field of `simcore.telemetry.snapshot.Snapshot` that holds a channel's values, by type of the values."""


@dataclass(frozen=True, slots=True)
class Channel:
    """Telemetry channel: a key, the type and meaning of the values, and a function that reads the values.

    >>> Channel("Arm/IsHome", "bool", lambda robot: True, "the arm is at its stop")
    Traceback (most recent call last):
    simcore.errors.UnknownNameError: no kind of channel named 'bool'. Did you mean 'boolean'? ...
    """

    key: str
    """Key of the values.

    The publisher adds the prefix of the robot to the key of a robot channel, and replaces `<...>` with the name of each
    value.
    """
    kind: str
    """Type of the values, a key of `FIELD_OF`."""
    of: Callable[[Any], Any]
    """Function that returns the value, or a dict of values by name for a key with `<...>`; None to publish nothing."""
    meaning: str
    unit: str = ""
    decimals: int | None = None
    """Number of decimal places to which values are rounded; None for no rounding."""
    owner: type = object
    """Class of the mechanisms or parts that have this channel; ignored for other channels."""

    def __post_init__(self) -> None:
        if self.kind not in FIELD_OF:
            raise UnknownNameError("kind of channel", self.kind, FIELD_OF)

    @property
    def field(self) -> str:
        """Name of the snapshot field that holds the channel's values."""
        return FIELD_OF[self.kind]
