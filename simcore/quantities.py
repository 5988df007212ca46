"""Checks of input numbers: allowed range and unit of each quantity, and the error message for an invalid number.

Configs call `require_fields`, which checks each number against a quantity and any other field against the declared
type. Functions check an argument with `require`. Readers of files call `Quantity.problem`. The ranges include every
robot and field that can be built, but exclude most sizes in a wrong unit.
"""

from __future__ import annotations

import builtins
import inspect
import math
import sys
from argparse import ArgumentTypeError
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import islice
from numbers import Real
from types import NoneType, UnionType
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeAlias, Union, get_args, get_origin

from simcore.errors import ConfigError, NonFiniteError, SimcoreError

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

__all__ = [
    "ACCELERATION",
    "ANGLE",
    "ATTITUDE",
    "COUNT",
    "CURRENT",
    "CURRENT_LIMIT",
    "CURRENT_OR_NONE",
    "DEGREES",
    "DELAY",
    "DURATION",
    "EFFICIENCY",
    "FACTOR",
    "FIELD_LENGTH",
    "FIELD_OF_VIEW",
    "FIELD_PLACE",
    "FORCE",
    "FORCE_OR_NONE",
    "FRACTION",
    "FRAME_RATE",
    "FRICTION",
    "GAIN",
    "GEARING",
    "INERTIA",
    "INERTIA_OR_NONE",
    "MASS",
    "MASS_OR_NONE",
    "MOTORS",
    "NOISE_DEGREES",
    "NOISE_PIXELS",
    "PIXELS",
    "PORT",
    "POSE",
    "POSITIVE",
    "RATE",
    "RATIO",
    "RESISTANCE",
    "ROBOT_HEIGHT",
    "ROBOT_LENGTH",
    "ROBOT_PLACE",
    "SIGNED_VOLTAGE",
    "SLIP_SPEED",
    "SPEED",
    "SPEED_SHARE",
    "START",
    "STIFFNESS",
    "TORQUE",
    "TORQUE_OR_NONE",
    "TURN_RATE",
    "TURN_RATE_OR_NONE",
    "VOLTAGE",
    "VOLTAGE_OR_NONE",
    "WHEEL_RADIUS",
    "DeviceAddress",
    "DeviceKey",
    "Quantity",
    "Row",
    "checked_number",
    "number_flag",
    "require",
    "require_attitude",
    "require_count",
    "require_fields",
    "require_points",
    "require_row",
    "row_text",
    "shown",
    "text_flag",
]

_OTHER_UNITS = {
    "m": (("inches", 0.0254), ("cm", 0.01), ("mm", 0.001)),
    "kg": (("pounds", 0.45359237), ("g", 0.001)),
    "rad": (("degrees", math.pi / 180.0),),
    "1/s": (("rpm", 1.0 / 60.0),),
}
"""Units that users often use by mistake, each with a name and the size of the unit in SI, by SI unit."""

_TINY = 1e-12  # distance above an open bound within which a number acts like 0 as a divisor
_MOST_ITEMS = 10_000_000  # largest number of items in a row, because `range(10**12)` is also a sequence
_MOST_COMMANDED = 1e6  # largest command [V, A or m/s], because powers of larger numbers may overflow


@dataclass(frozen=True, slots=True)
class Quantity:
    """Range and unit of the allowed values of a number.

    >>> ROBOT_LENGTH.problem(34.0)
    'must be a number above 0 and up to 3 m, got 34.0. As inches that is 0.864 m'
    >>> MOTORS.problem(True)
    'must be a whole number from 1 to 20, got True'
    """

    unit: str
    least: float
    most: float
    is_open: bool = False
    """Whether `least` is excluded from the range."""
    is_whole: bool = False
    """Whether the range contains only whole numbers."""
    may_be_infinite: bool = False
    """Whether `math.inf` is allowed, which means no limit."""

    def problem(self, value: object) -> str | None:
        """Return the error message for a value, without the value's name; None if the value is allowed."""
        number = value if type(value) is float else _number(value)
        if number is not None and self.least <= number <= self.most:
            good = number > self.least + _TINY or not self.is_open
            if good and (not self.is_whole or type(value) is int or _is_whole(value)):
                return None
        if self.may_be_infinite and number == math.inf:
            return None
        hint = "" if number is None or abs(number) <= self.most else self.in_other_units(number)
        return f"must be {self}, got {shown(value)}{hint}"

    def in_other_units(self, number: float) -> str:
        """Return a hint with the SI value if the number is plausible in another unit; empty otherwise."""
        for name, size in _OTHER_UNITS.get(self.unit, ()):
            if self.least <= number * size <= self.most:
                return f". As {name} that is {number * size:.3g} {self.unit}"
        return ""

    def __str__(self) -> str:
        least, most = (f"{bound:.0f}" if self.is_whole else f"{bound:g}" for bound in (self.least, self.most))
        kind = "a whole number" if self.is_whole else "a number"
        text = f"{kind} above {least} and up to" if self.is_open else f"{kind} from {least} to"
        text += f" {most}{f' {self.unit}' if self.unit else ''}"
        return f"{text}, or math.inf for no limit" if self.may_be_infinite else text


