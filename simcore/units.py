"""Units of the game manual turned into SI, so that numbers can be written as they are printed, and a portable sum."""

from __future__ import annotations

import math
from collections.abc import Iterable

__all__ = ["GRAVITY", "TICK", "degrees", "feet", "inches", "plain_sum", "pounds", "rpm"]

GRAVITY = 9.80665
"""Standard gravity [m/s^2] (CGPM 1901)."""

TICK = 0.02
"""Length of a tick [s]: the loop of a TimedRobot."""


def inches(value: float) -> float:
    """Length in inches as meters.

    >>> inches(47)
    1.1938
    """
    return value * 0.0254


def feet(value: float) -> float:
    """Length in feet as meters."""
    return value * 0.3048


def pounds(value: float) -> float:
    """Mass in pounds (avoirdupois) as kilograms."""
    return value * 0.45359237


def degrees(value: float) -> float:
    """Angle in degrees as radians."""
    return math.radians(value)


def rpm(value: float) -> float:
    """Revolutions per minute as radians per second."""
    return value * math.tau / 60.0


def plain_sum(values: Iterable[float]) -> float:
    """Sum from left to right, the same to the last bit on every Python.

    The builtin `sum` of floats keeps the rounding errors and adds them at the end since Python 3.12, and does not
    before: a simulation that used it would differ between versions.

    >>> plain_sum([0.1] * 10)
    0.9999999999999999
    """
    total = 0.0
    for value in values:
        total += value
    return total
