"""Conversions to SI units, standard gravity, the length of a tick, and a reproducible sum.

Code contains dimensions in the units that the game manual prints, and converts the dimensions with these functions.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

__all__ = ["GRAVITY", "TICK", "degrees", "feet", "inches", "plain_sum", "pounds", "rpm"]

GRAVITY = 9.80665
"""Standard gravity [m/s^2] (CGPM 1901)."""

TICK = 0.02
"""Length of a tick [s], the default period of a TimedRobot."""


def inches(value: float) -> float:
    """Convert a length in inches to meters.

    >>> inches(47)
    1.1938
    """
    return value * 0.0254


def feet(value: float) -> float:
    """Convert a length in feet to meters."""
    return value * 0.3048


def pounds(value: float) -> float:
    """Convert a mass in pounds (avoirdupois) to kilograms."""
    return value * 0.45359237


def degrees(value: float) -> float:
    """Convert an angle in degrees to radians."""
    return math.radians(value)


def rpm(value: float) -> float:
    """Convert revolutions per minute to radians per second."""
    return value * math.tau / 60.0


def plain_sum(values: Iterable[float]) -> float:
    """Return the sum of values, added from left to right, with the same bits in every Python version.

    The builtin `sum` compensates for rounding errors of floats since Python 3.12. A simulation that uses `sum` would
    therefore give other results in older versions of Python.

    >>> plain_sum([0.1] * 10)
    0.9999999999999999
    """
    total = 0.0
    for value in values:
        total += value
    return total
