"""Telemetry of one tick, the protocol of telemetry sinks, and the encoding for WPILib's readers.

Poses are written directly from arrays, which takes 2 us for 400 poses; a list of Pose3d objects would take about 1 ms.
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


_BULK = 64  # rows; longer arrays are recorded less often
_PARTS = "/ComponentPoses"  # would take a third of a match's log if recorded in every tick
EVENTS = {"Sim/NewestShots": 4, "Sim/NewestHits": 2, "Sim/NewestTakenIn": 3}
"""Row lengths of event arrays, by key.

An event array holds the rows of the newest event and of all events in the second before, one after another. Each
row begins with the number of its event, from 1, so that a `Recording` can collect all events from overlapping arrays.
"""
POSE_TYPE = "struct:Pose3d"
POSE_ARRAY_TYPE = "struct:Pose3d[]"
STATE_ARRAY_TYPE = "struct:SwerveModuleState[]"
SCHEMA_TYPE = "structschema"
# Without the schemas, AdvantageScope still shows the label "Pose3d", but silently draws the robot at the origin.
STRUCT_SCHEMAS: dict[str, str] = {
    "struct:Translation3d": "double x;double y;double z",
    "struct:Quaternion": "double w;double x;double y;double z",
    "struct:Rotation3d": "Quaternion q",
    "struct:Pose3d": "Translation3d translation;Rotation3d rotation",
    "struct:Rotation2d": "double value",
    "struct:SwerveModuleState": "double speed;Rotation2d angle",
}
"""Struct schemas by name, nested types first; a test compares them with wpimath's own schemas."""
_COLUMNS = {POSE_ARRAY_TYPE: ("x", "y", "z", "qw", "qx", "qy", "qz"), STATE_ARRAY_TYPE: ("speed", "angle")}


@dataclass(frozen=True, slots=True, kw_only=True)
class Snapshot:
    """All telemetry of one tick, by key (docs/telemetry.md), with read-only arrays.

    A pose row is `x, y, z, qw, qx, qy, qz`, the byte order of WPILib's Pose3d struct, so that sinks can copy rows.
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
    """int64[] by key, shape (n,), e.g. `Sim/PieceIds/<Type>` with the ids of the pieces in `Sim/GamePieces/<Type>`."""
    strings: Mapping[str, str] = field(default_factory=dict)
    """Text by key, e.g. `Sim/Match/Period`."""

    @property
    def struct_arrays(self) -> list[tuple[str, Mapping[str, FloatArray]]]:
        """Arrays of structs: WPILib's type name, and arrays by key."""
        return [(POSE_ARRAY_TYPE, self.pose_arrays), (STATE_ARRAY_TYPE, self.state_arrays)]


class TelemetrySink(Protocol):
    """Receiver of snapshots; the match calls `due` first, to avoid building unnecessary snapshots."""

    def due(self, time: float) -> bool:
        """Return whether the sink needs a snapshot at this simulated time [s]."""
        ...

    def write(self, snapshot: Snapshot) -> None:
        """Write a snapshot."""
        ...

    def close(self) -> None:
        """Flush all data and free all resources; safe to call twice."""
        ...


def is_bulk(key: str, rows: int) -> bool:
    """Return whether an array is recorded less often than the rest: more than 64 rows, or poses of robot parts.

    Event arrays (`EVENTS`) of any length are recorded in every tick.
    """
    return key.endswith(_PARTS) or (rows > _BULK and key not in EVENTS)


def struct_array_bytes(type_name: str, key: str, rows: FloatArray) -> bytes:
    """Encode an array of WPILib structs as bytes.

    Args:
        type_name: `POSE_ARRAY_TYPE` or `STATE_ARRAY_TYPE`.
        key: Telemetry key, for error messages.
        rows: Rows of `x, y, z, qw, qx, qy, qz` [m, -], shape (n, 7), or of speed and angle [m/s, rad], shape (n, 2).

    Raises:
        ConfigError: If `rows` has the wrong shape for the type.
    """
    array, columns = np.asarray(rows, dtype="<f8"), _COLUMNS[type_name]
    if array.ndim != 2 or array.shape[1] != len(columns):
        names = ", ".join(columns)
        raise ConfigError(f"{key}: {type_name} needs shape (n, {len(columns)}) as {names}, got {array.shape}")
    return array.tobytes()


def checked_integers(key: str, values: IntArray) -> IntArray:
    """Convert integers to little-endian int64 for logs and NetworkTables.

    Args:
        key: Telemetry key, for error messages.
        values: Whole numbers, shape (n,).

    Raises:
        ConfigError: If `values` has the wrong shape or is not of an integer type.
    """
    array = np.asarray(values)
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iu"):
        raise ConfigError(f"{key}: integers need shape (n,) and an integer type, got {array.shape} of {array.dtype}")
    return array.astype("<i8", copy=False)


def key_in_words(name: str) -> str:
    """Convert the last part of a telemetry key to words.

    >>> key_in_words("IntakeZoneActive")
    'intake zone active'
    >>> key_in_words("EndGameTowerRobot1")
    'end game tower robot 1'
    """
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[a-z]{2})(?=[0-9])", " ", name).lower()


def robot_prefix(number: int) -> str:
    """Return the prefix of a robot's telemetry keys: `Sim` for robot 0, `Sim/Robots/<number>` for other robots."""
    return "Sim" if number == 0 else f"Sim/Robots/{number}"
