"""Whether an output can be written, asked before a run and not after."""

from __future__ import annotations

import os
from pathlib import Path

from simcore.errors import OutputError

__all__ = ["require_writable"]


def require_writable(path: Path) -> None:
    """Make the folder of a file, and make sure that the file can be written.

    Raises:
        OutputError: It cannot; says what is in the way.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"cannot make the folder {path.parent}: {error.strerror or error}; choose another") from error
    if path.is_dir():
        raise OutputError(f"cannot write {path}: it is a folder; give a file name")
    target = path if path.exists() else path.parent
    if not os.access(target, os.W_OK):
        raise OutputError(f"cannot write {path}: no permission for {target}; choose another place")
