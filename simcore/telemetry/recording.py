"""A run kept in memory as columns: small enough to keep of every run, enough for its log and page."""

from __future__ import annotations

from array import array
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from typing import Any, Generic, Literal, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from simcore.errors import UnknownNameError
from simcore.quantities import DURATION, require
from simcore.telemetry.sinks import Cadence
from simcore.telemetry.snapshot import Snapshot, is_bulk
from simcore.typing import FloatArray, IntArray

__all__ = ["Recording", "newest_rows"]

_NAN = float("nan")
_PIECES = "Sim/GamePieces/"
_STATE = 2  # columns of a state of a swerve module
_Rows: TypeAlias = "FloatArray | npt.NDArray[np.float32]"
_Kind = Literal["double", "integer", "boolean"]
_Array = TypeVar("_Array")


class Recording:
    """Takes every snapshot and keeps numbers as columns; still readable after `close`.

    504 pieces take 21 MB in a match of 160 s, a tenth of the snapshots themselves. Arrays of more than 64 rows and
    states of swerve modules are kept less often than the rest, and of pieces that show no rotation only the places.
    When time jumps back, a new run has begun, and the old one is forgotten.

    >>> recording = Recording()
    >>> for tick in range(3):
    ...     recording.write(Snapshot(time=0.02 * (tick + 1), tick=tick, doubles={"height": float(tick)}))
    >>> times, values = recording.series("height")
    >>> values.tolist()
    [0.0, 1.0, 2.0]
    """

    def __init__(self, *, period: float = 0.02, bulk_period: float = 0.04, seconds: float = 180.0) -> None:
        """Choose how much is kept.

        Args:
            period: Simulated time between two snapshots [s].
            bulk_period: The same for arrays of more than 64 rows [s].
            seconds: At least so much of the newest is kept, and at most a quarter more [s].

        Raises:
            ConfigError: One of them is not finite and > 0.
        """
        require("Recording", "seconds", seconds, DURATION)
        self.closed = False
        self.bulk_period = bulk_period
        """Simulated time between two of the long arrays that are kept [s]."""
        self._seconds = seconds
        self._cadence = Cadence(period)
        self._bulk_cadence = Cadence(bulk_period)
        self._times = array("d")
        self._ticks = array("q")
        self._numbers: dict[str, array[float]] = {}
        self._kinds: dict[str, _Kind] = {}
        self._poses: dict[str, array[float]] = {}
        self._arrays: dict[str, list[tuple[float, _Rows]]] = {}
        self._integer_arrays: dict[str, list[tuple[float, IntArray]]] = {}
        self._strings: dict[str, list[str | None]] = {}

    def __len__(self) -> int:
        return len(self._times)

    # --- as a sink ------------------------------------------------------------------------------------------------

    def due(self, time: float) -> bool:
        """Whether a snapshot of this simulated time [s] is wanted; never after `close`."""
        return not self.closed and self._cadence.due(time)

    def write(self, snapshot: Snapshot) -> None:
        """Keep one snapshot; a second one of the same time takes the place of the first."""
        time = snapshot.time
        self._cadence.take(time)
        bulk = self._bulk_cadence.take(time)
        if self._times and time < self._times[-1]:
            self._forget(len(self._times))
        elif self._times and time == self._times[-1]:
            self._drop_last()
            bulk = True
        rows = len(self._times)
        self._times.append(time)
        self._ticks.append(snapshot.tick)
        self._add_numbers("double", snapshot.doubles, rows)
        self._add_numbers("integer", snapshot.integers, rows)
        self._add_numbers("boolean", snapshot.booleans, rows)
        if len(self._numbers) != len(snapshot.doubles) + len(snapshot.integers) + len(snapshot.booleans):
            for column in self._numbers.values():
                if len(column) == rows:
                    column.append(_NAN)
        for key, pose in snapshot.poses.items():
            columns = self._poses.get(key)
            if columns is None:
                columns = self._poses[key] = array("d", [_NAN] * (7 * rows))
            columns.extend(pose.tolist())
        for columns in self._poses.values():
            if len(columns) == 7 * rows:
                columns.extend([_NAN] * 7)
        for key, poses in (*snapshot.pose_arrays.items(), *snapshot.state_arrays.items()):
            kept = self._arrays.setdefault(key, [])
            is_long = is_bulk(key, len(poses)) or poses.shape[1] == _STATE
            if bulk or not is_long or not kept:
                self._add_array(kept, time, poses, is_long)
        for key, integers in snapshot.integer_arrays.items():
            kept_integers = self._integer_arrays.setdefault(key, [])
            if bulk or not is_bulk(key, len(integers)) or not kept_integers:
                last = kept_integers[-1][1] if kept_integers else None
                if last is None or not (last is integers or np.array_equal(last, integers)):
                    last = integers if _is_final(integers) else np.array(integers, dtype=np.int64)
                kept_integers.append((time, last))
        for key in snapshot.strings.keys() - self._strings.keys():
            self._strings[key] = [None] * rows
        for key, texts in self._strings.items():
            texts.append(snapshot.strings.get(key))
        if time - self._times[0] > 1.25 * self._seconds:
            self._forget(int(np.searchsorted(self._times, time - self._seconds)))

    def close(self) -> None:
        """Take no more; what was kept stays."""
        self.closed = True

    # --- what was kept --------------------------------------------------------------------------------------------

    @property
    def times(self) -> FloatArray:
        """Of all snapshots, rising [s], shape (n,)."""
        return np.array(self._times)

    @property
    def keys(self) -> tuple[str, ...]:
        """Of everything kept."""
        return (*self._numbers, *self._poses, *self._arrays, *self._integer_arrays, *self._strings)

    def has(self, key: str) -> bool:
        """Whether anything of that key was kept."""
        return key in self.keys

    def series(self, key: str) -> tuple[FloatArray, FloatArray]:
        """Times [s] and values of one number or boolean, as far as it was published, each of shape (m,).

        Raises:
            UnknownNameError: No snapshot had a number of that key.
        """
        if key not in self._numbers:
            raise UnknownNameError("recorded number", key, self._numbers)
        values = np.array(self._numbers[key])
        is_there = ~np.isnan(values)
        return self.times[is_there], values[is_there]

    def poses(self, key: str) -> tuple[FloatArray, FloatArray]:
        """Times [s], shape (m,), and rows `x, y, z, qw, qx, qy, qz` of one pose, shape (m, 7).

        Raises:
            UnknownNameError: No snapshot had a pose of that key.
        """
        if key not in self._poses:
            raise UnknownNameError("recorded pose", key, self._poses)
        rows = np.array(self._poses[key]).reshape(-1, 7)
        is_there = ~np.isnan(rows[:, 0])
        return self.times[is_there], rows[is_there]

    def array_times(self, key: str) -> FloatArray:
        """When an array of poses was kept [s].

        Raises:
            UnknownNameError: No snapshot had an array of that key.
        """
        return np.array([time for time, _ in self._kept(key)])

    def array_at(self, key: str, time: float) -> FloatArray:
        """The newest array of that time [s] or before (the first one, if there is none), shape (n, 7).

        Of states of swerve modules, shape (n, 2).

        Raises:
            UnknownNameError: No snapshot had an array of that key.
        """
        kept = self._kept(key)
        return _full(kept[_newest(kept, time)][1])

    def integers_at(self, key: str, time: float) -> IntArray:
        """The newest array of integers of that time [s] or before (the first one, if there is none), shape (n,).

        Raises:
            UnknownNameError: No snapshot had an array of integers of that key.
        """
        if key not in self._integer_arrays:
            raise UnknownNameError("recorded array of integers", key, self._integer_arrays)
        kept = self._integer_arrays[key]
        return kept[_newest(kept, time)][1]

    def integers(self, key: str) -> list[tuple[float, IntArray]]:
        """All kept arrays of integers of one key with their times [s], shape (n,) each; none where nothing was kept."""
        return list(self._integer_arrays.get(key, ()))

    def most_poses(self, key: str) -> int:
        """Rows of the longest kept array of poses of one key."""
        return max((len(rows) for _, rows in self._arrays.get(key, ())), default=0)

    def strings(self, key: str) -> tuple[FloatArray, list[str]]:
        """Times [s], shape (m,), and the m texts of one key, as far as it was published.

        Raises:
            UnknownNameError: No snapshot had a text of that key.
        """
        if key not in self._strings:
            raise UnknownNameError("recorded text", key, self._strings)
        texts = self._strings[key]
        return self.times[[text is not None for text in texts]], [text for text in texts if text is not None]

    def path(self, key: str) -> FloatArray:
        """One pose seen from above: `x, y, yaw` [m, m, rad], shape (m, 3); no rows where nothing was recorded."""
        if key not in self._poses:
            return np.empty((0, 3))
        _, rows = self.poses(key)
        w, x, y, z = rows[:, 3], rows[:, 4], rows[:, 5], rows[:, 6]
        yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        return np.column_stack((rows[:, 0], rows[:, 1], yaw))

    def pieces_at(self, time: float) -> dict[str, FloatArray]:
        """Pose rows of the pieces of each type at that time [s], field frame, shape (n, 7)."""
        keys = (key for key in self._arrays if key.startswith(_PIECES))
        return {key.removeprefix(_PIECES): self.array_at(key, time) for key in keys}

    def snapshots(self) -> Iterator[Snapshot]:
        """What was kept, tick by tick, for any other sink; numbers that are not a number are left out."""
        poses_due, integers_due = _Due(self._arrays), _Due(self._integer_arrays)
        poses = {key: np.array(columns).reshape(-1, 7) for key, columns in self._poses.items()}
        for row, (time, tick) in enumerate(zip(self._times, self._ticks, strict=True)):
            there = [(key, self._kinds[key], column[row]) for key, column in self._numbers.items()]
            there = [(key, kind, value) for key, kind, value in there if value == value]
            arrays = [(key, _full(rows)) for key, rows in poses_due.at(time)]
            yield Snapshot(
                time=time,
                tick=tick,
                poses={key: rows[row] for key, rows in poses.items() if rows[row, 0] == rows[row, 0]},
                pose_arrays={key: rows for key, rows in arrays if rows.shape[1] != _STATE},
                state_arrays={key: rows for key, rows in arrays if rows.shape[1] == _STATE},
                doubles={key: value for key, kind, value in there if kind == "double"},
                integers={key: int(value) for key, kind, value in there if kind == "integer"},
                booleans={key: bool(value) for key, kind, value in there if kind == "boolean"},
                integer_arrays=dict(integers_due.at(time)),
                strings={key: text for key, texts in self._strings.items() if (text := texts[row]) is not None},
            )

    # --- inside ---------------------------------------------------------------------------------------------------

    def _add_numbers(self, kind: _Kind, values: Mapping[str, float], rows: int) -> None:
        numbers = self._numbers
        for key, value in values.items():
            column = numbers.get(key)
            if column is None:
                column = numbers[key] = array("d", [_NAN]) * rows
                self._kinds[key] = kind
            column.append(value)

    @staticmethod
    def _add_array(kept: list[tuple[float, _Rows]], time: float, poses: FloatArray, is_long: bool) -> None:
        if not is_long:
            kept.append((time, poses if _is_final(poses) else poses.copy()))
            return
        is_upright = poses.shape[1] != _STATE and bool((poses[:, 3] == 1.0).all())
        small: _Rows = (poses[:, :3] if is_upright else poses).astype(np.float32)
        if kept and np.array_equal(kept[-1][1], small):
            small = kept[-1][1]  # nothing moved: share it
        kept.append((time, small))

    def _kept(self, key: str) -> list[tuple[float, _Rows]]:
        if key not in self._arrays:
            raise UnknownNameError("recorded array of poses", key, self._arrays)
        return self._arrays[key]

    def _drop_last(self) -> None:
        """Drop the newest row."""
        time = self._times.pop()
        self._ticks.pop()
        for column in self._numbers.values():
            column.pop()
        for columns in self._poses.values():
            del columns[-7:]
        for texts in self._strings.values():
            texts.pop()
        arrays: list[list[Any]] = [*self._arrays.values(), *self._integer_arrays.values()]
        for kept in arrays:
            if kept and kept[-1][0] == time:
                kept.pop()

    def _forget(self, rows: int) -> None:
        """Drop the oldest so many rows."""
        if rows >= len(self._times):
            self._times, self._ticks = array("d"), array("q")
            self._numbers, self._kinds, self._poses, self._arrays = {}, {}, {}, {}
            self._integer_arrays, self._strings = {}, {}
            return
        first = self._times[rows]
        del self._times[:rows], self._ticks[:rows]
        for column in self._numbers.values():
            del column[:rows]
        for columns in self._poses.values():
            del columns[: 7 * rows]
        for texts in self._strings.values():
            del texts[:rows]
        self._arrays = {key: _since(kept, first) for key, kept in self._arrays.items()}
        self._integer_arrays = {key: _since(kept, first) for key, kept in self._integer_arrays.items()}


