"""Definitions of the keys of `simcore.toml`, shared by reader, error messages, template and documentation.

An unknown key in a table is an error.
"""

from __future__ import annotations

import difflib
import json
import math
import re
import sys
import textwrap
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from simcore.errors import ConfigError, nearest
from simcore.quantities import DeviceAddress, Quantity, Row, require, require_row, row_text, shown

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = [
    "REQUIRED", "Form", "Key", "KeyTable", "Named", "Names", "Several", "Table", "comment_line", "read_toml",
    "table_text", "toml",
]  # fmt: skip

REQUIRED: Any = object()
"""Marker for the default of a required key."""


_MEANT = {
    **{"wheel_radius": "wheel_diameter", "weight": "mass", "moi": "inertia", "inverted": "reversed"},
    **dict.fromkeys(("ratio", "gear_ratio", "reduction"), "gearing"),
    **dict.fromkeys(("id", "can_id", "motor_id"), "leader"),
}
"""Correct key for each common wrong name that differs too much in spelling for an automatic suggestion."""


def read_toml(path: Path) -> dict[str, Any]:
    """Return the values in a TOML file.

    Raises:
        ConfigError: The file cannot be read or is not valid TOML; the message names the line of invalid TOML.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")  # some Windows editors write a byte order mark
        return tomllib.loads(text)
    except OSError as error:
        raise ConfigError(f"{path.name}: cannot be read ({error.strerror})") from error
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path.name}: is not UTF-8 text; save it as UTF-8") from error
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{path.name}: is not valid TOML: {error}{_toml_hint(text)}") from error


def _toml_hint(text: str) -> str:
    r"""Return a hint about a common mistake in a text that is not valid TOML; empty if no mistake is recognized.

    >>> _toml_hint("mass = 52,5  # weighed"), _toml_hint("mass = 52 kg"), _toml_hint("real = True")
    ('; decimals take a point: 52.5', "; leave out the unit: 52 in place of '52 kg'", '; write true with a small t')
    >>> _toml_hint('name = "feeder')
    '; a quote is not closed: name = "feeder'
    >>> _toml_hint("[sensor]\nid = 1\n[sensor]\nid = 2")
    '; a table that comes several times needs two brackets: [[sensor]]'
    """
    value = r"^[^#\"'\[]*=\s*%s\s*(?:#.*)?$"
    if comma := re.search(value % r"(\d+),(\d+)", text, re.MULTILINE):
        return f"; decimals take a point: {comma[1]}.{comma[2]}"
    if unit := re.search(value % r"(([-\d.]+)\s*[a-zA-Z%\"']+)", text, re.MULTILINE):
        return f"; leave out the unit: {unit[2]} in place of {unit[1]!r}"
    if word := re.search(value % "(True|False)", text, re.MULTILINE):
        return f"; write {word[1].lower()} with a small {word[1][0].lower()}"
    if path := re.search(r'"[^"\n]*\\[^"\n]*"', text):
        return f"; a backslash starts an escape sequence: write {path[0].replace(chr(92), '/')}"
    for line in text.splitlines():
        if line.partition("#")[0].count('"') == 1 and '"""' not in text:
            return f"; a quote is not closed: {line.strip()}"
    heads = re.findall(r"^\s*\[\[?(\w+)\]", text, re.MULTILINE)
    single = next((head for head in heads if heads.count(head) > 1 and f"\n[{head}]" in f"\n{text}"), "")
    return f"; a table that comes several times needs two brackets: [[{single}]]" if single else ""


