"""Reads TOML tables strictly: every key is asked for once, and a key that is not asked for is a mistake."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

from simcore.errors import ConfigError, nearest
from simcore.quantities import shown

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["REQUIRED", "Table", "nearest", "read_tables", "read_toml"]

REQUIRED: Any = object()
"""Default of a key that must be there."""
_MOST_BYTES, _MOST_DOTS = 100_000, 100  # a whole robot takes 5 kB and two dots; the parser is slow in what is nested


def read_tables(path: Path) -> Table:
    """The whole file as one table; see `read_toml`."""
    return Table(read_toml(path), path.name)


def read_toml(path: Path) -> dict[str, Any]:
    """What is in a file.

    Raises:
        ConfigError: It cannot be read, or is no TOML; the message has the line.
    """
    try:
        size = path.stat().st_size
        if size > _MOST_BYTES:
            raise ConfigError(f"{path.name}: must be a text of at most {_MOST_BYTES} bytes, got {size}")
        text = path.read_text(encoding="utf-8-sig")  # Windows editors begin a file with a byte order mark
        for number, line in enumerate(text.splitlines(), 1):
            if line.count(".") > _MOST_DOTS:
                raise ConfigError(f"{path.name}: line {number} is nested too deep: a key with over {_MOST_DOTS} dots")
        return tomllib.loads(text)
    except OSError as error:
        raise ConfigError(f"{path.name}: cannot be read ({error.strerror})") from error
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path.name}: is not UTF-8 text; save it as UTF-8") from error
    except tomllib.TOMLDecodeError as error:
        comma = re.search(r"^[^#\"'\[]*=\s*(\d+),(\d+)\s*(#.*)?$", text, re.MULTILINE)
        hint = f"; decimals take a point: {comma[1]}.{comma[2]}" if comma else ""
        raise ConfigError(f"{path.name}: is no valid TOML: {error}{hint}") from error
    except RecursionError as error:
        raise ConfigError(f"{path.name}: is nested too deep: lists or tables in each other") from error
    except ConfigError:
        raise
    except ValueError as error:  # the parser hands numbers to int(), which refuses thousands of digits
        raise ConfigError(f"{path.name}: has a number that is too long ({error})") from error


class Table:
    """One table of a file; `Key` reads the values in it.

    Args:
        data: As the TOML parser gives it.
        where: How messages call it, e.g. `simcore.toml [robot]`.

    >>> robot = Table({"bumbers": 1}, "simcore.toml [robot]")
    >>> robot.value("bumpers", 0.8, "a length")
    0.8
    >>> robot.finish()
    Traceback (most recent call last):
    simcore.errors.ConfigError: simcore.toml [robot]: no key 'bumbers'. Did you mean 'bumpers'? Known: bumpers
    """

    def __init__(self, data: dict[str, Any], where: str) -> None:
        self._data = data
        self.where = where
        self._asked: list[str] = []

    def error(self, key: str, problem: str) -> ConfigError:
        """The error to raise about a key."""
        return ConfigError(f"{self.where}: {key} {problem}")

    def __contains__(self, key: str) -> bool:
        return key in self._data

    def value(self, key: str, default: Any, wanted: str) -> Any:
        """The value of a key, of whatever type.

        Args:
            key: Its name.
            default: If it is not there; with `REQUIRED` it must be.
            wanted: What it must be, for the message.
        """
        self._asked.append(key)
        if key not in self._data and default is REQUIRED:
            raise self.error(key, f"is missing; it must be {wanted}")
        return self._data.get(key, default)

    def table(self, key: str) -> Table | None:
        """A table in this one, or None."""
        value = self.value(key, None, "")
        if value is None:
            return None
        if not isinstance(value, dict):
            raise self.error(key, f"must be a table, written [{key}] on a line of its own; got {shown(value)}")
        return Table(value, f"{self.where} [{key}]")

    def tables(self, key: str) -> list[Table]:
        """The tables of a list of tables; each is called by its name, where it has one."""
        value = self.value(key, [], "")
        if not (isinstance(value, list) and all(isinstance(v, dict) for v in value)):
            raise self.error(key, f"must be tables, each under a line [[{key}]]; got {shown(value)}")
        return [Table(v, f"{self.where} [[{key}]] {v.get('name', number)!r}") for number, v in enumerate(value, 1)]

    def table_or_tables(self, key: str) -> list[Table]:
        """A single table `[key]`, or the tables of a list `[[key]]`; none if there is neither."""
        value = self._data.get(key)
        if isinstance(value, dict):
            self._asked.append(key)
            return [Table(value, f"{self.where} [{key}]")]
        return self.tables(key)

    def named_tables(self, key: str) -> dict[str, Table]:
        """The tables in a table, by their names: `[autos."Left"]` is one of `autos`."""
        table = self.table(key)
        if table is None:
            return {}
        tables = {}
        for name, value in table._data.items():
            if not isinstance(value, dict):
                line = f"[{key}.{name!r}]"
                raise table.error(name, f"must be a table, written {line} on a line of its own; got {shown(value)}")
            tables[name] = Table(value, f"{self.where} [{key}.{name!r}]")
        return tables

    def finish(self) -> None:
        """Say that all keys have been asked for.

        Raises:
            ConfigError: The file has one that was not.
        """
        for key in self._data:
            if key not in self._asked:
                known = sorted(self._asked)
                raise ConfigError(f"{self.where}: no key {key!r}.{nearest(key, known)} Known: {', '.join(known)}")
