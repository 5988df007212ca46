"""Record of the NetworkTables tables that a robot program uses.

NetworkTables contains no entry for a table that a program only reads. This module therefore wraps the ntcore functions
that look up a table or topic, and searches the modules that Python has already loaded.
"""

from __future__ import annotations

import functools
import sys
from pathlib import Path
from typing import Any

from simcore import season

ntcore = season.ntcore

__all__ = ["TableWatch", "table_watch"]


class TableWatch:
    """Record of the top-level names of the tables and topics that a program has looked up."""

    def __init__(self) -> None:
        self.names: dict[str, None] = {}
        cls = ntcore.NetworkTableInstance
        names = {season.own_name(cls, name) for name in ("get_table", "get_entry")}
        for method in sorted({*names, *(n for n in dir(cls) if n.startswith("get") and n.lower().endswith("topic"))}):
            setattr(cls, method, self._noting(getattr(cls, method)))

    def search(self, folder: Path) -> None:
        """Record the tables in module variables and class attributes of a project's loaded modules.

        Args:
            folder: Folder of the project.
        """
        for module in list(sys.modules.values()):
            names = getattr(module, "__dict__", {})  # getattr for other names could trigger a lazy module's import
            file = names.get("__file__")
            if not isinstance(file, str) or "site-packages" in file or not Path(file).is_relative_to(folder):
                continue
            for value in list(names.values()):
                self._note_owned(value)
                if isinstance(value, type):
                    for part in list(vars(value).values()):
                        self._note_owned(part)

    def _note(self, name: str) -> None:
        first = name.strip("/").split("/", 1)[0]
        if first:
            self.names.setdefault(first)

    def _note_owned(self, value: Any) -> None:
        if isinstance(value, ntcore.NetworkTable):
            self._note(value.get_path())
        elif isinstance(value, ntcore.NetworkTableEntry):
            self._note(value.get_name())
        elif isinstance(value, ntcore.Subscriber):
            self._note(value.get_topic().get_name())

    def _noting(self, method: Any) -> Any:
        @functools.wraps(method)
        def get(instance: Any, *args: Any, **kwargs: Any) -> Any:
            for name in (*args[:1], *kwargs.values()):
                if isinstance(name, str):
                    self._note(name)
            return method(instance, *args, **kwargs)

        return get


_watch: TableWatch | None = None


def table_watch() -> TableWatch:
    """Return the table watch of this process. The first call starts the recording."""
    global _watch
    if _watch is None:
        _watch = TableWatch()
    return _watch
