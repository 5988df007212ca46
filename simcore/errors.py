"""What can go wrong, as types: each also is the builtin error that a caller expects."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

__all__ = [
    "CapacityError",
    "ConfigError",
    "EngineError",
    "FieldMeshError",
    "LogError",
    "ModelError",
    "NonFiniteError",
    "OutputError",
    "SimcoreError",
    "UnknownNameError",
    "VendorError",
    "nearest",
]


class SimcoreError(Exception):
    """Base of every error that simcore raises on purpose."""


class ConfigError(SimcoreError, ValueError):
    """A setting that cannot work; the message says which, what was got and what would work."""


class NonFiniteError(SimcoreError, ValueError):
    """A NaN or an infinity where physics needs a number."""


class CapacityError(SimcoreError, RuntimeError):
    """More pieces than there is room for."""


class EngineError(SimcoreError, RuntimeError):
    """The physics engine is missing, closed, or refused a call."""


class FieldMeshError(SimcoreError, ValueError):
    """A field mesh that cannot be used."""


class OutputError(SimcoreError, OSError):
    """A log, picture or other output that cannot be written."""


class VendorError(SimcoreError, ImportError):
    """A vendor's library that is missing, or of a year that is not supported."""


class LogError(SimcoreError, ValueError):
    """A log that cannot be read."""


class ModelError(SimcoreError, ValueError):
    """A folder of models that AdvantageScope or the browser view cannot use."""


class UnknownNameError(SimcoreError, KeyError):
    """A name that nobody registered; carries the nearest ones."""

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        self.kind = kind
        self.name = name
        self.known = sorted(known)
        self.nearest = _near(name, self.known, 3)
        self.message = f"no {kind} named {name!r}.{_question(self.nearest)} Known: {self.known}"
        super().__init__(self.message)

    def __str__(self) -> str:
        return self.message  # KeyError would show the repr of it


def nearest(name: str, known: Iterable[str]) -> str:
    """The question after a name that is not known; empty where none is like it."""
    return _question(_near(name, sorted(known), 1))


def _near(name: str, known: list[str], most: int) -> list[str]:
    return difflib.get_close_matches(str(name), known, n=most, cutoff=0.5)  # robot code may give None


def _question(near: list[str]) -> str:
    return f" Did you mean {' or '.join(map(repr, near))}?" if near else ""