class Table:
    """Table of a TOML file that records which keys have been read, to find unknown keys.

    Args:
        data: Values from the TOML parser.
        where: Name of the table in messages, e.g. `simcore.toml [robot]`.

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
        """Return a `ConfigError` whose message names the table, the key and the problem."""
        return ConfigError(f"{self.where}: {key} {problem}")

    def __contains__(self, key: str) -> bool:
        return key in self._data

    def has(self, key: str) -> bool:
        """Return whether the table has a key with a value other than false."""
        return self._data.get(key, False) is not False

    def value(self, key: str, default: Any, wanted: str) -> Any:
        """Return the value of a key without a check of the type, and record that the key has been read.

        Args:
            key: Name of the key.
            default: Value if the key is missing; `REQUIRED` if a missing key is an error.
            wanted: Description of a valid value, for the message.

        Raises:
            ConfigError: A required key is missing.
        """
        self._asked.append(key)
        if key not in self._data and default is REQUIRED:
            raise self.error(key, f"is missing; it must be {wanted}")
        return self._data.get(key, default)

    def table(self, key: str) -> Table | None:
        """Return the table under a key, or None if the key is missing.

        Raises:
            ConfigError: The value is not a table.
        """
        value = self.value(key, None, "")
        if value is None:
            return None
        if not isinstance(value, dict):
            raise self.error(key, f"must be a table, written [{key}] on its own line; got {shown(value)}")
        return Table(value, f"{self.where} [{key}]")

    def tables(self, key: str) -> list[Table]:
        """Return the tables of an array of tables; empty if the key is missing.

        Raises:
            ConfigError: The value is not an array of tables, or two tables have the same `name`.
        """
        value = self.value(key, [], "")
        if not (isinstance(value, list) and all(isinstance(v, dict) for v in value)):
            raise self.error(key, f"must be tables, each under a line [[{key}]]; got {shown(value)}")
        names = [v["name"] for v in value if "name" in v]
        for name in names:
            if names.count(name) > 1:
                raise ConfigError(f"{self.where} [[{key}]] {name!r}: name is used twice; give each its own")
        return [Table(v, f"{self.where} [[{key}]] {v.get('name', number)!r}") for number, v in enumerate(value, 1)]

    def table_or_tables(self, key: str) -> list[Table]:
        """Return the table `[key]` as a list, or the tables of the array `[[key]]`; empty if the key is missing."""
        value = self._data.get(key)
        if isinstance(value, dict):
            self._asked.append(key)
            return [Table(value, f"{self.where} [{key}]")]
        return self.tables(key)

    def named_tables(self, key: str) -> dict[str, Table]:
        """Return the tables under a key by name, e.g. `[autos."Left"]` under `autos`; empty if the key is missing.

        Raises:
            ConfigError: The value is not a table, or contains a value that is not a table.
        """
        table = self.table(key)
        if table is None:
            return {}
        tables = {}
        for name, value in table._data.items():
            if not isinstance(value, dict):
                line = f"[{key}.{name!r}]"
                raise table.error(name, f"must be a table, written {line} on its own line; got {shown(value)}")
            tables[name] = Table(value, f"{self.where} [{key}.{name!r}]")
        return tables

    def finish(self) -> None:
        """Check that all keys of the table have been read.

        Raises:
            ConfigError: The table has an unknown key.
        """
        self.require_known(self._asked)

    def require_known(self, names: Iterable[str]) -> None:
        """Check that the table has only keys with the given names.

        Raises:
            ConfigError: The table has an unknown key.
        """
        known = sorted(names)
        for key in self._data:
            if key not in known:
                meant = _MEANT.get(key, "")
                near = f" Did you mean {meant!r}?" if meant in known else nearest(key, known)
                raise ConfigError(f"{self.where}: no key {key!r}.{near} Known: {', '.join(known)}")

    def slip(self, names: Collection[str]) -> str:
        """Return a message about an unknown key that is probably a misspelling of a missing key in `names`.

        The message is empty if the table has no such key.
        """
        missing = [name for name in names if name not in self._data]
        for key in self._data:
            if key not in _NAMES and (near := difflib.get_close_matches(key, missing, n=1, cutoff=0.85)):
                return f"{self.where}: no key {key!r}. Did you mean {near[0]!r}?"
        return ""


# --- keys -------------------------------------------------------------------------------------------------------------

_NAMES: set[str] = set()
"""Names of all keys of all tables."""
Names: TypeAlias = Mapping[str, Sequence[str]]
"""Names in a file by kind: `mechanism`, `carrier` (mechanisms that can carry other mechanisms) and `storage`."""


@dataclass(frozen=True, slots=True)
class Named:
    """Form of a value that names an object defined by another table of the file."""

    kind: str
    """Kind of the name, a key of `Names`."""
    table: str
    """Table that defines names of this kind, for messages."""
    many: bool = False
    """Whether the value may also be a list of names."""

    def __str__(self) -> str:
        return f"name of a {self.kind}" + (", or a list of such" if self.many else "")


@dataclass(frozen=True, slots=True)
class Several:
    """Form of a value that is a list with entries of one form."""

    of: Quantity | tuple[str, ...] | type[str] | type[DeviceAddress]
    """Form of the entries: numbers, names from a fixed set, any text, or devices."""
    or_one: bool = True
    """Whether a single entry may be written without brackets."""

    def __str__(self) -> str:
        one = _form_text(self.of)
        return f"{one}, or a list of such" if self.or_one else f"a list, each {one}"


Form: TypeAlias = "Quantity | Row | Named | Several | tuple[str, ...] | type[bool] | type[str] | type[DeviceAddress]"
"""Form of a value: a number, a row of numbers, a name in the file, a list, one of several texts, true or false, any
text, or a device."""


@dataclass(frozen=True, slots=True)
class Key:
    """Definition of a key in a table: name, valid values, default and meaning.

    >>> from simcore.quantities import MASS, ROBOT_PLACE
    >>> Key("mass", MASS).read(Table({"mass": -3}, "simcore.toml [robot]"), {})
    Traceback (most recent call last):
    simcore.errors.ConfigError: simcore.toml [robot]: mass must be a number above 0 and up to 1000 kg, got -3
    >>> Key("x_min", ROBOT_PLACE).read(Table({"x_min": -24}, "simcore.toml [intake]"), {})
    Traceback (most recent call last):
    simcore.errors.ConfigError: simcore.toml [intake]: x_min must be a number from -3 to 3 m, got -24. As inches \
