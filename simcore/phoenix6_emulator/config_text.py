"""The text in which Phoenix 6 sends configurations to a device and reads them back.

One setting a line, `number,kind_value`: the library writes `1877,f_0.5` (f: number, s: integer or enum, b: boolean,
p: pair); a device answers every kind with `s_` and the 32 bits of the value, numbers as IEEE 754 single precision.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping

__all__ = ["Setting", "answer", "bits_of", "number_of", "parse", "single", "write"]

Setting = float | int
"""A number (kind f) or an integer, enum or boolean (kinds s and b)."""

_FLOAT = struct.Struct("<f")
_INT = struct.Struct("<i")


def single(value: float) -> float:
    """The value as a device keeps it, in single precision."""
    return float(_FLOAT.unpack(_FLOAT.pack(value))[0])


def bits_of(value: float) -> int:
    """The 32 bits of a single-precision number, as a signed integer."""
    return int(_INT.unpack(_FLOAT.pack(value))[0])


def number_of(bits: int) -> float:
    """The single-precision number with these 32 bits."""
    return float(_FLOAT.unpack(_INT.pack(bits))[0])


def write(spn: int, kind: str, value: float | int) -> str:
    """One line as the library sends it."""
    return f"{spn},{kind}_{value:.9g}\n" if kind == "f" else f"{spn},{kind}_{int(value)}\n"


def parse(text: str) -> dict[int, Setting]:
    """Settings by number; a number is a float, everything else an int.

    Raises:
        ValueError: A line does not have the form `number,kind_value`.
    """
    settings: dict[int, Setting] = {}
    for line in text.split():
        try:
            spn, value = line.split(",", 1)
            kind, _, digits = value.partition("_")
            if kind == "f":
                settings[int(spn)] = single(float(digits))
            elif kind in ("s", "b"):
                settings[int(spn)] = int(digits)
            else:
                raise ValueError(kind)
        except ValueError as error:
            raise ValueError(f"config line {line!r} is not of the form 'number,f_1.5' (kinds f, s, b)") from error
    return settings


def answer(settings: Mapping[int, Setting]) -> str:
    """What a device sends when its configuration is read."""
    return "".join(
        f"{spn},s_{bits_of(value) if isinstance(value, float) else value}\n" for spn, value in settings.items()
    )