MASS = Quantity("kg", 0.0, 1000.0, is_open=True)
MASS_OR_NONE = Quantity("kg", 0.0, 1000.0)
ROBOT_LENGTH = Quantity("m", 0.0, 3.0, is_open=True)
"""Length of a robot part or of a game piece."""
WHEEL_RADIUS = Quantity("m", 0.0, 0.3, is_open=True)
"""Radius of wheels, rollers, drums and pinions."""
ROBOT_HEIGHT = Quantity("m", 0.0, 3.0)
ROBOT_PLACE = Quantity("m", -3.0, 3.0)
"""Coordinate of a position in the robot frame, or position along a mechanism's travel."""
FIELD_LENGTH = Quantity("m", 0.0, 100.0, is_open=True)
FIELD_PLACE = Quantity("m", -100.0, 100.0)
ANGLE = Quantity("rad", -10_000.0, 10_000.0)
POSE = (FIELD_PLACE, FIELD_PLACE, ANGLE)
"""Coordinates x and y, and heading, of a pose in the field frame."""
ATTITUDE = (Quantity("", -1e6, 1e6),) * 4
"""Components x, y, z, w of a unit quaternion; `require_fields` and `require_attitude` also check the norm."""
START = (FIELD_PLACE, FIELD_PLACE, Quantity("rad", -math.tau, math.tau))
"""Coordinates x and y, and heading, of a start pose that a user enters.

A heading of more than one turn is rejected, because the user has probably entered degrees.
"""
DEGREES = Quantity("deg", -36_000.0, 36_000.0)
FIELD_OF_VIEW = Quantity("deg", 1.0, 179.0)
NOISE_DEGREES = Quantity("deg", 0.0, 360.0)
SPEED = Quantity("m/s", 0.0, 100.0)
SLIP_SPEED = Quantity("m/s", 0.0, 10.0, is_open=True)
TURN_RATE = Quantity("rad/s", 0.0, 10_000.0, is_open=True)
TURN_RATE_OR_NONE = Quantity("rad/s", 0.0, 10_000.0)
ACCELERATION = Quantity("m/s^2", 0.0, 1000.0)
INERTIA = Quantity("kg m^2", 0.0, 1000.0, is_open=True)
INERTIA_OR_NONE = Quantity("kg m^2", 0.0, 1000.0)
TORQUE = Quantity("N m", 0.0, 10_000.0, is_open=True)
TORQUE_OR_NONE = Quantity("N m", 0.0, 10_000.0)
VOLTAGE = Quantity("V", 0.0, 100.0, is_open=True)
VOLTAGE_OR_NONE = Quantity("V", 0.0, 100.0)
SIGNED_VOLTAGE = Quantity("V", -100.0, 100.0)
CURRENT = Quantity("A", 0.0, 10_000.0, is_open=True)
CURRENT_OR_NONE = Quantity("A", 0.0, 10_000.0)
CURRENT_LIMIT = Quantity("A", 0.0, 10_000.0, may_be_infinite=True)
RESISTANCE = Quantity("ohm", 0.0, 100.0)
FORCE = Quantity("N", 0.0, 10_000.0, is_open=True)
FORCE_OR_NONE = Quantity("N", 0.0, 10_000.0)
STIFFNESS = Quantity("N/m", 0.0, 1e9, is_open=True)
DELAY = Quantity("s", 0.0, 100.0)
DURATION = Quantity("s", 0.0, 1e6, is_open=True)
RATE = Quantity("1/s", 0.0, 1000.0, is_open=True)
FRAME_RATE = Quantity("1/s", 0.0, 500.0, is_open=True)
PIXELS = Quantity("px", 1, 10_000, is_whole=True)
NOISE_PIXELS = Quantity("px", 0.0, 1000.0)
FRACTION = Quantity("", 0.0, 1.0)
EFFICIENCY = Quantity("", 0.0, 1.0, is_open=True)
SPEED_SHARE = Quantity("", 0.3, 1.5)
FRICTION = Quantity("", 0.0, 10.0)
FACTOR = Quantity("", 0.0, 1000.0)
POSITIVE = Quantity("", 0.0, 1000.0, is_open=True)
GEARING = Quantity("", 0.0, 10_000.0, is_open=True)
"""Reduction of a gearbox: motor rotor turns per turn of the driven part [-]."""
RATIO = Quantity("", -1000.0, 1000.0)
GAIN = Quantity("", 0.0, 1e6)
COUNT = Quantity("", 0, 10_000, is_whole=True)
MOTORS = Quantity("", 1, 20, is_whole=True)
PORT = Quantity("", 0, 65_535, is_whole=True)