that is -0.61 m
    """

    name: str
    form: Form
    default: Any = REQUIRED
    """Default in the unit of the file; None if `about` describes the default."""
    about: str = ""
    """Meaning of the key, for the template and the documentation."""
    example: Any = None
    """Value in the template; None for the default of the key, or `"name"` without a default."""
    field: str = ""
    """Name of the field in the config; empty for the name of the key. A single angle is converted from degrees to
    radians unless the field ends in `_deg`; angles in a row are always converted."""
    is_guess: bool = False
    """Whether the default is a guess, which simcore reports until the file gives the key."""
    needs: tuple[str, str] | None = None
    """Key that must be present, too, with a value other than false, and the value to suggest in the error message."""
    refused: Mapping[str, str] | None = None
    """Reason for the refusal of each refused text; None if no text is refused."""

    def __post_init__(self) -> None:
        _NAMES.add(self.name)

    def read(self, t: Table, names: Names) -> Any:
        """Return the checked value in a table, in the unit of the config, or the default if the key is missing.

        Args:
            t: Table that may contain the key.
            names: Valid names by kind, for values that are names in the file.

        Raises:
            ConfigError: The value is invalid, the key is required but missing, or the key in `needs` is missing.
        """
        form: Any = self.form
        if isinstance(form, Named):
            known = tuple(names.get(form.kind, ()))
            if not known and (self.name in t or self.default is REQUIRED):
                article = "a storage" if form.kind == "storage" else "a mechanism"
                raise t.error(self.name, f"must name {article}, but there is no {form.table} in the file")
            form = Several(known) if form.many else known
        value = t.value(self.name, self.default, _form_text(form))
        if self.needs and self.name in t and not t.has(self.needs[0]):
            raise t.error(self.name, f"needs {' = '.join(self.needs)} as well")
        if isinstance(value, str) and (reason := (self.refused or {}).get(value)):
            raise t.error(self.name, f"cannot be {shown(value)}: {reason}")
        if self.name not in t:
            given = value
        elif isinstance(form, Several):
            given = _several(t, self.name, value, form)
        else:
            given = _one(t, self.name, value, form)
        for one, number in zip(form, value or (), strict=False) if isinstance(form, tuple) else ((form, value),):
            if isinstance(one, Quantity) and one.unit == "deg" and (degrees := _as_radians(self.name, number)):
                raise t.error(
                    self.name, f"is in degrees, got {shown(number)}, which looks like radians: is {degrees:g} meant?"
                )
        if isinstance(form, Quantity) and form.unit == "deg" and not self.target.endswith("_deg") and given is not None:
            return math.radians(given)
        return given

    @property
    def target(self) -> str:
        """Name of the config field that receives the value."""
        return self.field or self.name

    def line(self, prefix: str = "# ") -> str:
        """Return the line of the key in the template: prefix, key, example and meaning."""
        values = (self.example, self.default, "name")
        first = next(one for one in values if one is not None and one is not REQUIRED)
        return comment_line(f"{prefix}{self.name} = {toml(first)}", self.about)

    def row(self) -> str:
        """Return the Markdown table row of the key: name, valid values, default and meaning."""
        default = "needed" if self.default is REQUIRED else ""
        if default == "" and self.default not in (None, (), ""):
            default = f"{'a guess: ' if self.is_guess else ''}`{toml(self.default)}`"
        meaning, _, left_out = self.about.partition("left out: ")
        return f"| `{self.name}` | {_form_text(self.form)} | {left_out or default} | {meaning.rstrip('; ')} |"


@dataclass(frozen=True, slots=True)
class KeyTable:
    """Keys of a table in the file, or of a part that several tables share."""

    head: str
    """Header as written in the file, e.g. `[[intake]]`."""
    about: str
    keys: tuple[Key, ...]

    def read(self, t: Table, names: Names | None = None) -> dict[str, Any]:
        """Return the values (or defaults) of all keys by config field, in the units of the config.

        Unknown keys are not an error here; `Table.finish` reports unknown keys.

        Raises:
            ConfigError: A value is invalid, or a required key is missing.
        """
        try:
            return {key.target: key.read(t, names or {}) for key in self.keys}
        except ConfigError as error:
            if slip := t.slip([key.name for key in self.keys]):
                raise ConfigError(slip) from error
            raise

    def guesses(self, t: Table) -> dict[str, Any]:
        """Return the guessed default of each key that is missing in a table, by name of the key."""
        return {key.name: key.default for key in self.keys if key.is_guess and key.name not in t}

    def example(self) -> str:
        """Return TOML comment lines with the header and an example line for every key of the table."""
        head, _, kind = self.head.partition(", ")
        return comment_line(f"# {head}", f"{kind}: {self.about}" if kind else self.about) + "".join(
            key.line() for key in self.keys
        )

    def reference(self) -> Iterator[str]:
        """Yield Markdown lines that document the table: a heading, the purpose, and a row for every key."""
        yield from (f"### {self.head}", "", f"{self.about[:1].upper()}{self.about[1:]}.", "")
        yield from ("| key | value | if it is left out | |", "|---|---|---|---|")
        yield from (key.row() for key in self.keys)
        yield ""


_HEADINGS = ("heading_deg", "start", "yaw_deg", "elevation_deg")
"""Keys of angles [deg] whose values are checked for radians written by mistake."""


def _as_radians(name: str, value: object) -> float | None:
    """Return the angle [deg] of a value that was probably written in radians, else None.

    >>> _as_radians("heading_deg", 3.14159), _as_radians("heading_deg", 90.0), _as_radians("elevation_deg", 1.13)
    (180.0, None, 64.7)
    """
    if name not in _HEADINGS or not isinstance(value, float) or value == round(value) or abs(value) > math.tau + 0.01:
        return None
    eighths = value / (0.25 * math.pi)
    if abs(eighths - round(eighths)) < 1e-3 * max(1.0, abs(eighths)) and round(eighths):
        return 45.0 * round(eighths)
    if name == "elevation_deg" and 0.2 < abs(value) < 0.5 * math.pi:
        return round(math.degrees(value), 1)  # in degrees, the shot would go along the carpet
    return None


def comment_line(text: str, about: str) -> str:
    """Format a line of TOML with a comment; a long comment continues on further comment lines."""
    first, *more = textwrap.wrap(about, 86) or [""]
    lines = [f"{text:<31} # {first}" if about else text, *(f"{'#':<31} # {line}" for line in more)]
    return "".join(f"{line}\n" for line in lines)


def table_text(head: str, rows: Iterable[tuple[str, Any, str]]) -> str:
    """Format a table as text, without rows whose values are empty.

    Args:
        head: Header as written in the file.
        rows: Key, value and comment of each row.

    >>> print(table_text("[drivetrain]", [("kind", "tank", ""), ("left", [1, 2], "found"), ("gyro", "", "")]), end="")
    [drivetrain]
    kind = "tank"
    left = [1, 2]                   # found
    """
    return f"{head}\n" + "".join(
        comment_line(f"{key} = {toml(value)}", remark) for key, value, remark in rows if value not in ("", (), [])
    )


def toml(value: Any) -> str:
    """Format a value as TOML."""
    if isinstance(value, tuple | list):
        return f"[{', '.join(toml(one) for one in value)}]"
    return json.dumps(value, ensure_ascii=False)


def _one(t: Table, key: str, value: Any, form: Any) -> Any:
    """Check and return a single value, of any form except `Named` and `Several`; rows of angles become radians."""
    if isinstance(form, Quantity):
        require(t.where, key, value, form)
        return value if form.is_whole else float(value)
    if isinstance(form, tuple) and form and not isinstance(form[0], str):
        if not isinstance(value, list):
            raise t.error(key, f"must be {row_text(form)}, got {shown(value)}")
        require_row(t.where, key, value, form)
        return tuple(math.radians(v) if one.unit == "deg" else float(v) for v, one in zip(value, form, strict=True))
    if form is bool:
        if not isinstance(value, bool):
            raise t.error(key, f"must be true or false, got {shown(value)}")
        return value
    if form is DeviceAddress:
        address = DeviceAddress.parse(value)
        if address is None:
            raise t.error(key, f"must be {DeviceAddress.FORM}, got {shown(value)}")
        return address
    if not (isinstance(value, str) and value.strip() and value.isprintable()):
        raise t.error(key, f"must be a text in quotes, got {shown(value)}")
    if form is not str and value not in form:
        raise t.error(key, f"must be one of {', '.join(form)}, got {shown(value)}.{nearest(value, form)}")
    return value


def _several(t: Table, key: str, value: Any, form: Several) -> tuple[Any, ...]:
    """Check and return the values of a list; if the form allows a single value, return a tuple with this value."""
    is_list = isinstance(value, list)
    if (not is_list and not form.or_one) or (value == [] and form.or_one):
        raise t.error(key, f"must be {form}; got {shown(value)}")
    if not is_list:
        return (_one(t, key, value, form.of),)
    return tuple(_one(t, f"{key}[{number}]", one, form.of) for number, one in enumerate(value))


def _form_text(form: Any) -> str:
    """Describe the valid values of a form in words, for messages and the documentation."""
    if form is bool:
        return "true or false"
    if form is str:
        return "a text in quotes"
    if form is DeviceAddress:
        return DeviceAddress.FORM
    if isinstance(form, tuple) and all(isinstance(one, str) for one in form):
        return f"one of {', '.join(form)}"
    return row_text(form) if isinstance(form, tuple) else str(form)
