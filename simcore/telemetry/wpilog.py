"""A `.wpilog` file of a run, for AdvantageScope and every other reader of WPILib's data log format.

The format (version 1.0) is written here, in a page of code, because no writer of WPILib 2026.2.2 fits a simulation:

* `wpiutil.DataLogWriter` takes our timestamps and files, but hangs for good once about 0.5 MB was appended between
  two flushes (fixed later, allwpilib #9258), and stamps wall time where the simulated time is 0.
* `wpilib.DataLogManager` is one per process, stamps wall time and does not overwrite files.

Source: https://github.com/wpilibsuite/allwpilib/blob/main/wpiutil/doc/datalog.adoc; tests read every log back with
WPILib's own `DataLogReader`.
"""

from __future__ import annotations

import contextlib
import io
import lzma
import struct
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType

from simcore.errors import ConfigError, OutputError
from simcore.telemetry.sinks import Cadence, output_error
from simcore.telemetry.snapshot import (
    POSE_ARRAY_TYPE,
    POSE_SCHEMAS,
    POSE_TYPE,
    SCHEMA_TYPE,
    Snapshot,
    checked_integers,
    is_bulk,
    pose_array_bytes,
    pose_bytes,
)
from simcore.typing import FloatArray, IntArray

__all__ = ["WpilogSink"]

_FLUSH_BYTES = 256 * 1024
_FLUSH_MICROS = 1_000_000
_MAX_TIME = 1e9  # [s], 31 years

# Lengths inside a record may be packed to 1-4 (timestamp 1-8) bytes each. Scalars use the short form; fixed layouts
# keep a record at one `pack` call. First byte: entry length - 1, size length - 1 (<< 2), timestamp length - 1 (<< 4).
_SHORT = struct.Struct("<BHBQ")  # entry < 65 536, payload < 256 bytes
_SHORT_HEAD = 0b0_111_00_01
_LONG = struct.Struct("<BHIQ")  # payload < 4 GiB
_LONG_HEAD = 0b0_111_11_01
_DOUBLE = struct.Struct("<d")
_INT64 = struct.Struct("<q")
_BOOLEAN = struct.Struct("<?")


