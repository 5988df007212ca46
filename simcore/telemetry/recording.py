"""Compact recording of a run in memory, from which the log and the page of the run can be written."""

from __future__ import annotations

from array import array
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from simcore.errors import UnknownNameError
from simcore.quantities import DURATION, require
from simcore.telemetry.columns import FIELDS, Block, Columns, Table
from simcore.telemetry.sinks import Cadence
from simcore.telemetry.snapshot import EVENTS, Snapshot, is_bulk
from simcore.typing import FloatArray, IntArray

__all__ = ["Recording", "newest_rows"]

_STATE = 2  # columns of a swerve module state
_Rows: TypeAlias = "FloatArray | npt.NDArray[np.float32] | IntArray"
_NUMBERS = ("doubles", "integers", "booleans")


class Recording:
    """Telemetry sink that records a run in memory, in tables, readable even after `close`.

    A match of 160 s with 504 pieces takes 21 MB, a tenth of the size of the snapshots. The sink records arrays of more
    than 64 rows and swerve module states less often than other values, and rounds floats in these arrays to single
    precision. For a long array of poses without rotation, the sink records only the positions. A jump back in time
    deletes the recorded run and starts a new run.

    >>> recording = Recording()
    >>> for tick in range(3):
    ...     recording.write(Snapshot(time=0.02 * (tick + 1), tick=tick, doubles={"height": float(tick)}))
    >>> times, values = recording.series("height")
    >>> values.tolist()
    [0.0, 1.0, 2.0]
    """

    def __init__(self, *, period: float = 0.02, bulk_period: float = 0.04, seconds: float = 180.0) -> None:
        """Initialize an empty recording.

        Args:
            period: Simulated time between two snapshots [s].
            bulk_period: Simulated time between two recordings of an array with more than 64 rows [s].
            seconds: Duration of the newest part of the run that is always kept [s]; up to a quarter more may be kept.

        Raises:
            ConfigError: If a duration is not finite and > 0.
        """
        require("Recording", "seconds", seconds, DURATION)
        self.closed = False
        self.bulk_period = bulk_period
        """Simulated time between two recordings of an array with more than 64 rows [s]."""
        self._seconds = seconds
        self._cadence = Cadence(period)
        self._bulk_cadence = Cadence(bulk_period)
        self._texts: list[tuple[int, Mapping[str, str]]]  # first row of the texts, and the texts by key
        self._arrays: dict[str, list[tuple[float, _Rows]]]
        self._given: dict[str, _Rows]  # latest arrays as passed in, so that the same object is not compared again
        self._found: dict[str, tuple[int, dict[str, int]]]  # cached results of `_kept`, with the number of rows
        self._forget_all()

    def __len__(self) -> int:
        return len(self._times)

    # --- as a sink ------------------------------------------------------------------------------------------------

    def due(self, time: float) -> bool:
        """Return whether a snapshot is due at a simulated time [s]; always False after `close`."""
        return not self.closed and self._cadence.due(time)

    def write(self, snapshot: Snapshot) -> None:
        """Record a snapshot.

        A snapshot at the time of the last snapshot replaces the last snapshot. A snapshot at an earlier time deletes
        the recorded run and starts a new run.
        """
        time = snapshot.time
        self._cadence.take(time)
        bulk = self._bulk_cadence.take(time)
        if self._times and time < self._times[-1]:
            self._forget(len(self._times))
        elif self._times and time == self._times[-1]:
            self._drop_last()
            bulk = True
        for field in FIELDS:
            self._add_row(field, getattr(snapshot, field))
        if not self._texts or self._texts[-1][1] != snapshot.strings:
            self._texts.append((len(self._times), dict(snapshot.strings)))
        self._times.append(time)
        self._ticks.append(snapshot.tick)
        for arrays in (snapshot.pose_arrays, snapshot.state_arrays, snapshot.integer_arrays):
            for key, values in arrays.items():
                self._add_array(key, time, values, bulk, is_state=arrays is snapshot.state_arrays)
        if time - self._times[0] > 1.25 * self._seconds:
            self._forget(int(np.searchsorted(self._times, time - self._seconds)))

    def fill(self, times: FloatArray, columns: Sequence[tuple[str, str, Sequence[Any], IntArray]]) -> None:
        """Replace the recorded data with a whole run, with the same result as calls of `write` tick by tick.

        Args:
            times: Times of the ticks in rising order [s], shape (n,).
            columns: Field of `Snapshot`, key, all values, and index of the value in each tick, shape (n,), -1 for no
                value, for each key.
        """
        self._forget_all()
        self._times, self._ticks = array("d", times.tolist()), array("q", range(len(times)))
        bulk = [self._bulk_cadence.take(time) for time in self._times]
        texts: list[dict[str, str]] = [{} for _ in self._times]
        for field, key, *_ in columns:
            if field in FIELDS:
                self._tables[field].place(key)
        self._blocks = {field: table.empty(len(times)) for field, table in self._tables.items()}
        for field, key, values, rows in columns:
            ticks = np.nonzero(rows >= 0)[0]
            if field in FIELDS and len(ticks):
                self._blocks[field][ticks, self._tables[field].places[key]] = np.array(values)[rows[ticks]]
            elif field == "strings":
                for tick in ticks.tolist():
                    texts[tick][key] = values[rows[tick]]
            elif field not in FIELDS:
                for tick in ticks.tolist():
                    self._add_array(key, self._times[tick], values[rows[tick]], bulk[tick], field == "state_arrays")
        self._texts = [(tick, one) for tick, one in enumerate(texts) if not tick or one != texts[tick - 1]]

    def close(self) -> None:
        """Stop the recording; the recorded data remain available."""
        self.closed = True

    # --- recorded data --------------------------------------------------------------------------------------------

    @property
    def times(self) -> FloatArray:
        """Times of all snapshots in rising order [s], shape (n,)."""
        return np.array(self._times)

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys with at least one recorded value, of all types."""
        numbers = [key for field in (*_NUMBERS, "poses") for key in self._kept(field)]
        return (*numbers, *self._arrays, *dict.fromkeys(key for _, texts in self._texts for key in texts))

    def has(self, key: str) -> bool:
        """Return whether at least one value of a key is recorded."""
        return (
            key in self._arrays
            or any(key in self._kept(field) for field in FIELDS)
            or any(key in texts for _, texts in self._texts)
        )

    def columns(self, field: str, keys: Sequence[str]) -> Block:
        """Return the values of some keys in all snapshots, including gaps.

        Args:
            field: Field of `Snapshot` that contains the keys, a key of `FIELDS`.
            keys: Keys; a key that was never published has only gaps.

        Returns:
            Values with a row for each of n snapshots, shape (n, keys), or (n, keys, 7) for poses.
        """
        table, block = self._tables[field], self._blocks[field][: len(self)]
        found = np.full((len(self), len(keys), *table.shape), table.gap, table.dtype)
        for number, key in enumerate(keys):
            if key in table.places:
                found[:, number] = block[:, table.places[key]]
        return found

    def series(self, key: str) -> tuple[FloatArray, FloatArray]:
        """Return the times [s] and values of a number or boolean key without gaps and NaN, two arrays of shape (m,).

        Raises:
            UnknownNameError: If no number of this key was recorded.
        """
        found = [field for field in _NUMBERS if key in self._kept(field)]
        if not found:
            raise UnknownNameError("recorded number", key, [one for field in _NUMBERS for one in self._kept(field)])
        values = self.columns(found[0], [key])[:, 0]
        is_there = ~(self._tables[found[0]].gaps(values) | np.isnan(values))
        return self.times[is_there], values[is_there].astype(np.float64)

    def poses(self, key: str) -> tuple[FloatArray, FloatArray]:
        """Return the times [s], shape (m,), and the poses of a key, rows `x, y, z, qw, qx, qy, qz`, shape (m, 7).

        Raises:
            UnknownNameError: If no pose of this key was recorded.
        """
        if key not in self._kept("poses"):
            raise UnknownNameError("recorded pose", key, self._kept("poses"))
        rows = self.columns("poses", [key])[:, 0]
        is_there = ~np.isnan(rows[:, 0])
        return self.times[is_there], rows[is_there]

    def array_at(self, key: str, time: float) -> FloatArray:
        """Return the newest array of a key at or before a time [s]; if all arrays are later, return the first array.

        Returns:
            Poses, shape (n, 7), swerve module states, shape (n, 2), or integers, shape (n,).

        Raises:
            UnknownNameError: If no array of this key was recorded.
        """
        rows: FloatArray = _full(self._kept_at(key, time))
        return rows

    def integers_at(self, key: str, time: float) -> IntArray:
        """Return the newest array of integers of a key at or before a time [s], shape (n,).

        If all arrays are later, return the first array.

        Raises:
            UnknownNameError: If no array of this key was recorded.
        """
        return self._kept_at(key, time).astype(np.int64, copy=False)

    def integers(self, key: str) -> list[tuple[float, IntArray]]:
        """Return the time [s] and value of each recorded array of integers of a key; empty for an unknown key."""
        return [(time, rows.astype(np.int64, copy=False)) for time, rows in self._arrays.get(key, ())]

    def events(self, key: str) -> list[tuple[float, list[int]]]:
        """Return time [s] and row of each event since the last restart of the event numbers, for a key of `EVENTS`."""
        return _all_events(self.integers(key), EVENTS[key])

    def most_poses(self, key: str) -> int:
        """Return the number of rows of the longest recorded array of a key; 0 if no array was recorded."""
        return max((len(rows) for _, rows in self._arrays.get(key, ())), default=0)

    def strings(self, key: str) -> tuple[FloatArray, list[str]]:
        """Return the times [s], shape (m,), and the m texts of a key, one for each snapshot that contains the key.

        Raises:
            UnknownNameError: If no text of this key was recorded.
        """
        if not any(key in texts for _, texts in self._texts):
            known = dict.fromkeys(key for _, texts in self._texts for key in texts)
            raise UnknownNameError("recorded text", key, known)
        texts = [one.get(key) for one in self._texts_by_row()]
        return self.times[[text is not None for text in texts]], [text for text in texts if text is not None]

    def path(self, key: str) -> FloatArray:
        """Return the path of a pose, rows of x, y, yaw [m, m, rad], shape (m, 3); no rows for an unknown key."""
        if key not in self._kept("poses"):
            return np.empty((0, 3))
        _, rows = self.poses(key)
        w, x, y, z = rows[:, 3], rows[:, 4], rows[:, 5], rows[:, 6]
        yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        return np.column_stack((rows[:, 0], rows[:, 1], yaw))

    def snapshots(self, rows: Sequence[int] | IntArray | None = None) -> Iterator[Snapshot]:
        """Yield recorded snapshots.

        Each snapshot contains the latest recording of each array up to the snapshot's time. Successive snapshots
        contain the same array object until the array changes.

        Args:
            rows: Row numbers of the snapshots in ascending order; None for all snapshots.
        """
        chosen = np.arange(len(self)) if rows is None else np.asarray(rows, np.int64)
        newest = {
            key: (np.searchsorted([time for time, _ in kept], self.times[chosen], side="right") - 1).tolist()
            for key, kept in self._arrays.items()
        }
        texts = self._texts_by_row()
        made: dict[str, tuple[_Rows, Any]] = {}  # recorded and expanded form of the latest array, by key
        for number, row in enumerate(chosen.tolist()):
            for key, places in newest.items():
                values = self._arrays[key][places[number]][1]
                if places[number] >= 0 and (key not in made or made[key][0] is not values):
                    made[key] = values, _full(values)
            arrays = [(key, full) for key, (_, full) in made.items()]
            yield Snapshot(
                time=self._times[row],
                tick=self._ticks[row],
                pose_arrays={key: full for key, full in arrays if full.ndim == 2 and full.shape[1] != _STATE},
                state_arrays={key: full for key, full in arrays if full.ndim == 2 and full.shape[1] == _STATE},
                integer_arrays={key: full for key, full in arrays if full.ndim == 1},
                strings=texts[row],
                **{field: Columns(table, self._blocks[field][row]) for field, table in self._tables.items()},
            )

    # --- inside ---------------------------------------------------------------------------------------------------

    def _add_row(self, field: str, values: Mapping[str, Any]) -> None:
        """Add a row to the table of a field; enlarge a full table by half of the rows."""
        table, block, rows = self._tables[field], self._blocks[field], len(self._times)
        row = table.row(values)
        if rows == len(block) or len(row) > block.shape[1]:
            more = table.empty(max(256, rows + rows // 2) if rows == len(block) else len(block))
            more[:rows, : block.shape[1]] = block[:rows]
            block = self._blocks[field] = more
        block[rows] = row

    def _kept(self, field: str) -> dict[str, int]:
        """Return the index of each column that has a value in at least one row, by key."""
        rows, found = self._found.get(field, (-1, {}))
        if rows != (now := len(self._times)):
            table, block = self._tables[field], self._blocks[field]
            has_values = np.asarray(~table.gaps(block[:now]).all(axis=0)).tolist()
            found = {key: place for key, place in table.places.items() if place < len(has_values) and has_values[place]}
            self._found[field] = now, found
        return found

    def _texts_by_row(self) -> list[Mapping[str, str]]:
        ends = [*(row for row, _ in self._texts[1:]), len(self._times)]
        return [texts for (first, texts), last in zip(self._texts, ends, strict=False) for _ in range(first, last)]

    def _add_array(self, key: str, time: float, values: _Rows, bulk: bool, is_state: bool) -> None:
        """Record an array, or ignore the array if the array is long and not due.

        Args:
            key: Telemetry key of the array.
            time: Simulated time [s].
            values: Array to record.
            bulk: Whether long arrays and swerve module states are due; the first array of a key is always due.
            is_state: Whether the array contains swerve module states.
        """
        kept, given = self._arrays.setdefault(key, []), values
        is_long = is_state or is_bulk(key, len(values))
        if kept and is_long and not bulk:
            return
        if kept and not given.flags.writeable and self._given.get(key) is given:
            kept.append((time, kept[-1][1]))
            return
        self._given[key] = given
        if is_long and values.ndim == 2:
            is_upright = values.shape[1] != _STATE and bool((values[:, 3] == 1.0).all())
            values = (values[:, :3] if is_upright else values).astype(np.float32)
        elif values.flags.writeable or values.base is not None:
            values = values.copy()  # the caller may change the array later
        values.setflags(write=False)
        before = kept[-1][1] if kept else None
        if before is not None and before.shape == values.shape and before.tobytes() == values.tobytes():
            values = before  # unchanged: share the array
        kept.append((time, values))

    def _kept_at(self, key: str, time: float) -> _Rows:
        if key not in self._arrays:
            raise UnknownNameError("recorded array", key, self._arrays)
        kept = self._arrays[key]
        return kept[max(bisect_right(kept, time + 1e-9, key=lambda item: item[0]) - 1, 0)][1]

    def _drop_last(self) -> None:
        """Delete the newest snapshot, with the texts and arrays of the same time."""
        time = self._times.pop()
        self._ticks.pop()
        self._given, self._found = {}, {}
        while self._texts and self._texts[-1][0] >= len(self._times):
            self._texts.pop()
        for kept in self._arrays.values():
            if kept and kept[-1][0] == time:
                kept.pop()

    def _forget(self, rows: int) -> None:
        """Delete the oldest `rows` snapshots; keep the newest earlier array of a key that has no later array."""
        if rows >= len(self._times):
            self._forget_all()
            return
        first, left = self._times[rows], len(self._times) - rows
        self._given, self._found = {}, {}
        del self._times[:rows], self._ticks[:rows]
        for block in self._blocks.values():
            block[:left] = block[rows : rows + left]
        begins = [max(0, row - rows) for row, _ in self._texts]
        last = begins.count(0) - 1
        self._texts = [*zip(begins[last:], (texts for _, texts in self._texts[last:]), strict=True)]
        self._arrays = {key: _since(key, kept, first) for key, kept in self._arrays.items()}

    def _forget_all(self) -> None:
        self._times, self._ticks = array("d"), array("q")
        self._tables = {field: Table(field) for field in FIELDS}
        self._blocks = {field: table.empty(0) for field, table in self._tables.items()}  # with spare rows
        self._texts, self._arrays = [], {}
        self._given, self._found = {}, {}


def newest_rows(at: FloatArray, times: FloatArray) -> IntArray:
    """Return the index of the newest value at or before each time.

    Args:
        at: Times of the values in rising order [s].
        times: Times to look up [s]; the index is 0 for a time before the first value.

    >>> newest_rows(np.array([0.0, 1.0, 2.0]), np.array([-1.0, 1.0, 1.9])).tolist()
    [0, 1, 1]
    """
    rows: IntArray = np.clip(np.searchsorted(at, times + 1e-9) - 1, 0, None)
    return rows


def _all_events(kept: Iterable[tuple[float, IntArray]], columns: int) -> list[tuple[float, list[int]]]:
    """Return time [s] and row of each event; discard earlier events when the newest event number decreases.

    Args:
        kept: Time [s] and event array of each recording.
        columns: Number of values per row.
    """
    found: dict[int, tuple[float, list[int]]] = {}
    before: IntArray | None = None
    newest = 0
    for time, values in kept:
        if values is before:
            continue
        before, rows = values, values[: len(values) // columns * columns].reshape(-1, columns).tolist()
        if (last := max((row[0] for row in rows), default=0)) < newest:
            found.clear()
        newest = last
        for row in rows:
            if row[0] not in found or found[row[0]][1] != row:
                found[row[0]] = time, row
    return list(found.values())


def _since(key: str, kept: list[tuple[float, _Rows]], first: float) -> list[tuple[float, _Rows]]:
    """Return the arrays of a key since time `first` [s]; without such an array, return the newest earlier array.

    For a key of `EVENTS`, the first returned array contains all events until `first`.
    """
    if key in EVENTS:
        before = ((time, rows.astype(np.int64, copy=False)) for time, rows in kept if time <= first)
        whole = np.array([row for _, row in _all_events(before, EVENTS[key])], np.int64).ravel()
        return [(first, whole), *(item for item in kept if item[0] > first)]
    older = [item for item in kept if item[0] < first]
    newer = kept[len(older) :]
    return [(first, older[-1][1]), *newer] if older and not newer else newer


def _full(rows: _Rows) -> Any:
    """Expand positions to poses without rotation, shape (n, 7); return any other array as float64 or int64."""
    if rows.ndim == 1:
        return rows.astype(np.int64, copy=False)
    if rows.shape[1] != 3:
        return rows.astype(np.float64, copy=False)
    poses = np.zeros((len(rows), 7))
    poses[:, :3] = rows
    poses[:, 3] = 1.0
    return poses
