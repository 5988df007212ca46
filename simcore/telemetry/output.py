"""Files that a run leaves behind: checked before the first tick, with one clear sentence when they cannot be."""

from __future__ import annotations

from pathlib import Path

from simcore.errors import OutputError

__all__ = ["discard_empty", "output_error", "require_writable"]


def output_error(kind: str, path: Path, error: OSError) -> OutputError:
    """What to raise when `path`, a log or a picture, cannot be written."""
    example = Path("out") / ("run.wpilog" if kind == "log" else "run.png")
    return OutputError(
        f"cannot write the {kind} {str(path)!r}: {error.strerror or error}. "
        f"Give a file in a folder that you may write to, for example {str(example)!r}"
    )


def require_writable(kind: str, path: str | Path) -> Path:
    """Make sure that a file can be written later, so that a run does not fail at its end.

    Missing folders are made; an existing file keeps its content, a missing one is not left behind.

    Args:
        kind: What it is, for the error: `log`, `picture`.
        path: The file.

    Raises:
        OutputError: It cannot be written.
    """
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        existed = path.exists()
        with path.open("ab"):
            pass
        if not existed:
            path.unlink()
    except OSError as error:
        raise output_error(kind, path, error) from error
    return path


def discard_empty(path: Path) -> None:
    """Take away what a full disk made of a file: nothing, under its name. Other files and devices stay."""
    try:
        if path.is_file() and path.stat().st_size == 0:
            path.unlink()
    except OSError:
        pass  # then it stays: what matters was said already
