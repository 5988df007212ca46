"""Colors of pictures, pages and animations, so that a shot that hit is the same green everywhere."""

from __future__ import annotations

__all__ = ["CARPET", "FUEL", "FUEL_EDGE", "FUEL_IN_AIR", "GRID", "HIT", "INK", "MISS", "MUTED", "PATH", "rgb", "tint"]

CARPET, INK, MUTED, GRID = "#d3d6da", "#20242b", "#5b6470", "#dfe2e6"
HIT, MISS = "#0e8a43", "#e0620d"
FUEL, FUEL_IN_AIR, FUEL_EDGE = "#ffd923", "#ff9800", "#7d6400"
PATH = "#6a3fb5"
"""A hue that neither pieces, shots nor alliances use."""

_TINTS = {"blue": ("#9db4dd", "#2f5fae"), "red": ("#e3a9a6", "#b3312b")}
_NEUTRAL = ("#b4b9c0", "#7d858f")


def tint(name: str) -> tuple[str, str]:
    """Fill and edge of what belongs to an alliance, by its name or by one that begins so.

    >>> tint("blue_hub")
    ('#9db4dd', '#2f5fae')
    """
    return next((colors for alliance, colors in _TINTS.items() if name.lower().startswith(alliance)), _NEUTRAL)


def rgb(color: str) -> tuple[int, int, int]:
    """As whole numbers of 0 to 255.

    >>> rgb("#0e8a43")
    (14, 138, 67)
    """
    return int(color[1:3], 16), int(color[3:5], 16), int(color[5:7], 16)
