"""Writer and reader of `.wpilog` files, WPILib's data logs, for AdvantageScope and other tools.

This module implements format 1.0 itself, because no writer of WPILib 2026.2.2 is suitable for a simulation:

* `wpiutil.DataLogWriter` accepts timestamps and file names, but hangs after about 0.5 MB between two flushes (fixed
  later, allwpilib #9258), and replaces a simulated time of 0 by wall time.
* `wpilib.DataLogManager` exists once per process, uses wall time and does not overwrite files.

Source: https://github.com/wpilibsuite/allwpilib/blob/main/wpiutil/doc/datalog.adoc; tests read the logs back with
WPILib's own `DataLogReader`.
"""

from __future__ import annotations

import contextlib
import io
import lzma
import re
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from simcore.errors import ConfigError, LogError, OutputError, UnknownNameError
from simcore.telemetry.columns import FIELDS, Changes
from simcore.telemetry.sinks import Cadence, output_error
from simcore.telemetry.snapshot import (
    POSE_ARRAY_TYPE,
    POSE_TYPE,
    SCHEMA_TYPE,
    STATE_ARRAY_TYPE,
    STRUCT_SCHEMAS,
    Snapshot,
    checked_integers,
    is_bulk,
    struct_array_bytes,
)
from simcore.typing import FloatArray, IntArray

__all__ = ["LogColumn", "TelemetryLog", "WpilogSink", "read_log"]

_FLUSH_BYTES = 256 * 1024
_FLUSH_MICROS = 1_000_000
_MAX_TIME = 1e9  # [s], 31 years

# The format allows fields of 1-4 bytes (timestamps 1-8). With a few fixed layouts, a record needs one `pack` call, and
# all records of one type in a tick need one copy. Keys: payload < 256 bytes, time < 72 minutes; entries are < 65 536.
# First byte of a record: entry length - 1, size length - 1 (<< 2), timestamp length - 1 (<< 4).
_HEADERS = {
    (True, True): (struct.Struct("<BHBI"), 0b0_011_00_01),
    (False, True): (struct.Struct("<BHII"), 0b0_011_11_01),
    (True, False): (struct.Struct("<BHBQ"), 0b0_111_00_01),
    (False, False): (struct.Struct("<BHIQ"), 0b0_111_11_01),
}
_COLUMNS = {"poses": POSE_TYPE, "doubles": "double", "integers": "int64", "booleans": "boolean"}
"""Type name in WPILib of the values in a table, by field of `Snapshot`."""
_HELD, _HELD_PERIOD = "Sim/Held", 0.04  # [s]; in every tick, held pieces would take a sixth of a match's log


@cache
def _record(field: str, is_early: bool) -> np.dtype[Any]:
    """Return the numpy layout of a log record with a number or pose.

    Args:
        field: Field of `Snapshot` with the value.
        is_early: Whether the timestamp is below 2^32 us (72 minutes) and takes 4 bytes instead of 8.
    """
    dtype, shape, _ = FIELDS[field]
    value = ("value", np.dtype(dtype).newbyteorder("<"), shape)
    return np.dtype([("head", "u1"), ("entry", "<u2"), ("size", "u1"), ("time", "<u4" if is_early else "<u8"), value])


