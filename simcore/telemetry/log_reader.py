"""Reads `.wpilog` files into columns: ours, those of WPILib's DataLogManager and those of AdvantageKit.

A log that breaks off, because its program was killed or the disk was full, is read up to there. Payloads stay in the
file's bytes until they are read, so opening a match takes a second and seeking in it microseconds.

Source: https://github.com/wpilibsuite/allwpilib/blob/main/wpiutil/doc/datalog.adoc
"""

from __future__ import annotations

import lzma
import re
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from simcore.errors import LogError, UnknownNameError
from simcore.telemetry.snapshot import POSE_ARRAY_TYPE, POSE_TYPE, Snapshot
from simcore.typing import FloatArray, IntArray

__all__ = ["LogColumn", "TelemetryLog", "read_log"]

_POSE = 7 * 8  # [bytes]
_NUMBERS: dict[str, tuple[str, int]] = {
    "double": ("<f8", 8),
    "float": ("<f4", 4),
    "int64": ("<i8", 8),
    "boolean": ("<u1", 1),
}
_INTEGERS = "int64[]"
_LATEST = 2**62  # [us]; a later record has a broken stamp
_TEXT = "string"
_XZ = b"\xfd7zXZ\x00"
_PREFIX = re.compile(r"^(NT:)?/?(AdvantageKit/)?(RealOutputs/|ReplayOutputs/)?")


