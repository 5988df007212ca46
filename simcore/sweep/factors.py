"""What differs between the runs of an experiment: values of a name, written out or drawn from a distribution."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any, Literal, TypeAlias

from simcore.errors import ConfigError
from simcore.quantities import Quantity, require, shown

__all__ = ["PROJECT", "Distribution", "Factor", "FactorValue", "parse_factor"]

PROJECT = "project"
"""Name of the factor whose values are folders of robot projects."""

FactorValue: TypeAlias = float | int | str
"""What a factor can be: a number, or a name such as that of an auto."""

_ANY = Quantity("", -1e12, 1e12)
_MOST_VALUES = 100_000
_LIKE_RANGE = re.compile(r"(uniform|normal|range)\b|[\d.]+ *(-|\.\.|to\b)")
"""What is no name, but meant as several numbers: `45-60`, `45..60`, `uniform 45`."""
_EXAMPLE = (
    "want NAME=45:60:5 (from:to:step, the end included), NAME=0.3,1 (a list), NAME=uniform(0.4,0.5) or "
    "NAME=normal(55,1)"
)


@dataclass(frozen=True, slots=True)
class Distribution:
    """Of the values of a factor.

    >>> Distribution("uniform", 40.0, 60.0).at(0.25)
    45.0
    """

    kind: Literal["uniform", "normal"]
    first: float
    """Lower end of `uniform`, mean of `normal`; in the unit of the factor."""
    second: float
    """Upper end of `uniform`, standard deviation of `normal`; in the unit of the factor."""

    def __post_init__(self) -> None:
        if self.kind not in ("uniform", "normal"):
            raise ConfigError(f"a distribution is 'uniform' or 'normal', got {shown(self.kind)}")
        for name in ("first", "second"):
            require(f"distribution {self.kind}", name, getattr(self, name), _ANY)
        if self.kind == "uniform" and not self.first < self.second:
            raise ConfigError(f"uniform(low,high) needs low < high, got {self}")
        if self.kind == "normal" and not self.second > 0.0:
            raise ConfigError(f"normal(mean,deviation) needs a deviation > 0, got {self}")

    def at(self, share: float) -> float:
        """The value below which a share of all values lies (quantile), share above 0 and below 1 [-]."""
        if self.kind == "uniform":
            return self.first + share * (self.second - self.first)
        return NormalDist(self.first, self.second).inv_cdf(share)

    def __str__(self) -> str:
        return f"{self.kind}({self.first:g},{self.second:g})"


@dataclass(frozen=True, slots=True)
class Factor:
    """One thing that is varied: listed values, or a distribution.

    >>> Factor("robot.mass", (45.0, 50.0)).at(0.7)
    50.0
    """

    name: str
    """What is varied, as `simcore.sweep.factor_paths` finds it: `robot.mass`, `battery.charge`, `auto`."""
    values: tuple[FactorValue, ...] = ()
    """In the unit of what is varied."""
    distribution: Distribution | None = None
    """In place of values."""

    def __post_init__(self) -> None:
        if not self.name or not all(part for part in self.name.split(".")):
            raise ConfigError(f"a factor needs a name such as 'robot.mass', got {shown(self.name)}")
        object.__setattr__(self, "values", tuple(self.values))
        if bool(self.values) == (self.distribution is not None):
            raise ConfigError(f"factor {self.name}: give either values or a distribution")
        for value in self.values:
            if not isinstance(value, str):
                require(f"factor {self.name}", "value", value, _ANY)
        if len(set(self.values)) < len(self.values):
            raise ConfigError(f"factor {self.name}: values must differ, got {shown(list(self.values))}")

    def at(self, share: float) -> FactorValue:
        """The value at a share of all of them, from 0 up to but without 1 [-]."""
        if self.distribution is not None:
            return self.distribution.at(share)
        return self.values[min(len(self.values) - 1, int(share * len(self.values)))]

    def to_json(self) -> dict[str, Any]:
        """In plain types, for `from_json`."""
        if self.distribution is None:
            return {"name": self.name, "values": list(self.values)}
        return {"name": self.name, self.distribution.kind: [self.distribution.first, self.distribution.second]}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Factor:
        """What `to_json` wrote."""
        for kind in ("uniform", "normal"):
            if kind in data:
                return cls(data["name"], distribution=Distribution(kind, *data[kind]))
        return cls(data["name"], tuple(data["values"]))


def parse_factor(text: str) -> Factor:
    """A factor as the command line writes it.

    >>> parse_factor("robot.mass=45:60:5").values
    (45.0, 50.0, 55.0, 60.0)
    >>> parse_factor("auto=left,right").values
    ('left', 'right')
    >>> str(parse_factor("shooter.exit_efficiency=uniform(0.4,0.5)").distribution)
    'uniform(0.4,0.5)'

    Raises:
        ConfigError: It cannot be read; the text has an example.
    """
    name, equals, what = (part.strip() for part in text.partition("="))
    if not equals or not name or not what:
        raise ConfigError(f"a factor {shown(text)} cannot be read: {_EXAMPLE}")
    if call := re.fullmatch(r"(\w+)\(([^()]*)\)", what):
        numbers = [_number(part) for part in call[2].split(",")]
        if call[1] not in ("uniform", "normal") or len(numbers) != 2 or None in numbers:
            raise ConfigError(f"factor {name}: {shown(what)} cannot be read: {_EXAMPLE}")
        return Factor(name, distribution=Distribution(call[1], *numbers))  # type: ignore[arg-type]
    if ":" in what and not what[0].isalpha():
        numbers = [_number(part) for part in what.split(":")]
        if len(numbers) != 3 or None in numbers:
            raise ConfigError(f"factor {name}: {shown(what)} cannot be read: {_EXAMPLE}")
        return Factor(name, _steps(name, *numbers))  # type: ignore[arg-type]
    parts = [part.strip() for part in what.split(",")]
    if not all(parts) or any(_LIKE_RANGE.match(part) for part in parts):
        raise ConfigError(f"factor {name}: {shown(what)} cannot be read: {_EXAMPLE}")
    return Factor(name, tuple(part if (number := _number(part)) is None else number for part in parts))


def _steps(name: str, first: float, last: float, step: float) -> tuple[float, ...]:
    """From first to last, the end included where a step meets it."""
    if step == 0.0 or (last - first) / step < 0.0:
        raise ConfigError(f"factor {name}: steps of {step:g} do not lead from {first:g} to {last:g}")
    count = math.floor((last - first) / step + 1e-9) + 1
    if count > _MOST_VALUES:
        raise ConfigError(f"factor {name}: {count} values are too many, at most {_MOST_VALUES} are")
    # rounded, so that 0.1:0.3:0.1 has the 0.3 that people write, and not 0.30000000000000004
    return tuple(float(f"{first + number * step:.12g}") for number in range(count))


def _number(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if math.isfinite(number) else None
