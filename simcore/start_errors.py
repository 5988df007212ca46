"""How a program that cannot start ends: one sentence, the last on the screen, and a status that is not zero."""

from __future__ import annotations

import os
import sys
import traceback
from pathlib import Path
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
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if Path(frame.filename).resolve().is_relative_to(folder.resolve())]
    own = [frame for frame in own if "site-packages" not in Path(frame.filename).parts]
    return f"{Path(own[-1].filename).name}, line {own[-1].lineno}: {text}" if own else text


def leave(error: BaseException, *, program: str, folder: Path) -> NoReturn:
    """End the process now: threads of vendors' libraries, which may crash while a program ends, do not run on.

    An error that simcore raises on purpose is one sentence. Any other is a mistake of the project's or of simcore's own
    code: its traceback stands before the sentence.

    Args:
        error: Why the program cannot start.
        program: As it was called.
        folder: Of the project.
    """
    if not isinstance(error, SimcoreError):
        sys.stdout.flush()
        traceback.print_exception(error)
    print_error(program, start_sentence(error, folder))
    os._exit(1)