@dataclass(frozen=True, slots=True, eq=False)
class LogColumn:
    """All values of one key, in the order of time."""

    key: str
    type: str
    """As WPILib names it: `double`, `int64`, `boolean`, `int64[]`, `string`, `struct:Pose3d[]`, ..."""
    times: FloatArray
    """When each value was written [s], shape (n,)."""
    _data: bytes
    _places: list[int]
    _sizes: list[int]

    def __len__(self) -> int:
        return len(self._places)

    def payload(self, row: int) -> bytes:
        """Bytes of one value."""
        place = self._places[row]
        return self._data[place : place + self._sizes[row]]

    def numbers(self) -> FloatArray:
        """All values as numbers; booleans as 0 and 1.

        Raises:
            LogError: The column holds no numbers.
        """
        if self.type not in _NUMBERS:
            raise LogError(f"{self.key} is of type {self.type!r}, not one of {sorted(_NUMBERS)}")
        kind, size = _NUMBERS[self.type]
        raw = b"".join(self.payload(row)[:size].ljust(size, b"\0") for row in range(len(self)))
        return np.frombuffer(raw, dtype=kind).astype(np.float64)

    def poses(self) -> FloatArray:
        """All values of a Pose3d column, rows `x, y, z, qw, qx, qy, qz`, shape (n, 7).

        Raises:
            LogError: The column holds no Pose3d.
        """
        if self.type != POSE_TYPE:
            raise LogError(f"{self.key} is of type {self.type!r}, not {POSE_TYPE!r}")
        raw = b"".join(self.payload(row)[:_POSE].ljust(_POSE, b"\0") for row in range(len(self)))
        return np.frombuffer(raw, dtype="<f8").reshape(-1, 7)

    def pose_array(self, row: int) -> FloatArray:
        """One value of a Pose3d[] column, shape (m, 7).

        Raises:
            LogError: The column holds no Pose3d[].
        """
        if self.type != POSE_ARRAY_TYPE:
            raise LogError(f"{self.key} is of type {self.type!r}, not {POSE_ARRAY_TYPE!r}")
        raw = self.payload(row)
        return np.frombuffer(raw[: len(raw) // _POSE * _POSE], dtype="<f8").reshape(-1, 7)

    def integer_array(self, row: int) -> IntArray:
        """One value of an int64[] column, shape (m,).

        Raises:
            LogError: The column holds no int64[].
        """
        if self.type != _INTEGERS:
            raise LogError(f"{self.key} is of type {self.type!r}, not {_INTEGERS!r}")
        raw = self.payload(row)
        return np.frombuffer(raw[: len(raw) // 8 * 8], dtype="<i8")

    def text(self, row: int) -> str:
        """One value of a string column; bytes that are no UTF-8 are replaced.

        Raises:
            LogError: The column holds no text.
        """
        if self.type != _TEXT:
            raise LogError(f"{self.key} is of type {self.type!r}, not {_TEXT!r}")
        return self.payload(row).decode("utf-8", "replace")

    def row_at(self, time: float) -> int:
        """The newest value at a time [s]; -1 before the first."""
        return int(np.searchsorted(self.times, time + 1e-9, side="right")) - 1


@dataclass(frozen=True, slots=True, eq=False)
class TelemetryLog:
    """A whole log. Keys carry no prefix: `NT:/Sim/Robot/Pose3d` is `Sim/Robot/Pose3d`."""

    path: Path
    columns: Mapping[str, LogColumn]
    ends_early: bool
    """The last record is cut off, or what follows it is not a record."""
    _latest: dict[str, tuple[int, Any]]

    @property
    def span(self) -> tuple[float, float]:
        """From the first pose, if there is one, to the last value of all: poses at rest are logged no more [s]."""
        columns = [c for c in self.columns.values() if len(c)]
        if not columns:
            return 0.0, 0.0
        moving = [c for c in columns if c.type in (POSE_TYPE, POSE_ARRAY_TYPE)] or columns
        return min(float(c.times[0]) for c in moving), max(float(c.times[-1]) for c in columns)

    def column(self, key: str) -> LogColumn:
        """The column of a key.

        Raises:
            UnknownNameError: There is none.
        """
        if key not in self.columns:
            raise UnknownNameError("logged key", key, self.columns)
        return self.columns[key]

    def series(self, key: str) -> tuple[FloatArray, FloatArray]:
        """Times [s] and values of a number.

        Raises:
            UnknownNameError: It was not logged.
            LogError: It is no number.
        """
        column = self.column(key)
        return column.times, column.numbers()

    def snapshot_at(self, time: float) -> Snapshot:
        """What was known at a time [s], as the simulation published it."""
        poses: dict[str, FloatArray] = {}
        arrays: dict[str, FloatArray] = {}
        doubles: dict[str, float] = {}
        integers: dict[str, int] = {}
        booleans: dict[str, bool] = {}
        integer_arrays: dict[str, IntArray] = {}
        strings: dict[str, str] = {}
        for key, column in self.columns.items():
            row = column.row_at(time)
            if row < 0:
                continue
            if column.type == POSE_ARRAY_TYPE:
                arrays[key] = self._cached(column, row)
            elif column.type == POSE_TYPE:
                poses[key] = np.frombuffer(column.payload(row)[:_POSE].ljust(_POSE, b"\0"), dtype="<f8")
            elif column.type == _INTEGERS:
                integer_arrays[key] = column.integer_array(row)
            elif column.type == _TEXT:
                strings[key] = column.text(row)
            elif column.type in _NUMBERS:
                kind, size = _NUMBERS[column.type]
                value = np.frombuffer(column.payload(row)[:size].ljust(size, b"\0"), dtype=kind)[0]
                if column.type == "boolean":
                    booleans[key] = bool(value)
                elif column.type == "int64":
                    integers[key] = int(value)
                else:
                    doubles[key] = float(value)
        return Snapshot(
            time=time,
            tick=0,
            poses=poses,
            pose_arrays=arrays,
            doubles=doubles,
            integers=integers,
            booleans=booleans,
            integer_arrays=integer_arrays,
            strings=strings,
        )

    def _cached(self, column: LogColumn, row: int) -> FloatArray:
        """The same object while the value stays the same, so that a view sends it once."""
        known = self._latest.get(column.key)
        if known is None or known[0] != row:
            known = self._latest[column.key] = (row, column.pose_array(row))
        value: FloatArray = known[1]
        return value


class _Entry:
    """A column while it grows."""

    __slots__ = ("key", "micros", "places", "sizes", "type")

    def __init__(self, key: str, kind: str) -> None:
        self.key, self.type = key, kind
        self.micros: list[int] = []
        self.places: list[int] = []
        self.sizes: list[int] = []


def read_log(path: str | Path) -> TelemetryLog:
    """Read a log.

    Raises:
        LogError: There is no such file, it cannot be read, it is no data log, or it holds no record.
    """
    path = Path(path)
    try:
        data = path.read_bytes()
        if data.startswith(_XZ):
            data = lzma.LZMADecompressor().decompress(data)  # of one that is cut off what is there
    except (OSError, ValueError, lzma.LZMAError) as error:  # a path with a NUL is a ValueError
        raise LogError(f"cannot read the log {str(path)!r}: {getattr(error, 'strerror', None) or error}") from error
    if data[:6] != b"WPILOG" or len(data) < 12:
        kind = "empty" if not data else "not a .wpilog file (it does not start with WPILOG)"
        raise LogError(f"the log {str(path)!r} is {kind}; give one that simcore, DataLogManager or AdvantageKit wrote")
    version, extra = struct.unpack_from("<HI", data, 6)
    if version >> 8 != 1:
        raise LogError(f"the log {str(path)!r} has format {version >> 8}.{version & 255}; this reads 1.x")
    entries, ends_early = _scan(data, 12 + extra)
    if not entries:
        raise LogError(f"the log {str(path)!r} holds no record: its program was stopped before it wrote any")
    return TelemetryLog(path, {entry.key: _column(entry, data) for entry in entries}, ends_early, {})


def _scan(data: bytes, at: int) -> tuple[list[_Entry], bool]:
    """Find all records; whether the last one is cut off."""
    open_entries: dict[int, _Entry] = {}
    by_key: dict[str, _Entry] = {}
    end = len(data)
    integer = int.from_bytes
    while at < end:
        head = data[at]
        first = at + 2 + (head & 3)
        second = first + 1 + (head >> 2 & 3)
        start = second + 1 + (head >> 4 & 7)
        size = integer(data[first:second], "little")
        if start + size > end or head & 0x80:
            return list(by_key.values()), True
        entry = integer(data[at + 1 : first], "little")
        if entry:
            known = open_entries.get(entry)
            micros = integer(data[second:start], "little")
            if known is not None and micros <= _LATEST:
                known.micros.append(micros)
                known.places.append(start)
                known.sizes.append(size)
        elif not _control(data[start : start + size], open_entries, by_key):
            return list(by_key.values()), True
        at = start + size
    return list(by_key.values()), False


def _control(record: bytes, open_entries: dict[int, _Entry], by_key: dict[str, _Entry]) -> bool:
    """Start and end of entries; False for bytes that are no control record."""
    if len(record) < 5 or record[0] > 2:
        return False
    entry = int.from_bytes(record[1:5], "little")
    if record[0] == 1:
        open_entries.pop(entry, None)
    elif record[0] == 0:
        texts, at = [], 5
        for _ in range(3):
            if at + 4 > len(record):
                return False
            size = int.from_bytes(record[at : at + 4], "little")
            texts.append(record[at + 4 : at + 4 + size].decode("utf-8", "replace"))
            at += 4 + size
        key, kind = _PREFIX.sub("", texts[0]), texts[1]
        known = by_key.setdefault(key, _Entry(key, kind))
        if known.type == kind:  # a key that changes its type keeps its first
            open_entries[entry] = known
    return True


def _column(entry: _Entry, data: bytes) -> LogColumn:
    micros = np.array(entry.micros, dtype=np.int64)
    places, sizes = entry.places, entry.sizes
    if len(micros) and (np.diff(micros) < 0).any():  # AdvantageKit's and merged logs
        order = np.argsort(micros, kind="stable")
        micros = micros[order]
        places, sizes = [places[i] for i in order], [sizes[i] for i in order]
    times: FloatArray = micros.astype(np.float64) * 1e-6
    return LogColumn(entry.key, entry.type, times, data, places, sizes)
