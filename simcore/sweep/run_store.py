"""SQLite store that writes each row of a sweep at the end of the run, so an interrupted sweep can resume.

`PRAGMA user_version` is the version of the tables. The table `experiment` contains the last experiment. The table
`runs` contains a row for each run, with a key from `Experiment.run_keys`.
"""

from __future__ import annotations

import json
import logging
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from simcore.errors import ConfigError, OutputError, UnknownNameError
from simcore.sweep.experiment import Experiment, programs_outside

__all__ = ["FILE_NAME", "VERSION", "RunStore"]

FILE_NAME = "runs.sqlite"
VERSION = 2
"""Version of the table format; `RunStore` refuses a file of another version."""
_TABLES = (
    "CREATE TABLE experiment (number INTEGER PRIMARY KEY, description TEXT NOT NULL)",
    "CREATE TABLE runs (key TEXT PRIMARY KEY, error TEXT NOT NULL, row TEXT NOT NULL)",
    f"PRAGMA user_version = {VERSION}",
)
_COLUMNS: dict[str, type | tuple[type, ...]] = {
    "run": int, "point": int, "seed": int, "version": str, "error": str, "cpu_seconds": (int, float)
}  # fmt: skip
"""Columns that every row has, with the types of the values."""
_log = logging.getLogger(__name__)
_AT_ONCE = 500  # keys per query; old versions of SQLite allow 999
_BUSY = 30.0  # [s]; longest wait while another sweep writes to the file