class WpilogSink:
    """Telemetry sink that writes a `.wpilog` file, with the entry names of DataLogManager's logs of NetworkTables.

    The sink writes a value only after a change, as the format intends. The sink writes long arrays (450 poses take
    25 KB) and pieces in robots less often than other values, and once more at the end. In every tick, long arrays alone
    would take 200 MB in a match. The sink flushes whole records to disk at least every simulated second or every
    256 KB. Therefore, the log remains valid if the process is killed.
    """

    def __init__(
        self, path: str | Path, *, period: float = 0.02, bulk_period: float = 0.1, prefix: str = "NT:/"
    ) -> None:
        """Create missing folders and the log file, and write the struct schemas; an existing file is overwritten.

        Args:
            path: Path of the log, usually `*.wpilog`. A log `*.wpilogxz` is compressed to an eighth of the size.
            period: Simulated time between two snapshots [s].
            bulk_period: Simulated time between two records of an array with more than 64 rows [s].
            prefix: Prefix of each key; with the default, an AdvantageScope layout fits both live data and logs.

        Raises:
            OutputError: If the file cannot be written.
            ConfigError: If a period is not finite and > 0.
        """
        self.path = Path(path)
        self.prefix = prefix
        self._cadence = Cadence(period)
        self._bulk_cadence, self._held_cadence = Cadence(bulk_period), Cadence(min(_HELD_PERIOD, bulk_period))
        self._last: Snapshot | None = None
        self._buffer = bytearray()
        self._flushed_at = 0  # [us]
        self._types: dict[str, str] = {}
        self._entries: dict[str, int] = {}
        self._values: dict[str, bytes] = {}
        self._arrays: dict[str, FloatArray | IntArray] = {}  # last written, by key: skips comparing the same object
        self._changes = {field: Changes(field) for field in _COLUMNS}
        self._entry_of = {field: np.zeros(0, np.uint16) for field in _COLUMNS}  # 0 before a column's first value
        self._texts: Mapping[str, str] = {}  # last written
        self._packer = lzma.LZMACompressor(preset=1) if self.path.suffix == ".wpilogxz" else None
        self._file: io.FileIO | None = None
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._file = io.FileIO(self.path, "w")
        except OSError as error:
            raise output_error("log", self.path, error) from error
        self._buffer += b"WPILOG" + struct.pack("<HI", 0x0100, 0)
        for name, schema in STRUCT_SCHEMAS.items():
            entry = self._start(f".schema/{name}", SCHEMA_TYPE, 0)
            self._append(entry, schema.encode(), 0)
        self._flush(0)

    @property
    def closed(self) -> bool:
        """Whether the log is closed, by `close` or by a write error."""
        return self._file is None

    def due(self, time: float) -> bool:
        """Return whether a snapshot is due at a simulated time [s]; always False for a closed log."""
        return self._file is not None and self._cadence.due(time)

    def write(self, snapshot: Snapshot) -> None:
        """Write the changed values of a snapshot with the snapshot's simulated time.

        Raises:
            OutputError: If the log is closed, or if writing to the disk fails; the failure closes the log.
            ConfigError: If an array has the wrong shape, the type of a key has changed, or the time is not from 0 to
                1e9 s.
        """
        if self._file is None:
            raise OutputError(f"the log {str(self.path)!r} is closed; create a new WpilogSink to log on")
        if not 0.0 <= snapshot.time < _MAX_TIME:
            raise ConfigError(f"a snapshot needs a finite time >= 0 s, got {snapshot.time}")
        micros = round(snapshot.time * 1e6)
        self._cadence.take(snapshot.time)
        self._write_columns("poses", snapshot.poses, micros)
        bulk, held = (cadence.take(snapshot.time) for cadence in (self._bulk_cadence, self._held_cadence))
        self._write_arrays(snapshot, micros, bulk=bulk, held=held)
        self._last = snapshot
        self._write_columns("doubles", snapshot.doubles, micros)
        self._write_columns("integers", snapshot.integers, micros)
        self._write_columns("booleans", snapshot.booleans, micros)
        if snapshot.strings != self._texts:
            self._texts = dict(snapshot.strings)
            for key, text in snapshot.strings.items():
                self._append_changed(key, "string", text.encode(), micros)
        if len(self._buffer) >= _FLUSH_BYTES or abs(micros - self._flushed_at) >= _FLUSH_MICROS:
            self._flush(micros)

    def close(self) -> None:
        """Write the remaining data and close the file; a second call has no effect.

        Raises:
            OutputError: If the remaining data cannot be written.
        """
        if self._file is None:
            return
        if self._last is not None:
            self._write_arrays(self._last, round(self._last.time * 1e6), bulk=True, held=True)
        self._flush(self._flushed_at, ends=True)
        if self._file is not None:
            self._file.close()
            self._file = None

    def __enter__(self) -> WpilogSink:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _write_arrays(self, snapshot: Snapshot, micros: int, *, bulk: bool, held: bool) -> None:
        """Write the changed arrays that are due; ids and poses of pieces are due in the same ticks.

        Args:
            snapshot: Snapshot with the arrays.
            micros: Timestamp [us].
            bulk: Whether long arrays and poses of robot parts are due.
            held: Whether pieces in robots are due.
        """

        def is_due(key: str, rows: FloatArray | IntArray) -> bool:
            if self._arrays.get(key) is rows and not rows.flags.writeable:
                return False  # the same array object was written last, so its bytes need not be compared
            is_so = held if key.startswith(_HELD) else bulk or not is_bulk(key, len(rows))
            if is_so or key not in self._entries:
                self._arrays[key] = rows
                return True
            return False

        for type_name, arrays in snapshot.struct_arrays:
            for key, rows in arrays.items():
                if is_due(key, rows):
                    self._append_changed(key, type_name, struct_array_bytes(type_name, key, rows), micros)
        for key, integers in snapshot.integer_arrays.items():
            if is_due(key, integers):
                self._append_changed(key, "int64[]", checked_integers(key, integers).tobytes(), micros)

    def _write_columns(self, field: str, values: Mapping[str, Any], micros: int) -> None:
        """Write the changed values of one type.

        The comparison is bitwise: NaN is equal to NaN, and -0.0 differs from 0.0.
        """
        columns, block = self._changes[field].of(values)
        if not len(columns):
            return
        table, entries = self._changes[field].table, self._entry_of[field]
        if len(entries) < len(table.keys):
            entries = self._entry_of[field] = np.concatenate(
                (entries, np.zeros(len(table.keys) - len(entries), np.uint16))
            )
        for column in columns[entries[columns] == 0].tolist():
            entries[column] = self._entry(table.keys[column], _COLUMNS[field], micros)
        _, head = _HEADERS[True, micros < 1 << 32]
        records = np.empty(len(columns), _record(field, micros < 1 << 32))
        records["head"], records["entry"], records["size"] = head, entries[columns], block[0].nbytes
        records["time"], records["value"] = micros, block
        self._buffer += records.tobytes()

    def _append_changed(self, key: str, type_name: str, payload: bytes, micros: int) -> None:
        entry = self._entry(key, type_name, micros)
        if self._values.get(key) != payload:
            self._values[key] = payload
            self._append(entry, payload, micros)

    def _entry(self, key: str, type_name: str, micros: int) -> int:
        known = self._types.get(key)
        if known is None:
            return self._start(key, type_name, micros)
        if known != type_name:
            raise ConfigError(f"{key}: logged as {known} before, now as {type_name}; one key has one type")
        return self._entries[key]

    def _start(self, key: str, type_name: str, micros: int) -> int:
        if not key or key.startswith("/"):
            raise ConfigError(f"a telemetry key is a name without a leading '/', got {key!r}")
        entry = len(self._entries) + 1  # entry 0 is the control channel
        self._types[key], self._entries[key] = type_name, entry
        parts = (f"{self.prefix}{key}", type_name, '{"source":"simcore"}')
        record = struct.pack("<BI", 0, entry)  # control record 0: start
        record += b"".join(struct.pack("<I", len(text)) + text for text in (part.encode() for part in parts))
        self._append(0, record, micros)
        return entry

    def _append(self, entry: int, payload: bytes, micros: int) -> None:
        header, head = _HEADERS[len(payload) < 1 << 8, micros < 1 << 32]
        self._buffer += header.pack(head, entry, len(payload), micros)
        self._buffer += payload

    def _flush(self, micros: int, *, ends: bool = False) -> None:
        if self._file is None:
            return
        data = bytes(self._buffer)
        if self._packer is not None:
            data = self._packer.compress(data) + (self._packer.flush() if ends else b"")
        try:
            rest = memoryview(data)
            while rest:
                rest = rest[self._file.write(rest) :]
        except OSError as error:
            file, self._file = self._file, None
            with contextlib.suppress(OSError):
                file.close()
            raise OutputError(
                f"the log {str(self.path)!r} ends here: {error.strerror or error}. "
                "What was written before is readable; free some space or log to another disk"
            ) from error
        self._buffer = bytearray()
        self._flushed_at = micros


