"""Where rows of runs are kept: an SQLite file that each row is written to as it comes, so that a sweep can go on."""

from __future__ import annotations

import json
import logging
import sqlite3
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from simcore.errors import ConfigError, OutputError
from simcore.sweep.experiment import Experiment

__all__ = ["FILE_NAME", "RunStore"]

FILE_NAME = "runs.sqlite"
_TABLES = """
CREATE TABLE IF NOT EXISTS experiment (number INTEGER PRIMARY KEY, description TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS runs (key TEXT PRIMARY KEY, error TEXT NOT NULL, row TEXT NOT NULL);
"""
_log = logging.getLogger(__name__)
_AT_ONCE = 500  # names in one question; SQLite allows 999 in its oldest versions
_BUSY = 30.0  # [s]; another sweep may be writing to the same file


class RunStore:
    """Rows by the keys of their runs, and the experiment that was played last.

    A disk that is full, or a file that cannot be written any more, stops no sweep: rows stay in memory, are tried again
    with each further one, and a warning says so.

    Args:
        folder: Of the file; made if it is not there.
        must_exist: Refuse a folder without the file.

    Raises:
        OutputError: It cannot be made or read.
    """

    def __init__(self, folder: Path, *, must_exist: bool = False) -> None:
        self.path = folder / FILE_NAME
        if must_exist and not self.path.is_file():
            raise OutputError(f"{folder}: there are no runs in it: no file {FILE_NAME}")
        self._problem = ""  # why the last row could not be written
        self._unsaved: dict[str, tuple[str, str]] = {}
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._base = sqlite3.connect(self.path, timeout=_BUSY, isolation_level=None)
            self._base.execute("PRAGMA synchronous = NORMAL")
            self._base.executescript(_TABLES)
        except (OSError, sqlite3.Error) as error:
            raise OutputError(f"{self.path} cannot be written: {_reason(error)}") from error

    def close(self) -> None:
        """Write what could not be written before, and close."""
        self._write()
        self._base.close()
        if self._unsaved:
            _log.warning("%s: %d runs are not in it", self._problem, len(self._unsaved))

    def set_experiment(self, experiment: Experiment) -> None:
        """Keep what is played, in place of what was played before."""
        try:
            self._base.execute("INSERT OR REPLACE INTO experiment VALUES (0, ?)", (json.dumps(experiment.to_json()),))
        except sqlite3.Error as error:
            raise OutputError(f"{self.path} cannot be written: {_reason(error)}") from error

    def experiment(self) -> Experiment:
        """The last that was played.

        Raises:
            ConfigError: There is none.
        """
        found = self._base.execute("SELECT description FROM experiment").fetchone()
        if found is None:
            raise ConfigError(f"{self.path} has no experiment in it")
        return Experiment.from_json(json.loads(found[0]))

    def add(self, key: str, row: dict[str, Any]) -> None:
        """Keep the row of a run; it replaces one of the same key."""
        self._unsaved[key] = (row["error"], json.dumps(row))
        self._write()

    def rows(self, keys: Sequence[str]) -> dict[str, dict[str, Any]]:
        """Those of these runs that are there and have not failed, by key."""
        found: dict[str, dict[str, Any]] = {}
        for start in range(0, len(keys), _AT_ONCE):
            some = keys[start : start + _AT_ONCE]
            marks = ",".join("?" * len(some))
            cursor = self._base.execute(f"SELECT key, row FROM runs WHERE error = '' AND key IN ({marks})", some)
            found.update((key, json.loads(row)) for key, row in cursor)
        return found

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
                self._problem = f"{self.path} cannot be written: {_reason(error)}"
                _log.warning("%s; the runs go on, and are kept in memory", self._problem)
            if self._base.in_transaction:
                self._base.execute("ROLLBACK")
        else:
            self._problem = ""
            self._unsaved.clear()


def _reason(error: Exception) -> str:
    return str(getattr(error, "strerror", None) or error)
