"""What a check found."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

__all__ = ["Finding", "Level", "fail", "ok", "warn"]


class Level(Enum):
    """How bad it is."""

    OK = "ok"
    WARN = "warn"
    """It works, but somebody will wonder."""
    FAIL = "fail"
    """It cannot work."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One line of the report."""

    check: str
    """What was looked at, in a word or two."""
    level: Level
    text: str
    """What is there."""
    advice: str = ""
    """What to do about it; empty where all is well."""


def ok(check: str, text: str) -> Finding:
    """All is well."""
    return Finding(check=check, level=Level.OK, text=text)


def warn(check: str, text: str, advice: str) -> Finding:
    """It works, but somebody will wonder."""
    return Finding(check=check, level=Level.WARN, text=text, advice=advice)


def fail(check: str, text: str, advice: str) -> Finding:
    """It cannot work."""
    return Finding(check=check, level=Level.FAIL, text=text, advice=advice)