Row: TypeAlias = "tuple[Quantity | Row, ...] | list[Quantity | Row]"
"""Quantity of each number in a row, possibly nested; a list with one quantity is for rows of any length."""


def require(owner: str, name: str, value: object, quantity: Quantity) -> None:
    """Check that a value is a number in the allowed range.

    Args:
        owner: Name of the config or function that has the number, for the error message.
        name: Name of the number, for the error message.
        value: Value to check, of any type.
        quantity: Allowed range and unit.

    Raises:
        ConfigError: If the value is not allowed; the message states the value, the allowed values and the unit.

    >>> require("ArmConfig", "mass", "5", MASS)
    Traceback (most recent call last):
    simcore.errors.ConfigError: ArmConfig: mass must be a number above 0 and up to 1000 kg, got '5'
    """
    problem = quantity.problem(value)
    if problem is not None:
        raise ConfigError(f"{owner}: {name} {problem}")


def checked_number(what: str, value: Any) -> float:
    """Return a commanded value as a Python float after checking the value.

    Args:
        what: Name of the command, for the error message.
        value: Value to check, of any type.

    Raises:
        NonFiniteError: If the value is not a number, not finite or above 1e6 in magnitude.
    """
    number = value if type(value) is float else _number(value)
    if number is None or not abs(number) <= _MOST_COMMANDED:
        raise NonFiniteError(f"{what} must be a finite number, got {shown(value)}")
    return number


def require_row(owner: str, name: str, values: Any, row: Row) -> None:
    """Check the length of a row of numbers, e.g. a position, and check each number against a quantity.

    Raises:
        ConfigError: If the length or a number is wrong; the message states the index of the number, from 0.
    """
    if isinstance(values, (str, bytes)) or (not isinstance(values, Sequence) and not hasattr(values, "__array__")):
        raise ConfigError(f"{owner}: {name} must be {row_text(row)}, got {shown(values)}")
    try:
        numbers = list(islice(values, _MOST_ITEMS + 1))
    except TypeError:  # a zero-dimensional array
        raise ConfigError(f"{owner}: {name} must be {row_text(row)}, got {shown(values)}") from None
    quantities = row * len(numbers) if isinstance(row, list) else row
    if len(numbers) != len(quantities) or len(numbers) > _MOST_ITEMS:
        raise ConfigError(f"{owner}: {name} must be {row_text(row)}, got {shown(values)}")
    for number, (value, quantity) in enumerate(zip(numbers, quantities, strict=True)):
        check = require if isinstance(quantity, Quantity) else require_row
        check(owner, f"{name}[{number}]", value, quantity)  # type: ignore[arg-type]


def require_count(what: str, values: Any, count: int, things: str) -> None:
    """Check that a command has one value for each of `count` things, e.g. swerve modules.

    Raises:
        ConfigError: If `values` is not a sequence or array, or if the length is not `count`.
    """
    is_row = hasattr(values, "__len__") and not isinstance(values, (str, dict)) and getattr(values, "ndim", 1) > 0
    if not is_row or len(values) != count:
        got = len(values) if is_row else shown(values)
        raise ConfigError(f"{what}: need one value for each of {count} {things}, got {got}")


