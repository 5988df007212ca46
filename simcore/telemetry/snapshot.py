"""Telemetry of one tick, the protocol of sinks that take it, and its encoding for WPILib's readers.

Poses are written straight from arrays: a list of 400 Pose3d objects costs about a millisecond, the same bytes from an
array cost 2 us.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from simcore.errors import ConfigError
from simcore.typing import FloatArray, IntArray

__all__ = [
    "EVENTS", "POSE_ARRAY_TYPE", "POSE_TYPE", "SCHEMA_TYPE", "STATE_ARRAY_TYPE", "STRUCT_SCHEMAS", "Snapshot",
    "TelemetrySink", "checked_integers", "is_bulk", "key_in_words", "robot_prefix", "struct_array_bytes",
]  # fmt: skip


_BULK = 64  # rows of an array
_PARTS = "/ComponentPoses"  # a third of the log of a match, were they in it each tick
EVENTS = {"Sim/NewestShots": 4, "Sim/NewestHits": 2, "Sim/NewestTakenIn": 3}
"""Numbers of a row, by the keys of what happens now and then.

Such an array has the rows of the newest event and of those up to a second before it, one after the other. A row begins
with the number of its event, from 1, so that a log grows by events and a `Recording` puts all of them together again.
"""
POSE_TYPE = "struct:Pose3d"
POSE_ARRAY_TYPE = "struct:Pose3d[]"
STATE_ARRAY_TYPE = "struct:SwerveModuleState[]"
SCHEMA_TYPE = "structschema"
# Without these AdvantageScope still shows the label "Pose3d", but draws the robot silently at the origin.
STRUCT_SCHEMAS: dict[str, str] = {
    "struct:Translation3d": "double x;double y;double z",
    "struct:Quaternion": "double w;double x;double y;double z",
    "struct:Rotation3d": "Quaternion q",
    "struct:Pose3d": "Translation3d translation;Rotation3d rotation",
    "struct:Rotation2d": "double value",
    "struct:SwerveModuleState": "double speed;Rotation2d angle",
}
"""Schema text by name, parts before the whole; a test compares them with wpimath's own."""
_COLUMNS = {POSE_ARRAY_TYPE: ("x", "y", "z", "qw", "qx", "qy", "qz"), STATE_ARRAY_TYPE: ("speed", "angle")}


@dataclass(frozen=True, slots=True, kw_only=True)
class Snapshot:
    """Everything that is published of one tick, by key (see docs/telemetry.md). Arrays are read-only.

    A pose row is `x, y, z, qw, qx, qy, qz`: the byte order of WPILib's Pose3d struct, so sinks send it as it is.
    """

    time: float
    """Simulated time at the end of the tick [s]."""
    tick: int
    """Number of the tick, from 0."""
    poses: Mapping[str, FloatArray] = field(default_factory=dict)
    """Pose3d by key, shape (7,)."""
    pose_arrays: Mapping[str, FloatArray] = field(default_factory=dict)
    """Pose3d[] by key, shape (n, 7)."""
    state_arrays: Mapping[str, FloatArray] = field(default_factory=dict)
    """SwerveModuleState[] by key, rows of speed [m/s] and angle [rad], shape (n, 2)."""
    doubles: Mapping[str, float] = field(default_factory=dict)
    integers: Mapping[str, int] = field(default_factory=dict)
    booleans: Mapping[str, bool] = field(default_factory=dict)
    integer_arrays: Mapping[str, IntArray] = field(default_factory=dict)
    """int64[] by key, shape (n,); `Sim/PieceIds/<Type>` names the piece of each row of `Sim/GamePieces/<Type>`."""
    strings: Mapping[str, str] = field(default_factory=dict)
    """Text by key, e.g. `Sim/Match/Period`."""

    @property
    def struct_arrays(self) -> list[tuple[str, Mapping[str, FloatArray]]]:
        """Arrays of structs, by the name of their type."""
        return [(POSE_ARRAY_TYPE, self.pose_arrays), (STATE_ARRAY_TYPE, self.state_arrays)]


class TelemetrySink(Protocol):
    """Takes snapshots; the runner calls `due` first, so that no snapshot is built without need."""

    def due(self, time: float) -> bool:
        """Return whether this sink wants the snapshot of this simulated time [s]."""
        ...

    def write(self, snapshot: Snapshot) -> None:
        """Take one snapshot."""
        ...

    def close(self) -> None:
        """Flush and free everything; may be called twice."""
        ...


def is_bulk(key: str, rows: int) -> bool:
    """Return whether an array is kept less often than the rest: over 64 rows of what moves, and parts of robots.

    Events (`EVENTS`) are kept in the tick in which they happen.
    """
    return key.endswith(_PARTS) or (rows > _BULK and key not in EVENTS)


def struct_array_bytes(type_name: str, key: str, rows: FloatArray) -> bytes:
    """Return the bytes of an array of structs, empty for no rows.

    Args:
        type_name: `POSE_ARRAY_TYPE` or `STATE_ARRAY_TYPE`.
        key: Key that the error names.
        rows: Rows of `x, y, z, qw, qx, qy, qz` [m, -], shape (n, 7), or of speed and angle [m/s, rad], shape (n, 2).

    Raises:
        ConfigError: Another shape.
    """
    array, columns = np.asarray(rows, dtype="<f8"), _COLUMNS[type_name]
    if array.ndim != 2 or array.shape[1] != len(columns):
        names = ", ".join(columns)
        raise ConfigError(f"{key}: {type_name} needs shape (n, {len(columns)}) as {names}, got {array.shape}")
    return array.tobytes()


def checked_integers(key: str, values: IntArray) -> IntArray:
    """Return the values of an int64[] as they are sent and logged.

    Args:
        key: Key that the error names.
        values: Whole numbers, shape (n,).

    Raises:
        ConfigError: Another shape, or numbers that are not integers.
    """
    array = np.asarray(values)
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iu"):
        raise ConfigError(f"{key}: integers need shape (n,) and an integer type, got {array.shape} of {array.dtype}")
    return array.astype("<i8", copy=False)


def key_in_words(name: str) -> str:
    """Turn the last part of a key into words.

    >>> key_in_words("IntakeZoneActive")
    'intake zone active'
    >>> key_in_words("EndGameTowerRobot1")
    'end game tower robot 1'
    """
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[a-z]{2})(?=[0-9])", " ", name).lower()


def robot_prefix(number: int) -> str:
    """Return the prefix of a robot's keys; the first robot has no number."""
    return "Sim" if number == 0 else f"Sim/Robots/{number}"