def _is_final(rows: FloatArray | IntArray) -> bool:
    """Whether nobody changes an array any more, so that it may be kept as it is."""
    return not rows.flags.writeable and rows.base is None


class _Due(Generic[_Array]):
    """Walks through arrays of many keys in the order of time."""

    def __init__(self, arrays: Mapping[str, list[tuple[float, _Array]]]) -> None:
        self._rest = {key: iter(kept) for key, kept in arrays.items()}
        self._next = {key: next(rest, None) for key, rest in self._rest.items()}

    def at(self, time: float) -> list[tuple[str, _Array]]:
        """The arrays that were kept at exactly this time, which must not go back."""
        found = [(key, item[1]) for key, item in self._next.items() if item is not None and item[0] == time]
        for key, _ in found:
            self._next[key] = next(self._rest[key], None)
        return found


def newest_rows(at: FloatArray, times: FloatArray) -> IntArray:
    """Rows of the newest values, written at times `at` [s], at each of some times [s]; the first one's before it.

    >>> newest_rows(np.array([0.0, 1.0, 2.0]), np.array([-1.0, 1.0, 1.9])).tolist()
    [0, 1, 1]
    """
    rows: IntArray = np.clip(np.searchsorted(at, times + 1e-9) - 1, 0, None)
    return rows


def _newest(kept: list[tuple[float, _Array]], time: float) -> int:
    """Index of the last item of that time [s] or before; 0 if there is none."""
    return max(bisect_right(kept, time + 1e-9, key=lambda item: item[0]) - 1, 0)


def _since(kept: list[tuple[float, _Array]], first: float) -> list[tuple[float, _Array]]:
    """What is not older than a time [s]; an array that was last published before it keeps its newest value."""
    older = [item for item in kept if item[0] < first]
    newer = kept[len(older) :]
    return [(first, older[-1][1]), *newer] if older and not newer else newer


def _full(rows: _Rows) -> FloatArray:
    """Places as poses of shape (n, 7), all else as it is."""
    if rows.shape[1] != 3:
        return rows.astype(np.float64)
    poses = np.zeros((len(rows), 7))
    poses[:, :3] = rows
    poses[:, 3] = 1.0
    return poses
