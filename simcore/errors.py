"""Error types, each derived from the builtin error that a caller expects, and functions that report errors."""

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
    """Base class of all errors that simcore raises on purpose."""


class ConfigError(SimcoreError, ValueError):
    """Invalid setting; the message states the setting, the value and the allowed values."""


class NonFiniteError(SimcoreError, ValueError):
    """NaN or infinity where physics needs a finite number."""


class CapacityError(SimcoreError, RuntimeError):
    """Request for more game pieces than are available, or for a piece that a robot does not hold."""


class EngineError(SimcoreError, RuntimeError):
    """Physics engine that is missing, is closed or rejected a call."""


class FieldMeshError(SimcoreError, ValueError):
    """Field mesh that cannot be used."""


class OutputError(SimcoreError, OSError):
    """Log, page or other output that cannot be written."""


class VendorError(SimcoreError, ImportError):
    """Vendor library that is missing or from an unsupported year."""


class LogError(SimcoreError, ValueError):
    """Log that cannot be read."""


class ModelError(SimcoreError, ValueError):
    """Model folder that AdvantageScope or the browser view cannot use."""


class UnknownNameError(SimcoreError, KeyError):
    """Unknown name; the message lists up to three similar names and all known names."""

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        self.kind = kind
        self.name = name
        self.known = sorted(known)
        self.nearest = _near(name, self.known, 3)
        self.message = f"no {kind} named {name!r}.{_question(self.nearest)} Known: {self.known}"
        super().__init__(self.message)

    def __str__(self) -> str:
        return self.message  # KeyError would show the repr of the message


def nearest(name: str, known: Iterable[str]) -> str:
    """Return the question "Did you mean ...?" for an unknown name; empty if no known name is similar."""
    return _question(_near(name, sorted(known), 1))


def _near(name: str, known: list[str], most: int) -> list[str]:
    return difflib.get_close_matches(str(name), known, n=most, cutoff=0.5)  # robot code may pass None


def _question(near: list[str]) -> str:
    return f" Did you mean {' or '.join(map(repr, near))}?" if near else ""


def home_of(name: str) -> str:
    """Return the simcore module that defines a class or function; empty if no module does.

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
        program: Program name as called.
        sentence: Error message.
    """
    sys.stdout.flush()
    print(f"\n{program}: {sentence}", file=sys.stderr, flush=True)


def start_sentence(error: BaseException, folder: Path, *, base: Path | None = None) -> str:
    """Return the message of a start error, with file and line if the error passed through a project's code.

    >>> start_sentence(SimcoreError("mass must be > 0 kg, got -1"), Path("/project"))
    'mass must be > 0 kg, got -1'

    Args:
        error: Error that was caught.
        folder: Folder of the project, or its only file; only lines in the project's own files are named.
        base: Folder to which paths are relative; None for `folder`.
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
    """Report an error and exit at once with status 1, as threads of vendor libraries may crash during a normal exit.

    An error that simcore raises on purpose is reported in one sentence. For any other error, a mistake in the project's
    code or in simcore, a traceback from the first line of the project's code precedes the sentence.

    Args:
        error: Error that prevents the program from starting.
        program: Program name as called.
        folder: Folder of the project.
    """
    if not isinstance(error, SimcoreError):
        sys.stdout.flush()
        start = next((at for at in _places(error) if _is_in(_file(at), folder)), error.__traceback__)
        traceback.print_exception(type(error), error, start)
    print_error(program, start_sentence(error, folder))
    os._exit(1)


def outside_part(error: BaseException) -> TracebackType | None:
    """Return the traceback of an error from the first frame of game or robot code; None without game or robot code."""
    here, python = Path(__file__).resolve().parent, Path(traceback.__file__).resolve().parent
    for at in _places(error):
        path = Path(_file(at)).resolve()
        is_library = path.is_relative_to(python) or "site-packages" in path.parts
        if path.is_file() and not is_library and not path.is_relative_to(here):
            return at
    return None


def _moved(error: BaseException) -> str:
    """Return a hint to the new modules of names imported from a former simcore module, to append to a sentence."""
    asked = str(getattr(error, "name", "") or "")
    if not isinstance(error, ImportError) or asked.partition(".")[0] != "simcore":
        return ""
    lines = [linecache.getline(_file(at), at.tb_lineno) for at in _places(error)]
    line = next((line for line in reversed(lines) if f"from {asked}" in line), "")
    names = re.findall(r"\w+", line.partition(" import ")[2].partition("#")[0])
    homes = {name: home for name in names if (home := home_of(name)) not in ("", asked)}
    return "".join(f"; now from {home} import {name}" for name, home in homes.items())


def _places(error: BaseException) -> Iterator[TracebackType]:
    """Yield the traceback entries of an error, innermost last."""
    at = error.__traceback__
    while at is not None:
        yield at
        at = at.tb_next


def _file(at: TracebackType) -> str:
    return at.tb_frame.f_code.co_filename


def _is_in(file: str, folder: Path) -> bool:
    """Return whether a file belongs to a project instead of Python or a library installed in the project's folder."""
    path, folder = Path(file).resolve(), folder.resolve()
    own = path.is_file() and path.is_relative_to(folder)
    return own and "site-packages" not in path.relative_to(folder).parts