_LATEST = 2**62  # [us]; a record with a later timestamp is corrupt


def _row(raw: bytes, width: int) -> FloatArray:
    """Decode a struct of `width` doubles, shape (width,); missing bytes are decoded as 0."""
    return np.frombuffer(raw[: 8 * width].ljust(8 * width, b"\0"), dtype="<f8")


def _rows(raw: bytes, width: int) -> FloatArray:
    """Decode an array of structs of `width` doubles, shape (n, width); ignore an incomplete struct at the end."""
    return np.frombuffer(raw[: len(raw) // (8 * width) * 8 * width], dtype="<f8").reshape(-1, width)


def _number(raw: bytes, format: str) -> float:
    """Decode a number in a format of `struct`; missing bytes are decoded as 0."""
    size = struct.calcsize(format)
    number: float = struct.unpack(format, raw[:size].ljust(size, b"\0"))[0]
    return number


_TYPES: dict[str, tuple[str, Callable[[bytes], Any]]] = {
    POSE_TYPE: ("poses", partial(_row, width=7)),
    POSE_ARRAY_TYPE: ("pose_arrays", partial(_rows, width=7)),
    STATE_ARRAY_TYPE: ("state_arrays", partial(_rows, width=2)),
    "double": ("doubles", partial(_number, format="<d")),
    "float": ("doubles", partial(_number, format="<f")),
    "int64": ("integers", partial(_number, format="<q")),
    "boolean": ("booleans", partial(_number, format="<?")),
    "int64[]": ("integer_arrays", lambda raw: np.frombuffer(raw[: len(raw) // 8 * 8], dtype="<i8")),
    "string": ("strings", lambda raw: raw.decode("utf-8", "replace")),
}
"""Field of `Snapshot`, and function that decodes a value, by name of the WPILib type."""
_NUMBERS = ("double", "float", "int64", "boolean")
_XZ = b"\xfd7zXZ\x00"
_PREFIX = re.compile(r"^(NT:)?/?(AdvantageKit/)?(RealOutputs/|ReplayOutputs/)?")


@dataclass(frozen=True, slots=True, eq=False)
class LogColumn:
    """Values of one key of a log, in order of time."""

    key: str
    type: str
    """Type name in WPILib, e.g. `double`, `int64[]` or `struct:Pose3d[]`."""
    times: FloatArray
    """Time of each value [s], shape (n,)."""
    _data: bytes
    _places: list[int]
    _sizes: list[int]
    metadata: str = ""
    """Metadata in the start record of the entry, e.g. a unit or JSON."""

    def __len__(self) -> int:
        return len(self._places)

    def payload(self, row: int) -> bytes:
        """Return the encoded bytes of the value at index `row`."""
        place = self._places[row]
        return self._data[place : place + self._sizes[row]]

    def value(self, row: int) -> Any:
        """Return the decoded value at index `row`: a number, a text, a pose of shape (7,), or an array.

        Raises:
            LogError: If `Snapshot` has no field for values of this type.
        """
        if self.type not in _TYPES:
            raise LogError(f"{self.key} is of type {self.type!r}, not one of {sorted(_TYPES)}")
        return _TYPES[self.type][1](self.payload(row))

    @property
    def field(self) -> str | None:
        """Name of the field of `Snapshot` for values of this type; None if `Snapshot` has no such field."""
        return _TYPES[self.type][0] if self.type in _TYPES else None

    def rows_at(self, times: FloatArray) -> IntArray:
        """Return the index of the newest value at or before each time [s], shape (n,); -1 before the first value."""
        rows: IntArray = np.searchsorted(self.times, times + 1e-9, side="right") - 1
        return rows


@dataclass(frozen=True, slots=True, eq=False)
class TelemetryLog:
    """Contents of a log: a column with the values of each key.

    `read_log` removes prefixes such as `NT:/` from keys: `NT:/Sim/Robot/Pose3d` becomes `Sim/Robot/Pose3d`.
    """

    path: Path
    columns: Mapping[str, LogColumn]
    ends_early: bool
    """Whether the log ends with an incomplete or invalid record."""

    @property
    def span(self) -> tuple[float, float]:
        """Time of the first pose, or of the first value in a log without poses, and time of the last value [s].

        Both times are 0 for a log without values.
        """
        columns = [c for c in self.columns.values() if len(c)]
        if not columns:
            return 0.0, 0.0
        moving = [c for c in columns if c.type in (POSE_TYPE, POSE_ARRAY_TYPE)] or columns
        return min(float(c.times[0]) for c in moving), max(float(c.times[-1]) for c in columns)

    def column(self, key: str) -> LogColumn:
        """Return the column of a key.

        Raises:
            UnknownNameError: If the log does not contain the key.
        """
        if key not in self.columns:
            raise UnknownNameError("logged key", key, self.columns)
        return self.columns[key]

    def series(self, key: str) -> tuple[FloatArray, FloatArray]:
        """Return the times [s] and values of a number or boolean key, two arrays of shape (n,).

        Raises:
            UnknownNameError: If the log does not contain the key.
            LogError: If the values of the key are not numbers.
        """
        column = self.column(key)
        if column.type not in _NUMBERS:
            raise LogError(f"{key} is of type {column.type!r}, not one of {list(_NUMBERS)}")
        return column.times, np.array([column.value(row) for row in range(len(column))], dtype=np.float64)

    def snapshot_at(self, time: float) -> Snapshot:
        """Return a snapshot with the newest value of each key at or before a time [s].

        Keys without a value before the time, and keys of types that `Snapshot` does not have, are missing.
        """
        found: dict[str, dict[str, Any]] = {name: {} for name, _ in _TYPES.values()}
        for key, column in self.columns.items():
            (row,) = column.rows_at(np.array([time])).tolist()
            if row >= 0 and column.field is not None:
                found[column.field][key] = column.value(row)
        return Snapshot(time=time, tick=0, **found)


class _Entry:
    """Values of one key that `read_log` has found so far, each with timestamp, offset in the file and size."""

    __slots__ = ("key", "metadata", "micros", "places", "sizes", "type")

    def __init__(self, key: str, kind: str, metadata: str = "") -> None:
        self.key, self.type, self.metadata = key, kind, metadata
        self.micros: list[int] = []
        self.places: list[int] = []
        self.sizes: list[int] = []


def read_log(path: str | Path) -> TelemetryLog:
    """Read a `.wpilog` or `.wpilogxz` file, even if the file ends in the middle of a record.

    Raises:
        LogError: If the file cannot be read, is not a data log of format 1.x, or contains no entry.
    """
    path = Path(path)
    try:
        data = path.read_bytes()
        if data.startswith(_XZ):
            data = lzma.LZMADecompressor().decompress(data)  # also decompresses the existing part of a cut-off file
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
    return TelemetryLog(path, {entry.key: _column(entry, data) for entry in entries}, ends_early)


def _scan(data: bytes, at: int) -> tuple[list[_Entry], bool]:
    """Return the entries in a log, and whether the log ends with an incomplete or invalid record.

    Args:
        data: Contents of the log file.
        at: Offset of the first record.
    """
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
    """Start or finish the entry that a control record names; return False for an invalid control record.

    Args:
        record: Payload of the control record.
        open_entries: Started entries by entry ID, changed in place.
        by_key: All entries by key, changed in place.
    """
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
        known = by_key.setdefault(key, _Entry(key, kind, texts[2]))
        if known.type == kind:  # a key that changes type keeps its first type
            open_entries[entry] = known
    return True


def _column(entry: _Entry, data: bytes) -> LogColumn:
    micros = np.array(entry.micros, dtype=np.int64)
    places, sizes = entry.places, entry.sizes
    if len(micros) and (np.diff(micros) < 0).any():  # in AdvantageKit's logs and in merged logs
        order = np.argsort(micros, kind="stable")
        micros = micros[order]
        places, sizes = [places[i] for i in order], [sizes[i] for i in order]
    times: FloatArray = micros.astype(np.float64) * 1e-6
    return LogColumn(entry.key, entry.type, times, data, places, sizes, entry.metadata)
