"""How a program that cannot start ends: one sentence, the last on the screen, and a status that is not zero."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import NoReturn

from simcore.errors import SimcoreError

__all__ = ["leave", "print_error", "start_sentence"]


def print_error(program: str, sentence: str) -> None:
    """Print what is wrong after a blank line, behind all that was printed before.

    Args:
        program: Who says it, as it was called.
        sentence: What was wrong, what was got and what would work.
    """
    sys.stdout.flush()
    print(f"\n{program}: {sentence}", file=sys.stderr, flush=True)


def start_sentence(error: BaseException, folder: Path) -> str:
    """What a start error says, and where in the files of a project it comes from.

    >>> start_sentence(SimcoreError("mass must be > 0 kg, got -1"), Path("/project"))
    'mass must be > 0 kg, got -1'

    Args:
        error: As it was caught.
        folder: Of the project; a place in its own files is named, one in a library is not.
    """
    text = str(error) if isinstance(error, SimcoreError) else f"{type(error).__name__}: {error}"
    own = [at for at in _places(error) if _is_in(at, folder)]
    return f"{Path(_file(own[-1])).name}, line {own[-1].tb_lineno}: {text}" if own else text


def leave(error: BaseException, *, program: str, folder: Path) -> NoReturn:
    """End the process now: threads of vendors' libraries, which may crash while a program ends, do not run on.

    An error that simcore raises on purpose is one sentence. Any other is a mistake of the project's code, or of
    simcore's own: its traceback stands before the sentence, from where the project's code begins.

    Args:
        error: Why the program cannot start.
        program: As it was called.
        folder: Of the project.
    """
    if not isinstance(error, SimcoreError):
        sys.stdout.flush()
        start = next((at for at in _places(error) if _is_in(at, folder)), error.__traceback__)
        traceback.print_exception(type(error), error, start)
    print_error(program, start_sentence(error, folder))
    os._exit(1)


def _places(error: BaseException) -> Iterator[TracebackType]:
    """Where an error came by, the innermost last."""
    at = error.__traceback__
    while at is not None:
        yield at
        at = at.tb_next


def _file(at: TracebackType) -> str:
    return at.tb_frame.f_code.co_filename


def _is_in(at: TracebackType, folder: Path) -> bool:
    """Whether it is in a file of the project: not in Python's own, nor in a library that is installed below."""
    path = Path(_file(at))
    return path.is_file() and path.resolve().is_relative_to(folder.resolve()) and "site-packages" not in path.parts
