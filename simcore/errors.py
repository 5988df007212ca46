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
    """Value that is NaN, infinite, too large or not a number, where a finite number is required."""


class CapacityError(SimcoreError, RuntimeError):
    """Request for more game pieces or more storage space than available, or for a piece that a robot does not hold."""


class EngineError(SimcoreError, RuntimeError):
    """Physics engine that is not installed or closed, rejects a request, or reaches a state that is not finite."""


class FieldMeshError(SimcoreError, ValueError):
    """Field mesh that is unreadable, empty or too large."""


class OutputError(SimcoreError, OSError):
    """Log, page or other output that cannot be written, or that is closed."""


class VendorError(SimcoreError, ImportError):
    """Vendor library or optional package that is not installed or has an unsupported version."""


class LogError(SimcoreError, ValueError):
    """Log that cannot be read or lacks the required signals."""


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
    """Return " Did you mean 'x'?" for the known name x most similar to a name; empty if no known name is similar."""
    return _question(_near(name, sorted(known), 1))


def _near(name: str, known: list[str], most: int) -> list[str]:
    return difflib.get_close_matches(str(name), known, n=most, cutoff=0.5)  # robot code may pass None


def _question(near: list[str]) -> str:
    return f" Did you mean {' or '.join(map(repr, near))}?" if near else ""


def home_of(name: str) -> str:
    """Return the name of the simcore module that defines a top-level class or function; empty for any other name.

    >>> home_of("PieceSupply"), home_of("PieceSuply")
    ('simcore.match.game', '')
    """
    folder = Path(__file__).parent
    for path in sorted(folder.rglob("*.py")):
        if re.search(rf"^(class|def) {re.escape(name)}\b", path.read_text(encoding="utf-8"), re.MULTILINE):
            return ".".join(path.relative_to(folder.parent).with_suffix("").parts)
    return ""


def print_error(program: str, sentence: str) -> None:
    """Flush standard output, then print a blank line and an error message to standard error.

    Args:
        program: Program name as entered by the user, printed before the message.
        sentence: Error message.
    """
    sys.stdout.flush()
    print(f"\n{program}: {sentence}", file=sys.stderr, flush=True)


def start_sentence(error: BaseException, folder: Path, *, base: Path | None = None) -> str:
    """Return the message for an error that prevents a program from starting.

    The message begins with the file and line of the innermost traceback entry in the project's code, if there is one.

    >>> start_sentence(SimcoreError("mass must be > 0 kg, got -1"), Path("/project"))
    'mass must be > 0 kg, got -1'

    Args:
        error: Error that was caught.
        folder: Folder of the project, or the file of a project with a single file.
        base: Folder to which the path in the message is relative; None for `folder`.
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
    """Report an error and end the process at once with exit status 1.

    The process skips the normal exit, during which threads of vendor libraries may crash. A `SimcoreError` is reported
    in one sentence. Any other error is a mistake in the project's code or in simcore. For such an error, the function
    first prints the traceback, without the entries before the project's code.

    Args:
        error: Error that prevents the program from starting.
        program: Program name as entered by the user.
        folder: Folder of the project.
    """
    if not isinstance(error, SimcoreError):
        sys.stdout.flush()
        start = next((at for at in _places(error) if _is_in(_file(at), folder)), error.__traceback__)
        traceback.print_exception(type(error), error, start)
    print_error(program, start_sentence(error, folder))
    os._exit(1)


def outside_part(error: BaseException) -> TracebackType | None:
    """Return the part of an error's traceback that starts at the first frame in game or robot code.

    The result is None if all frames are in simcore, Python's standard library or installed packages.
    """
    here, python = Path(__file__).resolve().parent, Path(traceback.__file__).resolve().parent
    for at in _places(error):
        path = Path(_file(at)).resolve()
        is_library = path.is_relative_to(python) or "site-packages" in path.parts
        if path.is_file() and not is_library and not path.is_relative_to(here):
            return at
    return None


def _moved(error: BaseException) -> str:
    """Return a hint for an import that fails because simcore now defines the imported names in other modules.

    The hint states the new module of each name, and is worded for the end of a message. The hint is empty for any other
    error.
    """
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
    """Return whether a file exists in a project's folder, but not in a `site-packages` folder of the project."""
    path, folder = Path(file).resolve(), folder.resolve()
    own = path.is_file() and path.is_relative_to(folder)
    return own and "site-packages" not in path.relative_to(folder).parts
