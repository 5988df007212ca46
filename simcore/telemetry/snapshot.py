"""Telemetry of one tick, protocol of telemetry sinks, and encoding of values as WPILib structs.

Sinks encode poses directly from arrays, which takes 2 us for 400 poses. A list of Pose3d objects would take about 1 ms.
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
"""Number of values per row in event arrays, by key.

An event array contains a row for the newest event and a row for each event in the second before, in one flat array.
Each row begins with the number of the event, from 1, so that a `Recording` can collect all events from overlapping
arrays.
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
"""Schemas of WPILib structs by type name, nested types first. A test compares the schemas with wpimath's schemas."""
_COLUMNS = {POSE_ARRAY_TYPE: ("x", "y", "z", "qw", "qx", "qy", "qz"), STATE_ARRAY_TYPE: ("speed", "angle")}


@dataclass(frozen=True, slots=True, kw_only=True)
class Snapshot:
    """All telemetry of one tick, by type and key (docs/telemetry.md), in read-only arrays.

    A pose is a row `x, y, z, qw, qx, qy, qz`. WPILib's Pose3d struct has the same order, so that sinks can copy rows.
    """

    time: float
    """Simulated time at the end of the tick [s]."""
    tick: int
    """Number of the tick, from 0."""
    poses: Mapping[str, FloatArray] = field(default_factory=dict)
    """Single poses by key, shape (7,), published as `Pose3d`."""
    pose_arrays: Mapping[str, FloatArray] = field(default_factory=dict)
    """Arrays of poses by key, shape (n, 7), published as `Pose3d[]`."""
    state_arrays: Mapping[str, FloatArray] = field(default_factory=dict)
    """Arrays of swerve module states by key: speed [m/s] and angle [rad], shape (n, 2)."""
    doubles: Mapping[str, float] = field(default_factory=dict)
    integers: Mapping[str, int] = field(default_factory=dict)
    booleans: Mapping[str, bool] = field(default_factory=dict)
    integer_arrays: Mapping[str, IntArray] = field(default_factory=dict)
    """Arrays of integers by key, shape (n,), e.g. the ids of pieces in `Sim/PieceIds/<Type>`."""
    strings: Mapping[str, str] = field(default_factory=dict)
    """Text by key, e.g. `Sim/Match/Period`."""

    @property
    def struct_arrays(self) -> list[tuple[str, Mapping[str, FloatArray]]]:
        """All struct arrays: pairs of a type name in WPILib and the arrays of this type by key."""
        return [(POSE_ARRAY_TYPE, self.pose_arrays), (STATE_ARRAY_TYPE, self.state_arrays)]


class TelemetrySink(Protocol):
    """Receiver of snapshots.

    A match calls `due` in each tick, and builds and writes a snapshot only if a sink is due.
    """

    def due(self, time: float) -> bool:
        """Return whether the sink needs a snapshot at a simulated time [s]."""
        ...

    def write(self, snapshot: Snapshot) -> None:
        """Write a snapshot."""
        ...

    def close(self) -> None:
        """Write all remaining data and free all resources; a second call has no effect."""
        ...


def is_bulk(key: str, rows: int) -> bool:
    """Return whether sinks record an array less often than other values.

    This applies to arrays with more than 64 rows and to poses of robot parts, but not to event arrays (`EVENTS`).
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
    """Check an array of integers, and convert the array to little-endian int64 for logs and NetworkTables.

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
    """Convert a name in PascalCase, such as the last part of a telemetry key, to lower-case words.

    >>> key_in_words("IntakeZoneActive")
    'intake zone active'
    >>> key_in_words("EndGameTowerRobot1")
    'end game tower robot 1'
    """
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[a-z]{2})(?=[0-9])", " ", name).lower()


def robot_prefix(number: int) -> str:
    """Return the prefix of a robot's telemetry keys: `Sim` for robot 0, `Sim/Robots/<number>` for other robots."""
    return "Sim" if number == 0 else f"Sim/Robots/{number}"
