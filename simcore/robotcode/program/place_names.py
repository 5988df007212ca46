"""Sides and corners of the robot in attribute names: `left_leader`, `frontLeft`, `BR`, `lf_drive`."""

from __future__ import annotations

import re

__all__ = ["CORNERS", "SIDES", "corner_of", "says_place", "words_of"]

SIDES = {"left": r"left|\b(port|[fmrb]?l|l[fmrb])\b", "right": r"right|starboard|\b([fmrb]?r|r[fmb])\b"}
"""Patterns for each side: whole words, and abbreviations such as `l`, `fl`, `rr`, `lf`."""
CORNERS = ("front left", "front right", "rear left", "rear right")


def words_of(name: str) -> str:
    """Return the last attribute of a path in lower-case words, split at capitals, numbers, `_` and `-`.

    >>> words_of("base.motorL1"), words_of("LDrive"), words_of("fl_motor")
    ('motor l 1', 'l drive', 'fl motor')
    """
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])|(?<=[A-Za-z])(?=\d)", " ", name.split(".")[-1])
    return spaced.replace("_", " ").replace("-", " ").lower()


def says_place(name: str, place: str) -> bool:
    """Return whether the last attribute of a path names the given side or corner.

    Args:
        name: Attribute path: `base.motorL1`.
        place: Side (`left`, `right`) or corner (`front left`).
    """
    return re.search(SIDES.get(place) or _corner_pattern(place), words_of(name)) is not None


def corner_of(name: str) -> tuple[int, int] | None:
    """Return the corner in the last attribute that names one corner, as signs of x and y (front, left: 1), or None.

    >>> corner_of("drive.frontLeft"), corner_of("drivetrain.modules.BR"), corner_of("rf.io"), corner_of("modules.0")
    ((1, 1), (-1, -1), (1, -1), None)
    """
    for part in reversed(name.split(".")):
        said = [corner for corner in CORNERS if says_place(part, corner)]
        if len(said) == 1:
            return (1 if said[0].startswith("front") else -1), (1 if said[0].endswith("left") else -1)
    return None


def _corner_pattern(corner: str) -> str:
    end, side = corner.split()
    ends, first = ("front", "f") if end == "front" else ("(rear|back)", "[rb]")
    letter = side[0]
    sides = rf"({side}|\b{letter}\b)"
    return rf"{ends}.*{sides}|{sides}.*{ends}|\b({first}{letter}|{letter}{first})\b"