class WpilogSink:
    """Writes snapshots to a `.wpilog`; entries are named as DataLogManager names NetworkTables keys.

    A value is written only when it changed, as the format intends. Long arrays (450 poses are 25 KB) are
    written less often than the rest: at every tick they alone would be 200 MB of a match. What was written reaches the
    disk at least every simulated second or 256 KB, in whole records, so a killed run leaves a good log.
    """

    def __init__(
        self, path: str | Path, *, period: float = 0.02, bulk_period: float = 0.08, prefix: str = "NT:/"
    ) -> None:
        """Create the file, its missing folders and the schemas; a file of that name is overwritten.

        Args:
            path: Where the log goes, by custom `*.wpilog`; `*.wpilogxz` is compressed, an eighth in size.
            period: Simulated time between two snapshots [s].
            bulk_period: The same for arrays of more than 64 rows [s].
            prefix: Put before every key. With the default one AdvantageScope layout serves live and log.

        Raises:
            OutputError: The file cannot be written.
            ConfigError: The period is not finite and > 0.
        """
        self.path = Path(path)
        self.prefix = prefix
        self._cadence = Cadence(period)
        self._bulk_cadence = Cadence(bulk_period)
        self._buffer = bytearray()
        self._flushed_at = 0  # [us]
        self._types: dict[str, str] = {}
        self._entries: dict[str, int] = {}
        self._values: dict[str, bytes] = {}
        self._arrays: dict[str, FloatArray | IntArray] = {}  # last written, by key: the same object is not looked into
        self._numbers: dict[str, dict[str, float]] = {"double": {}, "int64": {}, "boolean": {}}  # by type, by key
        self._packer = lzma.LZMACompressor(preset=1) if self.path.suffix == ".wpilogxz" else None
        self._file: io.FileIO | None = None
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._file = io.FileIO(self.path, "w")
        except OSError as error:
            raise output_error("log", self.path, error) from error
        self._buffer += b"WPILOG" + struct.pack("<HI", 0x0100, 0)
        for name, schema in POSE_SCHEMAS.items():
            entry = self._start(f".schema/{name}", SCHEMA_TYPE, 0)
            self._append(entry, schema.encode(), 0)
        self._flush(0)

    @property
    def closed(self) -> bool:
        """Whether nothing more is written."""
        return self._file is None

    def due(self, time: float) -> bool:
        """Whether a snapshot of this simulated time [s] is wanted; never after `close`."""
        return self._file is not None and self._cadence.due(time)

    def write(self, snapshot: Snapshot) -> None:
        """Log one snapshot at its simulated time.

        Raises:
            OutputError: The log is closed, or the disk cannot be written (full, unplugged); the log is closed then.
            ConfigError: An array of the wrong shape, a key that had another type before, or a time below 0.
        """
        if self._file is None:
            raise OutputError(f"the log {str(self.path)!r} is closed; create a new WpilogSink to log on")
        if not 0.0 <= snapshot.time < _MAX_TIME:
            raise ConfigError(f"a snapshot needs a finite time >= 0 s, got {snapshot.time}")
        micros = round(snapshot.time * 1e6)
        self._cadence.take(snapshot.time)
        bulk = self._bulk_cadence.take(snapshot.time)
        for key, pose in snapshot.poses.items():
            self._append_changed(key, POSE_TYPE, pose_bytes(key, pose), micros)
        for key, poses in snapshot.pose_arrays.items():
            if bulk or not is_bulk(key, len(poses)) or key not in self._entries:
                if not self._is_same(key, poses):
                    self._append_changed(key, POSE_ARRAY_TYPE, pose_array_bytes(key, poses), micros)
        self._write_numbers("double", snapshot.doubles, _DOUBLE, micros)
        self._write_numbers("int64", snapshot.integers, _INT64, micros)
        self._write_numbers("boolean", snapshot.booleans, _BOOLEAN, micros)
        for key, text in snapshot.strings.items():
            self._append_changed(key, "string", text.encode(), micros)
        for key, integers in snapshot.integer_arrays.items():  # with the poses of the same rows, in the same ticks
            if bulk or not is_bulk(key, len(integers)) or key not in self._entries:
                if not self._is_same(key, integers):
                    self._append_changed(key, "int64[]", checked_integers(key, integers).tobytes(), micros)
        if len(self._buffer) >= _FLUSH_BYTES or abs(micros - self._flushed_at) >= _FLUSH_MICROS:
            self._flush(micros)

    def close(self) -> None:
        """Write what is left and close the file; may be called twice.

        Raises:
            OutputError: The rest cannot be written.
        """
        if self._file is None:
            return
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

    def _write_numbers(self, type_name: str, numbers: Mapping[str, float], packer: struct.Struct, micros: int) -> None:
        written, values, is_real = self._numbers[type_name], self._values, type_name == "double"
        for key, number in numbers.items():
            if written.get(key) == number and (number or not is_real):
                continue
            payload = packer.pack(number)
            # Of those left, bytes are compared: NaN equals itself then, and -0.0 is not 0.0.
            if key not in written or values[key] != payload:
                entry = self._entry(key, type_name, micros)
                values[key] = payload
                self._buffer += _SHORT.pack(_SHORT_HEAD, entry, len(payload), micros) + payload
            written[key] = number

    def _is_same(self, key: str, rows: FloatArray | IntArray) -> bool:
        """Whether this very array is what was written last, so that its bytes need not be compared."""
        if not rows.flags.writeable and self._arrays.get(key) is rows:
            return True
        self._arrays[key] = rows
        return False

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
        self._buffer += _LONG.pack(_LONG_HEAD, entry, len(payload), micros)
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
