"""Where everything was at any time of a recording: robots, what they believed, and each piece by its id."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from simcore.show.scene import PieceLook, Scene
from simcore.telemetry.recording import Recording
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["AWAY", "IN_AIR", "Placed", "RunTrack", "Table"]

IN_AIR = 0.35  # [m]; a flying piece whose center is higher is drawn darker; where a log tells not which fly, any piece
AWAY = -1
"""The holder of a piece that is nowhere: scored, or with a human player."""
_FIELD, _PIECES, _HELD = 0, "Sim/GamePieces/", "Sim/Held/"
_DRIVES = 0.01  # [m]; a robot that has come so far has driven
_TALLEST = 1.6  # times its size: a piece high in the air

Table = npt.NDArray[np.int32]


@dataclass(frozen=True, slots=True)
class Placed:
    """One piece of a table, as a drawing places it."""

    row: int
    holder: int
    """0: on the field or in the air; k + 1: in robot k; `AWAY`."""
    x: int
    """To the right [cm]: along the field, or ahead of the robot's center."""
    y: int
    """Down [cm]: from the field's upper edge in the drawing, or to the right of the robot's center."""
    scale_x: int
    """Times its symbol [%]. That of a ball is its disk, that of a box a square of 1 m."""
    scale_y: int
    angle: int
    """Clockwise in the drawing [deg]."""
    in_air: int


