"""Reads TOML tables strictly: every key is asked for once, and what nobody asked for is a mistake."""

from __future__ import annotations

import difflib
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from simcore.errors import ConfigError
from simcore.quantities import Quantity, Row, require, require_row, row_text, shown

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["Table", "read_tables"]

_REQUIRED: Any = object()
_MOST_BYTES, _MOST_DOTS = 100_000, 100  # a whole robot takes 5 kB and two dots; the parser is slow in what is nested


def read_tables(path: Path) -> Table:
    """The whole file as one table.

    Raises:
        ConfigError: It cannot be read, or is no TOML; the message has the line.
    """
    try:
        size = path.stat().st_size
        if size > _MOST_BYTES:
            raise ConfigError(f"{path.name}: must be a text of at most {_MOST_BYTES} bytes, got {size}")
        text = path.read_text(encoding="utf-8")
        for number, line in enumerate(text.splitlines(), 1):
            if line.count(".") > _MOST_DOTS:
                raise ConfigError(f"{path.name}: line {number} is nested too deep: a key with over {_MOST_DOTS} dots")
        data = tomllib.loads(text)
    except OSError as error:
        raise ConfigError(f"{path.name}: cannot be read ({error.strerror})") from error
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path.name}: is not UTF-8 text; save it as UTF-8") from error
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{path.name}: is no valid TOML: {error}") from error
    except RecursionError as error:
        raise ConfigError(f"{path.name}: is nested too deep: lists or tables in each other") from error
    except ValueError as error:  # the parser hands numbers to int(), which refuses thousands of digits
        raise ConfigError(f"{path.name}: has a number that is too long ({error})") from error
    return Table(data, path.name)


class Table:
    """One table of a file.

    Args:
        data: As the TOML parser gives it.
        where: How messages call it, e.g. `simcore.toml [robot]`.

    >>> from simcore.quantities import MASS, ROBOT_LENGTH
    >>> robot = Table({"mass": -3, "bumbers": 1}, "simcore.toml [robot]")
    >>> robot.number("mass", MASS)
    Traceback (most recent call last):
    simcore.errors.ConfigError: simcore.toml [robot]: mass must be a number above 0 and up to 1000 kg, got -3
    >>> _ = robot.number("bumpers", ROBOT_LENGTH, 0.8)
    >>> robot.finish()
    Traceback (most recent call last):
    simcore.errors.ConfigError: simcore.toml [robot]: no key 'bumbers'. Did you mean 'bumpers'? Known: bumpers, mass
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

    def number(self, key: str, quantity: Quantity, default: Any = _REQUIRED) -> Any:
        """A number.

        Args:
            key: Its name.
            quantity: What it may be.
            default: If it is not there; without one it must be.

        >>> from simcore.quantities import ROBOT_PLACE
        >>> Table({"x_min": -24}, "simcore.toml [intake]").number("x_min", ROBOT_PLACE)
        Traceback (most recent call last):
        simcore.errors.ConfigError: simcore.toml [intake]: x_min must be a number from -3 to 3 m, got -24. As inches \
