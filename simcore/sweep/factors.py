"""Factors: quantities with different values in the runs of an experiment.

The values of a factor are listed or drawn from a distribution. The name of a factor is a dotted path into one of three
configs. A path consists of field names, keys and indices (`*` for all rows), for example
`robot.battery.initial_charge`, `robot.drivetrain.modules.*.wheel_cof`, `scatter.spin` or `pieces.*.mass`. A name that
begins with a word of `PLAYED` sets how a run is played. `robot.mass` sets the mass of the whole robot and is the only
path that is not a field.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import Any, Literal, TypeAlias

from simcore.errors import ConfigError, UnknownNameError
from simcore.match.game import Auto, Game, PieceSupply
from simcore.match.players.lineup import Seat, lineup
from simcore.match.scatter import Scatter
from simcore.match.scoring import Alliance
from simcore.quantities import DURATION, FACTOR, MASS, Quantity, require, require_fields, shown
from simcore.robot.robot_config import RobotConfig
from simcore.world.engine_choice import engine_label

__all__ = [
    "CONFIGS", "PLAYED", "PROJECT", "Distribution", "Factor", "FactorValue", "RunSetup", "parse_factor", "vary",
    "vary_pieces", "vary_robot", "vary_scatter",
]  # fmt: skip

PROJECT = "project"
"""Name of the factor whose values are folders of robot projects."""

FactorValue: TypeAlias = float | int | str
"""Value of a factor: a number, or a name, e.g. the name of an auto."""

_ANY = Quantity("", -1e12, 1e12)
_MOST_VALUES = 100_000
_LIKE_RANGE = re.compile(r"(uniform|normal|range)\b|[\d.]+ *(-|\.\.|to\b)")
"""Pattern of texts that are ranges in an invalid notation rather than names, e.g. `45-60`, `45..60`, `uniform 45`."""
_EXAMPLE = (
    "write NAME=45:60:5 (from:to:step, the end included), NAME=0.3,1 (a list), NAME=uniform(0.4,0.5) or "
    "NAME=normal(55,1)"
)
PLAYED = ("alliance", "auto", "blue", "engine", "preload", "red", "seconds", "start")
"""First words in the names of factors that set how a run is played."""
CONFIGS = ("robot", "scatter", "pieces")
"""First words in the names of factors that are paths into a config."""
_STARTS = ("start.x", "start.y", "start.heading")


@dataclass(frozen=True, slots=True)
class Distribution:
    """Uniform or normal distribution from which the values of a factor are drawn.

    >>> Distribution("uniform", 40.0, 60.0).at(0.25)
    45.0
    """

    kind: Literal["uniform", "normal"]
    first: float
    """Lower end of `uniform`, mean of `normal`; in the unit of the factor."""
    second: float
    """Upper end of `uniform`, standard deviation of `normal`; in the unit of the factor."""

    def __post_init__(self) -> None:
        require_fields(self, f"distribution {self.kind}", first=_ANY, second=_ANY)
        if self.kind == "uniform" and not self.first < self.second:
            raise ConfigError(f"uniform(low,high) needs low < high, got {self}")
        if self.kind == "normal" and not self.second > 0.0:
            raise ConfigError(f"normal(mean,deviation) needs a deviation > 0, got {self}")

    def at(self, share: float) -> float:
        """Return the quantile for a probability `share` [-], 0 < share < 1."""
        if self.kind == "uniform":
            return self.first + share * (self.second - self.first)
        return NormalDist(self.first, self.second).inv_cdf(share)

    def __str__(self) -> str:
        return f"{self.kind}({self.first:g},{self.second:g})"


@dataclass(frozen=True, slots=True)
class Factor:
    """Quantity that varies between runs, with listed values or a distribution of values.

    >>> Factor("robot.mass", (45.0, 50.0)).at(0.7)
    50.0
    """

    name: str
    """Dotted name of the varied quantity, e.g. `robot.mass` or `auto`."""
    values: tuple[FactorValue, ...] = ()
    """Listed values, in the unit of the varied field; empty if the factor has a distribution."""
    distribution: Distribution | None = None
    """Distribution instead of listed values; None if the values are listed."""

    def __post_init__(self) -> None:
        require_fields(self, f"factor {self.name}")
        if not all(self.name.split(".")):
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
        """Return the listed value at a fraction `share` of the list, or the quantile for the probability `share` [-].

        Args:
            share: Fraction or probability [-]: 0 <= share < 1 for listed values, 0 < share < 1 for a distribution.
        """
        if self.distribution is not None:
            return self.distribution.at(share)
        return self.values[min(len(self.values) - 1, int(share * len(self.values)))]

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Factor:
        """Create a factor from the result of `dataclasses.asdict`; lists in place of tuples are accepted."""
        drawn = data["distribution"]
        return cls(data["name"], tuple(data["values"]), None if drawn is None else Distribution(**drawn))


def parse_factor(text: str) -> Factor:
    """Parse the command-line notation of a factor: `NAME=` and values, a range or a distribution.

    >>> parse_factor("robot.mass=45:60:5").values
    (45.0, 50.0, 55.0, 60.0)
    >>> parse_factor("auto=left,right").values
    ('left', 'right')
    >>> str(parse_factor("robot.mass=uniform(40,50)").distribution)
    'uniform(40,50)'

    Raises:
        ConfigError: If the text cannot be parsed; the message has an example.
    """
    name, equals, what = (part.strip() for part in text.partition("="))
    unreadable = ConfigError(f"a factor {shown(text)} cannot be read: {_EXAMPLE}")
    if not equals or not name or not what:
        raise unreadable
    if call := re.fullmatch(r"(\w+)\(([^()]*)\)", what):
        numbers = [_number(part) for part in call[2].split(",")]
        if call[1] not in ("uniform", "normal") or len(numbers) != 2 or None in numbers:
            raise unreadable
        return Factor(name, distribution=Distribution(call[1], *numbers))  # type: ignore[arg-type]
    if ":" in what and not what[0].isalpha():
        numbers = [_number(part) for part in what.split(":")]
        if len(numbers) != 3 or None in numbers:
            raise unreadable
        return Factor(name, _steps(name, *numbers))  # type: ignore[arg-type]
    parts = [part.strip() for part in what.split(",")]
    if not all(parts) or any(_LIKE_RANGE.match(part) for part in parts):
        raise unreadable
    return Factor(name, tuple(part if (number := _number(part)) is None else number for part in parts))


def _steps(name: str, first: float, last: float, step: float) -> tuple[float, ...]:
    """Return the values from `first` to `last` in equal steps, including `last` if a step ends there.

    Raises:
        ConfigError: If the step is zero or has the wrong sign, or if there are more than 100,000 values.
    """
    if step == 0.0 or (last - first) / step < 0.0:
        raise ConfigError(f"factor {name}: steps of {step:g} do not lead from {first:g} to {last:g}")
    count = math.floor((last - first) / step + 1e-9) + 1
    if count > _MOST_VALUES:
        raise ConfigError(f"factor {name}: {count} values are too many, at most {_MOST_VALUES} are")
    # rounded, so that 0.1:0.3:0.1 gives 0.3 and not 0.30000000000000004
    return tuple(float(f"{first + number * step:.12g}") for number in range(count))


def _number(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if math.isfinite(number) else None


# --- meaning of names -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True)
class RunSetup:
    """Inputs of a run other than the seed."""

    game: Game
    auto: Auto
    robot: RobotConfig
    scatter: Scatter | None = None
    alliance: Alliance = "blue"
    seconds: float | None = None
    """Simulated duration [s]; None for the autonomous period, or for the whole match if the run has players (`red`,
    `blue`)."""
    engine: str | None = None
    red: str = ""
    """Players of the red alliance in a whole match, in the notation of `lineup`. If `red` and `blue` are empty, a
    single robot plays the auto."""
    blue: str = ""

    def __post_init__(self) -> None:
        require_fields(self, "run", seconds=DURATION)
        engine_label(self.engine)  # raises for an unknown name
        _ = self.seats  # raises for unknown players

    @property
    def seats(self) -> tuple[Seat, ...]:
        """Players of a match with their alliances and roles; empty if a single robot plays the auto."""
        return lineup(self.game, red=self.red, blue=self.blue) if self.red or self.blue else ()


def vary(setup: RunSetup, values: Mapping[str, FactorValue]) -> RunSetup:
    """Return a copy of a setup with factors set to values.

    Raises:
        ConfigError: If a factor does not exist or a value is invalid; the message contains similar names or the valid
            values.
    """
    for name, value in sorted(values.items(), key=lambda item: item[0] != "auto"):  # an auto sets the start
        if name.partition(".")[0] in PLAYED:
            with _named(name):
                setup = _vary_played(setup, name, value)
    return replace(
        setup,
        robot=vary_robot(setup.robot, values),
        game=vary_pieces(setup.game, values),
        scatter=vary_scatter(setup.scatter, values),
    )


def vary_robot(robot: RobotConfig, values: Mapping[str, FactorValue]) -> RobotConfig:
    """Return a copy of a robot with the `robot.` factors set to values.

    Factors of other configs and of `PLAYED` are ignored.

    Raises:
        ConfigError: If the path or the value of a `robot.` factor is invalid, or if the first word of a name is in
            neither `CONFIGS` nor `PLAYED`.
    """
    for name, value in values.items():
        first, *path = name.split(".")
        with _named(name):
            if first == "robot":
                robot = _with_mass(robot, value) if path == ["mass"] else _with(robot, path, value, first)
            elif first not in (*PLAYED, *CONFIGS):
                of_robot = [f"robot.{first}"] if first in _parts_of(robot) else []
                raise UnknownNameError("factor", first, of_robot or [*PLAYED, *CONFIGS])
    return robot


def vary_scatter(scatter: Scatter | None, values: Mapping[str, FactorValue]) -> Scatter | None:
    """Return a copy of a scatter with the `scatter` factors set to values; other factors are ignored.

    The factor `scatter` replaces all spreads by the default spreads times the value. A factor such as `scatter.spin`
    sets a single spread.

    Args:
        scatter: Current scatter; None for no scatter.
        values: Values of all factors.

    Returns:
        Changed scatter, or `scatter` if no value is of a `scatter` factor.
    """
    for name, value in sorted(values.items()):  # all spreads before single spreads
        first, *path = name.split(".")
        if first != "scatter":
            continue
        with _named(name):
            if path:
                scatter = _with(scatter or Scatter.none(), path, value, "scatter")
            else:
                require("scatter", "factor of the default spreads", value, FACTOR)
                scatter = Scatter().scaled(float(value))
    return scatter


def vary_pieces(game: Game, values: Mapping[str, FactorValue]) -> Game:
    """Return a copy of a game with the factors `pieces.<kind>.<field>` set to values; other factors are ignored.

    The kind `*` sets the field of all kinds of pieces.
    """
    for name, value in values.items():
        first, *path = name.split(".")
        if first != "pieces":
            continue
        with _named(name):
            supplies = {supply.kind.name: supply for supply in game.pieces}
            if not path or path[0] not in (*supplies, "*"):
                raise UnknownNameError("kind of piece", ".".join(path[:1]), [*supplies, "*"])
            for kind, supply in supplies.items():
                if path[0] in (kind, "*"):
                    varied = _with(supply.kind, path[1:], value, f"pieces.{kind}")
                    supplies[kind] = PieceSupply(varied, supply.count)
        game = replace(game, pieces=tuple(supplies.values()))
    return game


@contextmanager
def _named(name: str) -> Iterator[None]:
    """Raise errors of the block again as a `ConfigError` whose message begins with the name of the factor."""
    try:
        yield
    except (ConfigError, UnknownNameError) as error:
        raise ConfigError(f"factor {name!r}: {error}") from error


def _vary_played(setup: RunSetup, name: str, value: FactorValue) -> RunSetup:
    """Return a copy of a setup with one factor of `PLAYED` set to a value.

    The constructors of setup, game and auto check the value.
    """
    auto = setup.auto
    if name == "auto":
        return replace(setup, auto=setup.game.auto(str(value)))
    if name == "preload":
        return replace(setup, auto=replace(auto, preload=_converted(0, value, name)))
    if name in ("alliance", "blue", "engine", "red", "seconds"):
        changed: dict[str, Any] = {name: value}
        return replace(setup, **changed)
    if name not in _STARTS:
        raise UnknownNameError("factor", name, [*PLAYED[:-1], *_STARTS])
    start: Any = tuple(value if part == name else old for part, old in zip(_STARTS, auto.start, strict=True))
    return replace(setup, auto=replace(auto, start=start))


def _with(config: Any, path: Sequence[str], value: FactorValue, where: str) -> Any:
    """Return a copy of a config with a new value at a path; `*` in the path sets all rows of a tuple."""
    if not path:
        return _converted(config, value, where)
    first, rest = path[0], path[1:]
    parts = _parts_of(config)
    if not parts:
        raise ConfigError(f"{where} is {shown(config)}, which has no {first!r} to vary")
    chosen = list(parts) if first == "*" and isinstance(config, tuple) else [first]
    if chosen[0] not in parts:
        raise UnknownNameError(f"part of {where}", first, [*parts, "mass"] if where == "robot" and not rest else parts)
    changed = {part: _with(parts[part], rest, value, f"{where}.{part}") for part in chosen}
    if isinstance(config, Mapping):
        return {**config, **changed}
    if isinstance(config, tuple):
        return tuple([*(parts | changed).values()])
    return replace(config, **changed)


def _parts_of(config: Any) -> dict[str, Any]:
    """Return the fields, entries (of a mapping) or rows (of a tuple) of a config by name; empty for a plain value."""
    if isinstance(config, Mapping):
        return {str(name): part for name, part in config.items()}
    if isinstance(config, tuple):
        rows: tuple[Any, ...] = config
        return {str(number): part for number, part in enumerate(rows)}
    if not dataclasses.is_dataclass(config) or isinstance(config, type):
        return {}
    return {field.name: getattr(config, field.name) for field in dataclasses.fields(config) if field.init}


def _with_mass(robot: RobotConfig, value: FactorValue) -> RobotConfig:
    """Return a copy of a robot with a new mass [kg] and with yaw moments of inertia scaled in proportion."""
    require("robot", "mass", value, MASS)
    drivetrain, mass = robot.drivetrain, float(value)
    inertia = drivetrain.yaw_inertia * mass / drivetrain.mass
    chassis = robot.chassis
    if chassis is not None:
        own = chassis.yaw_inertia
        chassis = replace(chassis, mass=mass, yaw_inertia=None if own is None else own * mass / chassis.mass)
    return replace(robot, drivetrain=replace(drivetrain, mass=mass, yaw_inertia=inertia), chassis=chassis)


def _converted(present: Any, value: FactorValue, where: str) -> Any:
    """Convert a factor value to the type of the current value of a field, without a check of the range.

    Raises:
        ConfigError: If the field is a bool and the value is neither true nor false, or if the field is not a number or
            text.
    """
    if isinstance(present, bool):
        if str(value).lower() not in ("true", "false"):
            raise ConfigError(f"{where} must be true or false, got {shown(value)}")
        return str(value).lower() == "true"
    if isinstance(present, int) and isinstance(value, float) and value.is_integer():
        return int(value)
    if present is None or isinstance(present, (int, float, str)):
        return value
    raise ConfigError(f"{where} has parts: name a number in it, as {where}.{{{','.join(_parts_of(present))}}}")
