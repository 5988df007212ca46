"""A matplotlib figure for a picture file: the file's name is checked, and the library is loaded when it is needed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from simcore.errors import OutputError
from simcore.telemetry.sinks import output_error, require_writable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["new_figure", "picture_path", "save_figure"]

_FORMATS = ("pdf", "png", "svg")


def picture_path(path: str | Path) -> Path:
    """The same path, of a picture that can be written there.

    Raises:
        OutputError: Another kind of file, or it cannot be written there.
    """
    path = Path(path)
    if path.suffix.lower().lstrip(".") not in _FORMATS:
        raise OutputError(f"cannot draw {str(path)!r}: pictures end in {', '.join('.' + f for f in _FORMATS)}")
    require_writable("picture", path)
    return path


def new_figure(path: Path, size: tuple[float, float]) -> Figure:
    """An empty white figure of a size in inches at 100 dots each.

    Args:
        path: What it is for, for the message.
        size: Width and height [in].

    Raises:
        OutputError: matplotlib is not there.
    """
    try:
        from matplotlib.figure import Figure  # takes half a second, and needs no screen and no pyplot
    except ImportError as error:
        raise OutputError(
            f"cannot draw the picture {str(path)!r}: {error}. `python -m pip install matplotlib` brings what it needs"
        ) from error
    return Figure(figsize=size, dpi=100, facecolor="white")


def save_figure(figure: Figure, path: Path) -> None:
    """Write a figure into its file.

    Raises:
        OutputError: It cannot be written.
    """
    try:
        figure.savefig(path, format=path.suffix.lower().lstrip("."))
    except OSError as error:
        raise output_error("picture", path, error) from error