class RunStore:
    """SQLite file with the row of each run, by key, and with the last experiment.

    If a row cannot be written, for example because the disk is full, the sweep goes on. The store logs a warning, keeps
    the rows in memory, and tries to write the rows again with each new row.

    Args:
        folder: Folder of the file `runs.sqlite`; a missing folder is created.
        must_exist: Whether to raise an error instead of creating a missing file.

    Raises:
        OutputError: If the file is missing or cannot be created, or is not a store of this version.
    """

    def __init__(self, folder: Path, *, must_exist: bool = False) -> None:
        self.path = folder / FILE_NAME
        if must_exist and not self.path.is_file():
            raise OutputError(f"{folder}: there are no runs in it: no file {FILE_NAME}")
        self._problem = ""  # reason why the last row could not be written
        self._unsaved: dict[str, tuple[str, str]] = {}
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._base = sqlite3.connect(self.path, timeout=_BUSY, isolation_level=None)
        except (OSError, sqlite3.Error) as error:
            raise self._unwritable(error) from error
        try:
            with self._reading():
                self._base.execute("PRAGMA synchronous = NORMAL")
                is_new = self._version() == 0 and not self._has_tables()
            if is_new:
                self._make()
            with self._reading():
                if self._version() != VERSION:
                    raise ValueError(f"its tables have version {self._version()}, not {VERSION}")
                self._base.execute("SELECT number, description FROM experiment").fetchone()
                self._base.execute("SELECT key, error, row FROM runs").fetchone()
        except BaseException:
            self._base.close()
            raise

    def close(self) -> None:
        """Write the remaining rows and close the file; log a warning if rows could not be written."""
        self._write()
        self._base.close()
        if self._unsaved:
            _log.warning("%s: %d runs are not in it", self._problem, len(self._unsaved))

    def set_experiment(self, experiment: Experiment) -> None:
        """Replace the stored experiment by another experiment.

        Raises:
            OutputError: If the file cannot be written.
        """
        row = (json.dumps(experiment.to_json()),)
        try:
            self._base.execute("INSERT OR REPLACE INTO experiment VALUES (0, ?)", row)
        except sqlite3.Error as error:
            raise self._unwritable(error) from error

    def experiment(self) -> Experiment:
        """Return the last stored experiment.

        Log a warning if the experiment would run programs outside the current folder.

        Raises:
            ConfigError: If the experiment can no longer be played.
            OutputError: If the file is damaged or has no experiment.
        """
        with self._reading():
            found = self._base.execute("SELECT description FROM experiment").fetchone()
            if found is None:
                raise ValueError("there is no experiment in it")
            data = json.loads(found[0])
            if programs := programs_outside(data, Path.cwd()):
                _log.warning("%s runs code outside of the current folder: %s", self.path, ", ".join(programs))
            return Experiment.from_json(data)

    def add(self, key: str, row: dict[str, Any]) -> None:
        """Store the row of a run, and replace an earlier row with the same key.

        If the file cannot be written, keep the row in memory.
        """
        self._unsaved[key] = (row["error"], json.dumps(row))
        self._write()

    def rows(self, keys: Sequence[str]) -> dict[str, dict[str, Any]]:
        """Return the stored rows of successful runs with these keys, by key.

        Raises:
            OutputError: If the file is damaged.
        """
        found: dict[str, dict[str, Any]] = {}
        with self._reading():
            for start in range(0, len(keys), _AT_ONCE):
                some = keys[start : start + _AT_ONCE]
                marks = ",".join("?" * len(some))
                cursor = self._base.execute(f"SELECT key, row FROM runs WHERE error = '' AND key IN ({marks})", some)
                found.update((key, _checked(json.loads(row))) for key, row in cursor)
        return found

    def _version(self) -> int:
        return int(self._base.execute("PRAGMA user_version").fetchone()[0])

    def _has_tables(self) -> bool:
        return bool(self._base.execute("SELECT count(*) FROM sqlite_master").fetchone()[0])

    def _make(self) -> None:
        try:
            self._base.execute("BEGIN IMMEDIATE")
            if not self._has_tables():  # otherwise another sweep has made them
                for command in _TABLES:
                    self._base.execute(command)
            self._base.execute("COMMIT")
        except sqlite3.Error as error:
            raise self._unwritable(error) from error

    @contextmanager
    def _reading(self) -> Iterator[None]:
        """Raise errors of reading in the block again as a `ConfigError` or `OutputError` that names the file."""
        try:
            yield
        except (ConfigError, UnknownNameError) as error:  # before ValueError and LookupError, which they also are
            raise ConfigError(f"{self.path}: its experiment can no longer be played: {error}") from error
        except (sqlite3.Error, ValueError, TypeError, LookupError, AttributeError, RecursionError) as error:
            raise OutputError(
                f"{self.path} is damaged or of another version of simcore ({_reason(error)}): choose another folder, "
                "or delete the file, and play the sweep again"
            ) from error

    def _unwritable(self, error: Exception) -> OutputError:
        return OutputError(f"{self.path} cannot be written: {_reason(error)}")

    def _write(self) -> None:
        rows = [(key, error, row) for key, (error, row) in self._unsaved.items()]
        if not rows:
            return
        try:
            self._base.execute("BEGIN IMMEDIATE")
            self._base.executemany("INSERT OR REPLACE INTO runs VALUES (?, ?, ?)", rows)
            self._base.execute("COMMIT")
        except sqlite3.Error as error:
            if not self._problem:
                self._problem = str(self._unwritable(error))
                _log.warning("%s; the runs go on, and are kept in memory", self._problem)
            if self._base.in_transaction:
                self._base.execute("ROLLBACK")
        else:
            self._problem = ""
            self._unsaved.clear()


def _checked(row: Any) -> dict[str, Any]:
    """Check the format of a stored row, and return the row unchanged.

    Raises:
        ValueError: If the row does not have the format of this version.
    """
    if not isinstance(row, dict):
        raise ValueError("a run is not a row")
    for name, kind in _COLUMNS.items():
        if not isinstance(row.get(name), kind):
            raise ValueError(f"a run has no {name}")
    if not all(value is None or isinstance(value, (str, int, float)) for value in row.values()):
        raise ValueError("a run has a value that is neither a number nor a word")
    return row


def _reason(error: Exception) -> str:
    if isinstance(error, KeyError):
        return f"it has no {error}"
    return " ".join(str(getattr(error, "strerror", None) or error).split())
