"""Error types, each also the builtin error that a caller expects; and how a program ends with one."""

from __future__ import annotations

import difflib
import linecache
import os
import re
import sys
import traceback
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import TracebackType
from typing import NoReturn

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
    "home_of",
    "leave",
    "nearest",
    "outside_part",
    "print_error",
    "start_sentence",
]


class SimcoreError(Exception):
    """Base of all errors that simcore raises on purpose."""


class ConfigError(SimcoreError, ValueError):
    """Setting that cannot work; the message says which, what was got and what would work."""


class NonFiniteError(SimcoreError, ValueError):
    """NaN or infinity where physics needs a number."""


class CapacityError(SimcoreError, RuntimeError):
    """More pieces than there is room for."""


class EngineError(SimcoreError, RuntimeError):
    """Physics engine that is missing or closed, or that refused a call."""


class FieldMeshError(SimcoreError, ValueError):
    """Field mesh that cannot be used."""


class OutputError(SimcoreError, OSError):
    """Log, page or other output that cannot be written."""


class VendorError(SimcoreError, ImportError):
    """Vendor library that is missing or of an unsupported year."""


class LogError(SimcoreError, ValueError):
    """Log that cannot be read."""


class ModelError(SimcoreError, ValueError):
    """Folder of models that AdvantageScope or the browser view cannot use."""


class UnknownNameError(SimcoreError, KeyError):
    """Unknown name, with the nearest known ones."""

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
    """Return the question "Did you mean ...?" for an unknown name; empty without a similar one."""
    return _question(_near(name, sorted(known), 1))


def _near(name: str, known: list[str], most: int) -> list[str]:
    return difflib.get_close_matches(str(name), known, n=most, cutoff=0.5)  # robot code may pass None


def _question(near: list[str]) -> str:
    return f" Did you mean {' or '.join(map(repr, near))}?" if near else ""


def home_of(name: str) -> str:
    """Return the module of simcore that defines a class or function; empty for none.

    >>> home_of("PieceSupply"), home_of("PieceSuply")
    ('simcore.match.game', '')
    """
    folder = Path(__file__).parent
    for path in sorted(folder.rglob("*.py")):
        if re.search(rf"^(class|def) {re.escape(name)}\b", path.read_text(encoding="utf-8"), re.MULTILINE):
            return ".".join(path.relative_to(folder.parent).with_suffix("").parts)
    return ""


def print_error(program: str, sentence: str) -> None:
    """Print an error after a blank line and all earlier output.

    Args:
        program: Name of the program, as it was called.
        sentence: Message: what was wrong, what was got and what would work.
    """
    sys.stdout.flush()
    print(f"\n{program}: {sentence}", file=sys.stderr, flush=True)


def start_sentence(error: BaseException, folder: Path, *, base: Path | None = None) -> str:
    """Return the message of a start error with its place in the files of a project.

    >>> start_sentence(SimcoreError("mass must be > 0 kg, got -1"), Path("/project"))
    'mass must be > 0 kg, got -1'

    Args:
        error: Error that was caught.
        folder: Folder of the project, or its only file; places in its own files are named, those in libraries are not.
        base: Folder to which paths are relative; None: the project's.
    """
    text = str(error) if isinstance(error, SimcoreError) else f"{type(error).__name__}: {error}{_moved(error)}"
    own = [(_file(at), at.tb_lineno) for at in _places(error) if _is_in(_file(at), folder)]
    if isinstance(error, SyntaxError) and error.filename and _is_in(error.filename, folder):
        text = f"{type(error).__name__}: {error.msg}"
        own.append((error.filename, error.lineno or 1))
    if not own:
        return text
    file, line = own[-1]
    name = Path(file).resolve().relative_to((base or folder).resolve())
    return f"{name.as_posix()}, line {line}: {text}"


def leave(error: BaseException, *, program: str, folder: Path) -> NoReturn:
    """End the process at once: threads of vendors' libraries may crash while a program ends.

    An error that simcore raises on purpose is one sentence. Any other is a mistake in the project's code or in simcore:
    its traceback comes before the sentence, from where the project's code begins.

    Args:
        error: Reason why the program cannot start.
        program: Name of the program, as it was called.
        folder: Folder of the project.
    """
    if not isinstance(error, SimcoreError):
        sys.stdout.flush()
        start = next((at for at in _places(error) if _is_in(_file(at), folder)), error.__traceback__)
        traceback.print_exception(type(error), error, start)
    print_error(program, start_sentence(error, folder))
    os._exit(1)


def outside_part(error: BaseException) -> TracebackType | None:
    """Return the traceback of an error from where a game's or a robot's code begins; None if all of it is simcore's."""
    here, python = Path(__file__).resolve().parent, Path(traceback.__file__).resolve().parent
    for at in _places(error):
        path = Path(_file(at)).resolve()
        is_library = path.is_relative_to(python) or "site-packages" in path.parts
        if path.is_file() and not is_library and not path.is_relative_to(here):
            return at
    return None


def _moved(error: BaseException) -> str:
    """Return the new modules of names imported from a former module of simcore, to follow a sentence."""
    asked = str(getattr(error, "name", "") or "")
    if not isinstance(error, ImportError) or asked.partition(".")[0] != "simcore":
        return ""
    lines = [linecache.getline(_file(at), at.tb_lineno) for at in _places(error)]
    line = next((line for line in reversed(lines) if f"from {asked}" in line), "")
    names = re.findall(r"\w+", line.partition(" import ")[2].partition("#")[0])
    homes = {name: home for name in names if (home := home_of(name)) not in ("", asked)}
    return "".join(f"; now from {home} import {name}" for name, home in homes.items())


def _places(error: BaseException) -> Iterator[TracebackType]:
    """Yield the places that an error passed, the innermost last."""
    at = error.__traceback__
    while at is not None:
        yield at
        at = at.tb_next


def _file(at: TracebackType) -> str:
    return at.tb_frame.f_code.co_filename


def _is_in(file: str, folder: Path) -> bool:
    """Return whether a file belongs to the project: neither Python's own, nor in a library installed below."""
    path, folder = Path(file).resolve(), folder.resolve()
    own = path.is_file() and path.is_relative_to(folder)
    return own and "site-packages" not in path.relative_to(folder).parts
