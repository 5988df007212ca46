"""Units of the game manual turned into SI, so that numbers can be written as they are printed."""

from __future__ import annotations

import math

__all__ = ["GRAVITY", "TICK", "degrees", "feet", "inches", "pounds", "rpm"]

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
