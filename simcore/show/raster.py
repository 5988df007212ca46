"""Drawings as pixels and as picture files: SVG rendered by resvg, with one font on every system."""

from __future__ import annotations

import atexit
import functools
import io
import os
import re
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from simcore.errors import OutputError
from simcore.show.palette import flat
from simcore.telemetry.sinks import output_error, require_writable

if TYPE_CHECKING:
    from PIL.Image import Image

__all__ = ["pixels", "rasterized", "save_drawing", "writable_picture"]

_FORMATS = (".pdf", ".png", ".svg")
_BOLD = re.compile(r'fill="([^"]*)" font-weight="bold" font-size="([\d.]+)"')


def writable_picture(path: str | Path) -> Path:
    """The same path, of a picture that can be written there.

    Raises:
        OutputError: Another kind of file, or it cannot be written there.
    """
    path = Path(path)
    if path.suffix.lower() not in _FORMATS:
        raise OutputError(f"cannot draw {str(path)!r}: pictures end in {', '.join(_FORMATS)}")
    return require_writable("picture", path)


def save_drawing(drawing: str, path: Path, width: int) -> None:
    """Write a drawing as a picture so many pixels wide, on light paper.

    Raises:
        OutputError: It cannot be written, or a library is missing.
    """
    kind = path.suffix.lower()
    if kind == ".svg":
        data = flat(drawing).encode()
    elif kind == ".png":
        data = rasterized(drawing, width, background="#ffffff")
    else:
        stream = io.BytesIO()
        pixels(drawing, width, background="#ffffff").convert("RGB").save(stream, format="PDF", resolution=100.0)
        data = stream.getvalue()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    except OSError as error:
        raise output_error("picture", path, error) from error


def pixels(drawing: str, width: int, *, background: str | None = None) -> Image:
    """A drawing as an image so many pixels wide, transparent where nothing is drawn.

    Raises:
        OutputError: A library is missing.
    """
    try:
        from PIL import Image
    except ImportError as error:
        raise _missing(error, "pillow") from error
    with Image.open(io.BytesIO(rasterized(drawing, width, background=background))) as image:
        return image.convert("RGBA")


def rasterized(drawing: str, width: int, *, background: str | None = None) -> bytes:
    """A drawing as the bytes of a PNG.

    Raises:
        OutputError: A library is missing.
    """
    try:
        from resvg_py import svg_to_bytes
    except ImportError as error:
        raise _missing(error, "resvg-py") from error
    # The font has no bold letters: their edges are drawn as well.
    bold = _BOLD.sub(_with_edges, flat(drawing))
    family, file = _font()
    data: bytes = svg_to_bytes(
        svg_string=re.sub(r' font-family="[^"]*"', f' font-family="{family}"', bold),
        width=width,
        background=background,
        skip_system_fonts=True,
        font_files=[file],
        font_family=family,
    )
    return data


def _with_edges(found: re.Match[str]) -> str:
    ink, size = found[1], found[2]
    return f'fill="{ink}" stroke="{ink}" stroke-width="{0.045 * float(size):.2f}" font-size="{size}"'


@functools.cache
def _font() -> tuple[str, str]:
    """Name and file of the font that Pillow carries: the same letters on every system, and none has to be searched."""
    try:
        from PIL import ImageFont
    except ImportError as error:
        raise _missing(error, "pillow") from error
    font: Any = ImageFont.load_default(12)
    handle, name = tempfile.mkstemp(suffix=".ttf", prefix="simcore_font_")
    with os.fdopen(handle, "wb") as file:
        file.write(font.font_bytes)
    atexit.register(functools.partial(Path(name).unlink, missing_ok=True))
    return str(font.getname()[0]), name


def _missing(error: ImportError, package: str) -> OutputError:
    return OutputError(f"cannot draw a picture: {error}. `python -m pip install {package}` brings what it needs")