def require_attitude(owner: str, name: str, quat: Any) -> None:
    """Check that a value is a unit quaternion x, y, z, w.

    Raises:
        ConfigError: If the value is not a unit quaternion.
    """
    require_row(owner, name, quat, ATTITUDE)
    if not math.isclose(math.hypot(*quat), 1.0, abs_tol=1e-6):
        raise ConfigError(f"{owner}: {name} must be a unit quaternion x, y, z, w, got {shown(quat)}")


def require_points(owner: str, name: str, points: Any, quantity: Quantity, *, least: int = 0) -> None:
    """Check that a value is an array of at least `least` points, shape (n, 3), with all coordinates in a range.

    Raises:
        ConfigError: If the shape, the type or a coordinate is wrong; the message states the row and column, from 0.
    """
    import numpy as np  # imported here to save 0.1 s in commands that only print their options

    if isinstance(points, Sequence) and len(points) > _MOST_ITEMS:
        raise ConfigError(f"{owner}: {name} must be an array of shape (n >= {least}, 3), got {shown(points)}")
    array = points if isinstance(points, np.ndarray) else np.asarray(points, dtype=object)
    if array.ndim != 2 or array.shape[1] != 3 or array.dtype.kind not in "fiu" or len(array) < least:
        raise ConfigError(f"{owner}: {name} must be an array of shape (n >= {least}, 3), got {shown(points)}")
    inside = (array >= quantity.least) & (array <= quantity.most)
    if not inside.all():
        row, axis = (int(i) for i in np.argwhere(~inside)[0])
        require(owner, f"{name}[{row}, {axis}]", array[row, axis].item(), quantity)


def require_fields(config: DataclassInstance, owner: str = "", /, **fields: Quantity | Row) -> None:
    """Check all fields of a config, and convert numbers and lists; call this function first in `__post_init__`.

    A field without a quantity is checked against the declared type, e.g. a config, a string, a literal, or a tuple or
    dict of these types. The function replaces numbers of other libraries with Python numbers, and lists with tuples.

    Args:
        config: Config to check and change.
        owner: Name of the config in the error message; empty for the class name.
        fields: Quantity of each numeric field, or of each value of a field that is a dict. None is an allowed value if
            None is the field's default.

    Raises:
        ConfigError: If a field is invalid; the message states owner, field, value, allowed values and unit.
    """
    owner = f"{owner}" or type(config).__name__
    kinds = _field_types(type(config))
    for name, kind in kinds.items():
        if name in fields and get_origin(kind) is not Mapping:
            continue
        value = getattr(config, name)
        wrong = _misfit(name, value, kind)
        if wrong is not None:
            where, value, wanted = wrong
            raise ConfigError(f"{owner}: {where} must be {_type_text(wanted)}, got {_got(value)}")
        if get_origin(kind) is tuple and isinstance(value, list):  # lists are not hashable
            object.__setattr__(config, name, tuple(value))
    for name, quantity in fields.items():
        value = getattr(config, name)
        if value is None and config.__dataclass_fields__[name].default is None:
            continue
        if quantity is ATTITUDE:
            require_attitude(owner, name, value)
        elif not isinstance(quantity, Quantity):
            require_row(owner, name, value, quantity)
        elif get_origin(kinds.get(name)) is Mapping:
            for key, one in value.items():
                require(owner, f"{name}[{key!r}]", one, quantity)
        else:
            require(owner, name, value, quantity)
        plain = _plain(value)
        if get_origin(kinds.get(name)) is tuple:
            plain = _as_tuples(plain)
        if plain is not value:
            object.__setattr__(config, name, plain)


class _ByName(type):
    """Metaclass of placeholders for classes that a module imports only for type checking.

    `isinstance` accepts an object whose class or base class has the name of the placeholder.
    """

    def __instancecheck__(cls, value: object) -> bool:
        return any(base.__name__ == cls.__name__ for base in type(value).__mro__)


class _Names(dict[str, Any]):
    """Namespace in which a module's annotations are evaluated, with placeholder classes for unknown names."""

    def __missing__(self, name: str) -> Any:
        return getattr(builtins, name, None) or _ByName(name, (), {})


@cache
def _field_types(config: type[DataclassInstance]) -> dict[str, Any]:
    """Return the declared type of each field that the config's constructor sets, by name; base classes first."""
    types: dict[str, Any] = {}
    for base in reversed(config.__mro__):
        names = _Names(vars(sys.modules[base.__module__]))
        for name, text in inspect.get_annotations(base).items():
            field = config.__dataclass_fields__.get(name)
            if field is not None and field.init:
                types[name] = eval(text, {}, names) if isinstance(text, str) else text
    return types