class RunTrack:
    """Reads places from a recording; a drawing's lengths are whole centimeters, y down.

    Args:
        recording: The run.
        scene: What it took place on.
    """

    def __init__(self, recording: Recording, scene: Scene) -> None:
        self.recording, self.scene = recording, scene
        self.robots = [self._path(robot.pose_key) for robot in scene.robots]
        """Times [s] and `x, y, yaw` [m, m, rad] of each robot, shapes (n,) and (n, 3)."""
        self.estimates = [self._path(f"{robot.prefix}/Robot/EstimatedPose") for robot in scene.robots]
        """The same of where each robot believed to be."""
        self._intakes = [self._numbers(f"{robot.prefix}/Debug/IntakeZoneActive") for robot in scene.robots]
        self.types = [key.removeprefix(_PIECES) for key in recording.keys if key.startswith(_PIECES)]
        """Of pieces."""
        self._tells_flights = any(key.startswith("Sim/InFlightIds/") for key in recording.keys)
        self._ids = [self._all_ids(name) for name in self.types]
        self._first = np.cumsum([0, *(len(ids) for ids in self._ids)])
        self.kinds: list[int] = [kind for kind, ids in enumerate(self._ids) for _ in range(len(ids))]
        """Number of the type of the piece of each row of a table."""

    @property
    def span(self) -> tuple[float, float]:
        """First and last time [s]."""
        times = self.recording.times
        return (float(times[0]), float(times[-1])) if len(times) else (0.0, 0.0)

    def frame_times(self, most: int) -> list[float]:
        """When pieces were recorded [s], thinned to at most so many, with the last time of all."""
        recording, times = self.recording, self.recording.times
        if not len(times):
            return []
        marks = recording.array_times(_PIECES + self.types[0]) if self.types else times[:: max(1, len(times) // 300)]
        frames: list[float] = np.unique(np.append(marks[:: -(-len(marks) // most)], times[-1])).tolist()
        return frames

    def placed_times(self, number: int) -> FloatArray:
        """When a robot was put somewhere since the first row [s], shape (n,)."""
        times, counts = self._numbers(f"{self.scene.robots[number].prefix}/Robot/Placements")
        jumps: FloatArray = times[1:][np.diff(counts) > 0.0]
        return jumps

    def began(self, number: int) -> float:
        """When a robot was last put somewhere before it drove [s]; -inf: it began where it stood."""
        times, driven = self._numbers(f"{self.scene.robots[number].prefix}/Robot/DistanceDriven")
        drives = times[driven - driven[:1] > _DRIVES]
        placed = self.placed_times(number)
        return float(max(placed[placed <= drives.min(initial=math.inf)], default=-math.inf))

    def robot_at(self, number: int, time: float, *, estimate: bool = False) -> tuple[float, float, float] | None:
        """The newest pose of a robot [m, m, rad], or where it believed to be; None before the first."""
        times, rows = (self.estimates if estimate else self.robots)[number]
        row = int(np.searchsorted(times, time + 1e-9)) - 1
        if row < 0:
            return None
        x, y, yaw = rows[row].tolist()
        return x, y, yaw

    def intake_is_active(self, number: int, time: float) -> bool:
        """Whether the intake of a robot is out and takes pieces."""
        times, values = self._intakes[number]
        row = int(np.searchsorted(times, time + 1e-9)) - 1
        return row >= 0 and bool(values[row])

    def table(self, time: float) -> Table:
        """Where all pieces are, one row each: the fields of `Placed` from `holder` on, shape (n, 7)."""
        table: Table = np.zeros((self._first[-1], 7), dtype=np.int32)
        table[:, 0] = AWAY
        poses = [self.robot_at(number, time) for number in range(len(self.robots))]
        width = self.scene.field_size[1]
        for kind, name in enumerate(self.types):
            look = self.scene.look(name)
            rows, ids = self._rows(_PIECES + name, f"Sim/PieceIds/{name}", time)
            there = np.column_stack((rows[:, 0], width - rows[:, 1]))
            _, flying = self._rows(f"Sim/InFlight/{name}", f"Sim/InFlightIds/{name}", time)
            can_fly = np.isin(ids, flying) if self._tells_flights else np.ones(len(ids), dtype=bool)
            self._put(table, kind, ids, _drawn(look, rows, there, 0.0, _FIELD, can_fly))
            rows, ids = self._rows(_HELD + name, f"Sim/HeldIds/{name}", time)
            for row, piece in zip(rows, ids, strict=True):
                near = _nearest(poses, row)
                if near is not None:
                    x, y, yaw = poses[near] or (0.0, 0.0, 0.0)
                    dx, dy, cos, sin = row[0] - x, row[1] - y, math.cos(yaw), math.sin(yaw)
                    inside = np.array([[cos * dx + sin * dy, sin * dx - cos * dy]])
                    drawn = _drawn(look, row[None], inside, yaw, near + 1, np.zeros(1, dtype=bool))
                    self._put(table, kind, np.array([piece]), drawn)
        return table

    def placed(self, table: Table) -> list[Placed]:
        """Those pieces of a table that are somewhere."""
        rows = np.nonzero(table[:, 0] != AWAY)[0]
        return [Placed(row, *values) for row, values in zip(rows.tolist(), table[rows].tolist(), strict=True)]

    # --- inside ---------------------------------------------------------------------------------------------------

    def _path(self, key: str) -> tuple[FloatArray, FloatArray]:
        if not self.recording.has(key):
            return np.empty(0), np.empty((0, 3))
        return self.recording.poses(key)[0], self.recording.path(key)

    def _numbers(self, key: str) -> tuple[FloatArray, FloatArray]:
        return self.recording.series(key) if self.recording.has(key) else (np.empty(0), np.empty(0))

    def _all_ids(self, name: str) -> IntArray:
        kept = [
            ids for key in (f"Sim/PieceIds/{name}", f"Sim/HeldIds/{name}") for _, ids in self.recording.integers(key)
        ]
        if kept:
            return np.unique(np.concatenate(kept))
        return np.arange(self.recording.most_poses(_PIECES + name))  # an old log says how many there are, not which

    def _rows(self, key: str, id_key: str, time: float) -> tuple[FloatArray, IntArray]:
        """Poses and ids of the same length; without ids the rows' own numbers."""
        if not self.recording.has(key):
            return np.empty((0, 7)), np.empty(0, dtype=np.int64)
        rows = self.recording.array_at(key, time)
        ids: IntArray = np.arange(len(rows))
        if self.recording.has(id_key):
            ids = self.recording.integers_at(id_key, time)[: len(rows)]
        elif key.startswith(_HELD):
            ids = ids[:0]
        rows = rows[: len(ids)]
        is_there = np.isfinite(rows).all(axis=1)
        return rows[is_there], ids[is_there]

    def _put(self, table: Table, kind: int, ids: IntArray, drawn: Table) -> None:
        rows = np.searchsorted(self._ids[kind], ids)
        table[self._first[kind] + rows] = drawn


def _drawn(look: PieceLook, rows: FloatArray, places: FloatArray, yaw: float, holder: int, can_fly: BoolArray) -> Table:
    """Pieces as a table has them; what flies is larger with its height."""
    height = np.where(can_fly, rows[:, 2], 0.0)
    larger = np.clip(1.0 + 0.25 * np.maximum(0.0, height - IN_AIR), 1.0, _TALLEST) + 0.15 * (height > IN_AIR)
    larger = np.rint(20.0 * larger) / 20.0  # few looks: an animation renders each of them once
    table: Table = np.zeros((len(rows), 7), dtype=np.int32)
    table[:, 0] = holder
    table[:, 1:3] = np.rint(100.0 * np.clip(places, -100.0, 100.0))
    table[:, 3] = table[:, 4] = np.rint(100.0 * larger)
    if look.size is not None:
        length, width, heading = look.rectangles(rows).T
        table[:, 3], table[:, 4] = np.rint(100.0 * larger * length), np.rint(100.0 * larger * width)
        table[:, 5] = np.rint(np.degrees(yaw - heading)) % 360
    table[:, 6] = height > IN_AIR
    return table


def _nearest(poses: Sequence[tuple[float, float, float] | None], row: FloatArray) -> int | None:
    """The robot whose center is nearest to a held piece: two of them cannot be at one place."""
    away = {
        number: math.hypot(row[0] - pose[0], row[1] - pose[1]) for number, pose in enumerate(poses) if pose is not None
    }
    return min(away, key=away.__getitem__, default=None)