that is -0.61 m
        """
        value = self._value(key, default, str(quantity))
        if key not in self._data:
            return value
        require(self.where, key, value, quantity)
        return float(value)

    def whole(self, key: str, default: Any = _REQUIRED, *, least: int = 0, most: int = 2**31) -> Any:
        """A whole number, e.g. a CAN id."""
        wanted = f"a whole number from {least} to {most}"
        value = self._value(key, default, wanted)
        if key in self._data and not (type(value) is int and least <= value <= most):
            raise self.error(key, f"must be {wanted}, got {shown(value)}")
        return value

    def wholes(self, key: str, *, least: int = 0, most: int = 2**31) -> tuple[int, ...]:
        """A list of whole numbers; empty if it is not there."""
        wanted = f"a list of whole numbers from {least} to {most}, e.g. [21, 22]"
        value = self._value(key, [], wanted)
        if not (isinstance(value, list) and all(type(v) is int and least <= v <= most for v in value)):
            raise self.error(key, f"must be {wanted}, got {shown(value)}")
        return tuple(value)

    def one_or_more_wholes(self, key: str, *, least: int = 0, most: int = 2**31) -> tuple[int, ...]:
        """A whole number, or a list of one or more."""
        value = self._value(key, _REQUIRED, "")
        values = value if isinstance(value, list) else [value]
        if not (values and all(type(v) is int and least <= v <= most for v in values)):
            raise self.error(
                key,
                f"must be a whole number from {least} to {most}, or a list of such, e.g. [0, 1]; got {shown(value)}",
            )
        return tuple(values)

    def is_list(self, key: str) -> bool:
        """Whether a list is written there."""
        return isinstance(self._data.get(key), list)

    def numbers(self, key: str, row: Row, default: Any = _REQUIRED) -> tuple[float, ...]:
        """A list of numbers.

        Args:
            key: Its name.
            row: What they may be: as many as there are quantities, or for a list of one quantity one or more.
            default: If it is not there; without one it must be.
        """
        value = self._value(key, default, row_text(row))
        if not (isinstance(value, list | tuple) and value):
            raise self.error(key, f"must be {row_text(row)}, got {shown(value)}")
        require_row(self.where, key, value, row)
        return tuple(float(v) for v in value)

    def flag(self, key: str, default: bool) -> bool:
        """True or false."""
        value = self._value(key, default, "true or false")
        if not isinstance(value, bool):
            raise self.error(key, f"must be true or false, got {shown(value)}")
        return value

    def text(self, key: str, default: Any = _REQUIRED) -> Any:
        """A text of letters that can be seen."""
        value = self._value(key, default, "a text in quotes")
        if key in self._data and not (isinstance(value, str) and value.strip() and value.isprintable()):
            raise self.error(key, f"must be a text in quotes, got {shown(value)}")
        return value

    def choice(self, key: str, known: Sequence[str], default: Any = _REQUIRED) -> Any:
        """One of a closed set of names."""
        value = self.text(key, default)
        if key in self._data and value not in known:
            raise self.error(key, f"must be one of {', '.join(known)}, got {shown(value)}.{_nearest(value, known)}")
        return value

    def texts(self, key: str) -> tuple[str, ...]:
        """A text that is not empty, or a list of such; empty if it is not there."""
        value = self._value(key, [], "")
        texts = value if isinstance(value, list) else [value]
        if not all(isinstance(v, str) and v.strip() for v in texts) or (key in self._data and not texts):
            raise self.error(key, f"must be a text in quotes, or a list of such; got {shown(value)}")
        return tuple(texts)

    def choices(self, key: str, known: Sequence[str]) -> tuple[str, ...]:
        """One or more of a closed set of names: a text, or a list of texts."""
        texts = self.texts(key)
        if key not in self._data:
            raise self.error(key, f"is missing; it must be one or more of {', '.join(known)}")
        for value in texts:
            if value not in known:
                raise self.error(key, f"must be one of {', '.join(known)}, got {shown(value)}.{_nearest(value, known)}")
        return texts

    def table(self, key: str) -> Table | None:
        """A table in this one, or None."""
        value = self._value(key, None, "")
        if value is None:
            return None
        if not isinstance(value, dict):
            raise self.error(key, f"must be a table, written [{key}] on a line of its own; got {shown(value)}")
        return Table(value, f"{self.where} [{key}]")

    def tables(self, key: str) -> list[Table]:
        """The tables of a list of tables; each is called by its name, where it has one."""
        value = self._value(key, [], "")
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
                raise ConfigError(f"{self.where}: no key {key!r}.{_nearest(key, known)} Known: {', '.join(known)}")

    def _value(self, key: str, default: Any, wanted: str) -> Any:
        self._asked.append(key)
        if key in self._data:
            return self._data[key]
        if default is _REQUIRED:
            raise self.error(key, f"is missing; it must be {wanted}")
        return default


def _nearest(value: str, known: Sequence[str]) -> str:
    near = difflib.get_close_matches(value, known, n=1, cutoff=0.5)
    return f" Did you mean {near[0]!r}?" if near else ""