def _misfit(name: str, value: Any, kind: Any) -> tuple[str, Any, Any] | None:
    """Return the path, value and declared type of the first part of a value that has a wrong type.

    The result is None if all types are right. Numbers are not checked.
    """
    origin, parts = get_origin(kind), get_args(kind)
    fits = True
    if origin in (Union, UnionType):
        fits = any(_misfit(name, value, part) is None for part in parts)
    elif origin is Literal:
        fits = isinstance(value, str) and value in parts
    elif origin in (tuple, Sequence):
        fits = isinstance(value, Sequence) and not isinstance(value, (str, bytes)) and len(value) <= _MOST_ITEMS
        if fits:
            kinds = parts[:1] * len(value) if origin is Sequence or parts[-1] is ... else parts
            fits = len(kinds) == len(value)
            for number, (one, part) in enumerate(zip(value, kinds, strict=False)):
                if fits and (wrong := _misfit(f"{name}[{number}]", one, part)) is not None:
                    return wrong
        elif hasattr(value, "__array__"):
            fits = parts[0] in (int, float) or get_origin(parts[0]) is tuple
    elif origin is Mapping:
        fits = isinstance(value, Mapping)
        for key, one in value.items() if fits else ():
            if wrong := _misfit(f"a name in {name}", key, parts[0]) or _misfit(f"{name}[{key!r}]", one, parts[1]):
                return wrong
    elif origin is Callable:
        fits = callable(value)
    elif isinstance(kind, type) and origin is None and kind not in (int, float, Any):
        fits = isinstance(value, kind)
    return None if fits else (name, value, kind)


def _got(value: object) -> str:
    return _type_text(type(value)) if hasattr(value, "__dataclass_fields__") else shown(value)


def _type_text(kind: Any) -> str:
    """Return the description of a type for error messages."""
    origin, parts = get_origin(kind), get_args(kind)
    if origin is Literal or origin in (Union, UnionType):
        texts = [repr(part) if origin is Literal else _type_text(part) for part in parts]
        return " or ".join((", ".join(texts[:-1]), texts[-1])) if len(texts) > 1 else texts[0]
    if origin in (tuple, Sequence):
        of = "" if len(parts) == 1 or parts[-1] is ... else f"{len(parts)}, each "
        return f"a tuple of {of}{_type_text(parts[0])}"
    if origin is Mapping:
        return f"a dict by name, each {_type_text(parts[1])}"
    if origin is Callable:
        return "a function"
    words = {NoneType: "None", bool: "True or False", str: "a string", int: "a whole number", float: "a number"}
    name = getattr(kind, "__name__", str(kind))
    return words.get(kind, f"{'an' if name[0] in 'AEIOU' else 'a'} {name}")


_OWN_BUSES = ("", "rio", "can_s2")
"""Names of the robot controller's default CAN bus: empty, `rio` (roboRIO) or `can_s2` (Systemcore, since 2027).

Source: `CANBus` of phoenix6 26.3.0 and 26.70.0a2.
"""


@dataclass(frozen=True, slots=True, order=True)
class DeviceAddress:
    """Address of a device on a CAN bus or on a port of the robot controller.

    >>> str(DeviceAddress(3, "canivore")), DeviceAddress(3, "rio") == DeviceAddress(3)
    ('canivore:3', True)
    >>> DeviceAddress.parse("canivore:3")
    DeviceAddress(number=3, bus='canivore')
    """

    number: int
    """CAN ID, or channel of the port."""
    bus: str = ""
    """Name of the CAN bus; empty for the robot controller's default bus."""

    FORM: ClassVar[str] = 'a whole number from 0 to 62, or as "canivore:3" on another bus'

    def __post_init__(self) -> None:
        if self.bus in _OWN_BUSES:
            object.__setattr__(self, "bus", "")

    def __str__(self) -> str:
        return f"{self.bus}:{self.number}" if self.bus else str(self.number)

    @property
    def in_file(self) -> int | str:
        """Address in the form of simcore.toml: the number alone for the default CAN bus, else `bus:number`."""
        return str(self) if self.bus else self.number

    @classmethod
    def parse(cls, value: object) -> DeviceAddress | None:
        """Parse an address from simcore.toml; return None if the value is not a valid address."""
        bus = ""
        if isinstance(value, str):
            bus, _, digits = value.rpartition(":")
            value = int(digits) if bus and digits.isdecimal() else None
        return cls(value, bus) if type(value) is int and 0 <= value <= 62 else None

    def among(self, built: Iterable[DeviceAddress]) -> DeviceAddress:
        """Return this address, with the bus taken from the addresses that the robot program has built.

        If this address has no bus and is not one of the built addresses, the method returns the built address with the
        same number, provided that there is exactly one such address.

        >>> DeviceAddress(3).among([DeviceAddress(3, "canivore"), DeviceAddress(4)])
        DeviceAddress(number=3, bus='canivore')
        """
        same = {one for one in built if one.number == self.number}
        return same.pop() if not self.bus and self not in same and len(same) == 1 else self


