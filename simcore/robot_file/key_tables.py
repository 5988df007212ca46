"""The keys of simcore.toml: each stands once, and makes reader, error sentences, template and documentation."""

from __future__ import annotations

import json
import math
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from simcore.errors import nearest
from simcore.quantities import Quantity, Row, require, require_row, row_text, shown
from simcore.robot_file.toml_tables import REQUIRED, Table

__all__ = ["Form", "Key", "KeyTable", "Named", "Names", "Several", "table_text", "toml"]

Names: TypeAlias = Mapping[str, Sequence[str]]
"""What a file has, by its kind: the names of its mechanisms, of those that carry something, of its storages."""


@dataclass(frozen=True, slots=True)
class Named:
    """The name of something in the file."""

    kind: str
    """Of `Names`."""
    table: str
    """Where such things are described, for the message if there is none."""
    many: bool = False
    """Whether a list of names may be given, too."""

    def __str__(self) -> str:
        return f"name of a {self.kind}" + (", or a list of such" if self.many else "")


@dataclass(frozen=True, slots=True)
class Several:
    """A list."""

    of: Quantity | tuple[str, ...] | type[str]
    """Of numbers, of names out of a closed set, or of any texts."""
    or_one: bool = True
    """Whether a single one may be written without brackets."""

    def __str__(self) -> str:
        one = _form_text(self.of)
        return f"{one}, or a list of such" if self.or_one else f"a list, each {one}"


Form: TypeAlias = "Quantity | Row | Named | Several | tuple[str, ...] | type[bool] | type[str]"
"""What a value may be: a number, a row of numbers, a name, a list, one of several texts, true or false, a text."""


@dataclass(frozen=True, slots=True)
class Key:
    """One key.

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
    """If it is not in the file, in the file's unit; None: what `about` says."""
    about: str = ""
    """What it is, for template and documentation."""
    example: Any = None
    """In the template; None: the default."""
    field: str = ""
    """Of the config that it goes to; empty: its own name. An angle in degrees goes there in radians, unless the field
    has `_deg` at its end, too."""
    is_guess: bool = False
    """Whether its default is a guess, which runs list as long as the file does not say it."""

    def read(self, t: Table, names: Names) -> Any:
        """The value in a table, in the unit of the config.

        Raises:
            ConfigError: It cannot be.
        """
        form: Any = self.form
        if isinstance(form, Named):
            known = tuple(names.get(form.kind, ()))
            if not known and (self.name in t or self.default is REQUIRED):
                article = "a storage" if form.kind == "storage" else "a mechanism"
                raise t.error(self.name, f"must name {article}, but there is no {form.table} in the file")
            form = Several(known) if form.many else known
        value = t.value(self.name, self.default, _wanted(form))
        if self.name not in t:
            given = value
        elif isinstance(form, Several):
            given = _several(t, self.name, value, form)
        else:
            given = _one(t, self.name, value, form)
        if isinstance(form, Quantity) and form.unit == "deg" and not self.target.endswith("_deg") and given is not None:
            return math.radians(given)
        return given

    @property
    def target(self) -> str:
        """Field of the config."""
        return self.field or self.name

    def line(self, prefix: str = "# ") -> str:
        """Of the template."""
        values = (self.example, self.default, "name")
        first = next(one for one in values if one is not None and one is not REQUIRED)
        return comment_line(f"{prefix}{self.name} = {toml(first)}", self.about)

    def row(self) -> str:
        """Of the table in the documentation."""
        default = "needed" if self.default is REQUIRED else ""
        if default == "" and self.default not in (None, (), ""):
            default = f"{'a guess: ' if self.is_guess else ''}`{toml(self.default)}`"
        meaning, _, left_out = self.about.partition("left out: ")
        return f"| `{self.name}` | {_form_text(self.form)} | {left_out or default} | {meaning.rstrip('; ')} |"


@dataclass(frozen=True, slots=True)
class KeyTable:
    """A table of the file, or a part that several tables share."""

    head: str
    """As written in the file, e.g. `[[intake]]`."""
    about: str
    keys: tuple[Key, ...]

    def read(self, t: Table, names: Names | None = None) -> dict[str, Any]:
        """The values by the fields of the config.

        Raises:
            ConfigError: A value cannot be; keys of other names are refused by `Table.finish`.
        """
        return {key.target: key.read(t, names or {}) for key in self.keys}

    def guesses(self, t: Table) -> dict[str, Any]:
        """Keys that are left out and whose defaults are guesses, with these."""
        return {key.name: key.default for key in self.keys if key.is_guess and key.name not in t}

    def example(self) -> str:
        """The table in comments."""
        head, _, kind = self.head.partition(", ")
        return comment_line(f"# {head}", f"{kind}: {self.about}" if kind else self.about) + "".join(
            key.line() for key in self.keys
        )

    def reference(self) -> Iterator[str]:
        """Lines of the documentation."""
        yield from (f"### {self.head}", "", f"{self.about[:1].upper()}{self.about[1:]}.", "")
        yield from ("| key | value | if it is left out | |", "|---|---|---|---|")
        yield from (key.row() for key in self.keys)
        yield ""


