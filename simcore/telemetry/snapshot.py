"""One immutable picture of a tick, and the sinks that take it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

from simcore.typing import FloatArray, IntArray

__all__ = ["Snapshot", "TelemetrySink"]


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
    doubles: Mapping[str, float] = field(default_factory=dict)
    integers: Mapping[str, int] = field(default_factory=dict)
    booleans: Mapping[str, bool] = field(default_factory=dict)
    integer_arrays: Mapping[str, IntArray] = field(default_factory=dict)
    """int64[] by key, shape (n,); `Sim/PieceIds/<Type>` names the piece of each row of `Sim/GamePieces/<Type>`."""
    strings: Mapping[str, str] = field(default_factory=dict)
    """Text by key, e.g. `Sim/Match/Period`."""


class TelemetrySink(Protocol):
    """Takes snapshots; the runner asks `due` first, so that nothing is built for nobody."""

    def due(self, time: float) -> bool:
        """Whether this sink wants the snapshot of this simulated time [s]."""
        ...

    def write(self, snapshot: Snapshot) -> None:
        """Take one snapshot."""
        ...

    def close(self) -> None:
        """Flush and free everything; may be called twice."""
        ...