DeviceKey: TypeAlias = tuple[str, DeviceAddress]
"""Key of a device or port: the model name in the maker's spelling, and the address."""


def number_flag(quantity: Quantity) -> Callable[[str], float]:
    """Return an argparse `type` function that parses a number and rejects a number outside the range of a quantity.

    >>> number_flag(PORT)("99999")
    Traceback (most recent call last):
    argparse.ArgumentTypeError: must be a whole number from 0 to 65535, got '99999'
    """

    def read(text: str) -> float:
        try:
            number = int(text) if quantity.is_whole else float(text)
        except ValueError:
            number = math.nan
        if quantity.problem(number) is not None:
            raise ArgumentTypeError(f"must be {quantity}, got {shown(text)}")
        return number

    return read


def text_flag(read: Callable[[str], Any]) -> Callable[[str], Any]:
    """Return an argparse `type` function that calls `read`, and turns a `SimcoreError` into a usage error."""

    def checked(text: str) -> Any:
        try:
            return read(text)
        except SimcoreError as error:
            raise ArgumentTypeError(str(error)) from None

    return checked


def row_text(row: Quantity | Row) -> str:
    """Return a description of the allowed values of a number or row, for error messages."""
    if isinstance(row, Quantity):
        return str(row)
    if isinstance(row, list):
        return f"a row, each {row_text(row[0])}"
    units = ", ".join(part.unit or "-" if isinstance(part, Quantity) else row_text(part) for part in row)
    return f"{len(row)} numbers ({units})"


def shown(value: object) -> str:
    """Return the `repr` of a value for error messages; shorten a text of more than 80 characters."""
    try:
        text = repr(value)
    except Exception:  # more than 4300 digits, too deeply nested, or a broken __repr__
        text = f"{type(value).__name__} that cannot be shown"
    return text if len(text) <= 80 else f"{text[:60]}... ({len(text)} characters)"


def _number(value: object) -> float | None:
    """Return a number as a float; None for a boolean, a value of another type, or a number too large for a float."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return None
    try:
        return float(value)
    except OverflowError:  # an integer with more than 308 digits
        return None


def _plain(value: Any) -> Any:
    """Return a value with all numbers of other types (numpy float16, Fraction) converted to Python numbers.

    Compiled code requires Python numbers. The function converts rows and dicts recursively, and returns other values
    unchanged.
    """
    if isinstance(value, Mapping):
        plain = {key: _plain(one) for key, one in value.items()}
        return value if all(plain[key] is one for key, one in value.items()) else plain
    if isinstance(value, (tuple, list)):
        row = [_plain(one) for one in value]
        return value if all(new is old for new, old in zip(row, value, strict=True)) else tuple(row)
    if getattr(value, "ndim", 0) and value.dtype.kind == "f":
        return value.astype(float, copy=False)
    if type(value) is float:
        return value or 0.0  # replace -0.0, so that a range from -x to x has the bound 0.0
    if type(value) in (bool, int) or not isinstance(value, Real):
        return value
    return value.__index__() if hasattr(value, "__index__") else float(value)


def _as_tuples(value: Any) -> Any:
    """Return a row with all nested lists and arrays converted to tuples, which are hashable."""
    if getattr(value, "ndim", 0):
        return _as_tuples(value.tolist())
    if not isinstance(value, (tuple, list)):
        return value
    row = tuple(_as_tuples(one) for one in value)
    is_same = isinstance(value, tuple) and all(new is old for new, old in zip(row, value, strict=True))
    return value if is_same else row


def _is_whole(value: object) -> bool:
    return hasattr(value, "__index__")