def comment_line(text: str, about: str) -> str:
    """A line of TOML with its meaning behind it, on more lines where it is long."""
    first, *more = textwrap.wrap(about, 86) or [""]
    lines = [f"{text:<31} # {first}" if about else text, *(f"{'#':<31} # {line}" for line in more)]
    return "".join(f"{line}\n" for line in lines)


def table_text(head: str, rows: Iterable[tuple[str, Any, str]]) -> str:
    """A table as text; rows whose values are empty are left out.

    Args:
        head: As written in the file.
        rows: Keys, values, and what is to be said of each.

    >>> print(table_text("[drivetrain]", [("kind", "tank", ""), ("left", [1, 2], "found"), ("gyro", "", "")]), end="")
    [drivetrain]
    kind = "tank"
    left = [1, 2]                   # found
    """
    return f"{head}\n" + "".join(
        comment_line(f"{key} = {toml(value)}", remark) for key, value, remark in rows if value not in ("", ())
    )


def toml(value: Any) -> str:
    """A value as TOML has it."""
    if isinstance(value, tuple | list):
        return f"[{', '.join(toml(one) for one in value)}]"
    return json.dumps(value, ensure_ascii=False)


def _one(t: Table, key: str, value: Any, form: Any) -> Any:
    """A value that is no list of names."""
    if isinstance(form, Quantity):
        require(t.where, key, value, form)
        return value if form.is_whole else float(value)
    if isinstance(form, list) or (isinstance(form, tuple) and form and not isinstance(form[0], str)):
        if not (isinstance(value, list) and value):
            raise t.error(key, f"must be {row_text(form)}, got {shown(value)}")
        require_row(t.where, key, value, form)
        return tuple(float(v) for v in value)
    if form is bool:
        if not isinstance(value, bool):
            raise t.error(key, f"must be true or false, got {shown(value)}")
        return value
    if not (isinstance(value, str) and value.strip() and value.isprintable()):
        raise t.error(key, f"must be a text in quotes, got {shown(value)}")
    if form is not str and value not in form:
        raise t.error(key, f"must be one of {', '.join(form)}, got {shown(value)}.{nearest(value, form)}")
    return value


def _several(t: Table, key: str, value: Any, form: Several) -> tuple[Any, ...]:
    """A list, or one value where that may stand alone."""
    values, of = value if isinstance(value, list) else [value], form.of
    if isinstance(of, Quantity) and not of.is_whole:
        return tuple(_one(t, key, values, [of])) if isinstance(value, list) else (_one(t, key, value, of),)
    if isinstance(of, Quantity):
        good = isinstance(value, list) or form.or_one
        if not good or (form.or_one and not values) or any(type(v) is not int or of.problem(v) for v in values):
            wanted = _wanted(form) + (";" if form.or_one else ",")
            raise t.error(key, f"must be {wanted} got {shown(value)}")
        return tuple(values)
    if not values or not all(isinstance(v, str) and v.strip() for v in values):
        raise t.error(key, f"must be a text in quotes, or a list of such; got {shown(value)}")
    return tuple(values) if of is str else tuple(_one(t, key, v, of) for v in values)


def _wanted(form: Any) -> str:
    """What a value must be, for a message."""
    if isinstance(form, Several) and isinstance(form.of, tuple):
        return f"one or more of {', '.join(form.of)}"
    if isinstance(form, Several) and isinstance(form.of, Quantity) and form.of.is_whole:
        whole = str(form.of)
        if form.or_one:
            return f"{whole}, or a list of such, e.g. [0, 1]"
        return f"a list of {whole.removeprefix('a ').replace('number', 'numbers')}, e.g. [21, 22]"
    is_choice = isinstance(form, tuple) and all(isinstance(one, str) for one in form)
    return "a text in quotes" if is_choice else _form_text(form)


def _form_text(form: Any) -> str:
    if form is bool:
        return "true or false"
    if form is str:
        return "a text in quotes"
    if isinstance(form, tuple) and isinstance(form[0], str):
        return ", ".join(form)
    return row_text(form) if isinstance(form, tuple | list) else str(form)
