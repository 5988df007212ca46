"""A run as a moving picture: GIF, or MP4 where ffmpeg is installed."""

from __future__ import annotations

import math
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from simcore.errors import ConfigError, OutputError
from simcore.quantities import POSITIVE, require
from simcore.show.frames import FramePainter
from simcore.show.palette import COLORS, rgb
from simcore.show.scene import Scene
from simcore.telemetry.recording import Recording
from simcore.telemetry.sinks import output_error, require_writable

if TYPE_CHECKING:
    from PIL.Image import Image

__all__ = ["FRAME_PERIOD", "animate", "check_animation", "frame_times"]

FRAME_PERIOD = 0.04
"""Time that a frame is shown [s]: a whole number of hundredths, as a GIF needs, and as often as pieces are recorded."""
_LONGEST = 40.0  # [s]; longer runs are shown faster


def animate(
    path: str | Path,
    recording: Recording,
    scene: Scene,
    *,
    title: str = "",
    width: int = 960,
    speed: float | None = None,
) -> None:
    """Write a run as `.gif`, or as `.mp4` where ffmpeg is installed; missing folders are made.

    Args:
        path: Of the file.
        recording: The run.
        scene: What it took place on.
        title: In the upper left corner.
        width: Of the picture [px].
        speed: How many times faster than real time it is shown; None: so that it ends within 40 s, at least 1.

    Raises:
        OutputError: The file cannot be written, Pillow or ffmpeg is missing, or nothing was recorded.
        ConfigError: A speed that is not > 0, or a width that is not an even number from 320 on.
    """
    path = check_animation(path)
    if width < 320 or width % 2:
        raise ConfigError(f"an animation is an even number of pixels wide, at least 320, got {width}")
    if not len(recording):
        raise OutputError(f"cannot animate {str(path)!r}: no tick was recorded")
    start, end = float(recording.times[0]), float(recording.times[-1])
    if speed is None:
        speed = max(1.0, math.ceil(2.0 * (end - start) / _LONGEST) / 2.0)
    painter = FramePainter(recording, scene, title=title, width=width, speed=speed)
    frames = (painter.draw(time) for time in frame_times(start, end, speed))
    try:
        if path.suffix.lower() == ".gif":
            _write_gif(path, frames, _colors_of(recording, scene))
        else:
            _write_mp4(path, frames)
    except OSError as error:
        raise error if isinstance(error, OutputError) else output_error("animation", path, error) from error


def check_animation(path: str | Path) -> Path:
    """Make sure, before a run, that it can be animated after it.

    Raises:
        OutputError: Another kind of file, no ffmpeg for an MP4, or a place that cannot be written.
    """
    path = Path(path)
    kind = path.suffix.lower()
    if kind not in (".gif", ".mp4"):
        raise OutputError(f"cannot animate {str(path)!r}: animations end in .gif, or in .mp4 where ffmpeg is installed")
    if kind == ".mp4" and shutil.which("ffmpeg") is None:
        raise OutputError(f"cannot write {str(path)!r}: ffmpeg is not installed. Install it, or ask for a .gif")
    return require_writable("animation", path)


def frame_times(start: float, end: float, speed: float = 1.0) -> list[float]:
    """When to look at a run [s]: at whole multiples of a frame's time, as pieces are recorded, and at both ends.

    >>> frame_times(0.02, 0.2)
    [0.02, 0.04, 0.08, 0.12, 0.16, 0.2]

    Raises:
        ConfigError: A speed that is not > 0.
    """
    require("animate", "speed", speed, POSITIVE)
    period = FRAME_PERIOD * speed
    between = range(math.floor(start / period + 1e-6) + 1, math.ceil(end / period - 1e-6))
    return [start, *(round(number * period, 6) for number in between), *([end] if end > start else [])]


def _colors_of(recording: Recording, scene: Scene) -> list[str]:
    """Those of the pieces on this field: on the floor and in the air, then of their edges."""
    names = [*scene.pieces, *(name for name in recording.pieces_at(0.0) if name not in scene.pieces)]
    looks = [scene.look(name) for name in names]
    return [color for look in looks for color in (look.color, look.air_color)] + [look.edge_color for look in looks]


def _write_gif(path: Path, frames: Iterator[Image], pieces: list[str]) -> None:
    """With one palette for all frames, looked up in a table: to quantize each would take five times as long."""
    from PIL import Image

    first = next(frames)
    palette, table = _palette(first, pieces)

    def indexed(frame: Image.Image) -> Image.Image:
        values = np.asarray(frame, dtype=np.uint16)
        code = ((values[..., 0] >> 3) << 11) | ((values[..., 1] >> 2) << 5) | (values[..., 2] >> 3)
        picture = Image.fromarray(table[code])
        picture.putpalette(palette)
        return picture

    indexed(first).save(
        path,
        format="GIF",
        save_all=True,
        append_images=(indexed(frame) for frame in frames),
        duration=round(1000.0 * FRAME_PERIOD),
        loop=0,
        optimize=True,  # what stays is written as transparent
        transparency=255,
    )


def _palette(picture: Image, pieces: list[str]) -> tuple[list[int], np.ndarray[Any, np.dtype[np.uint8]]]:
    """Up to 255 colors and the nearest of them for each 16-bit color; number 255 is left for what stays.

    They are those that we draw with, and their blends at edges.
    """
    from PIL import Image

    edges = pieces[2 * len(pieces) // 3 :]
    solid = [*(rgb(light) for light, _ in COLORS.values()), *map(rgb, pieces[: 2 * len(pieces) // 3])]
    blends = [
        tuple(round(a + part * (b - a)) for a, b in zip(one, other, strict=True))
        for other in map(rgb, (COLORS["carpet"][0], COLORS["paper"][0], *edges))
        for one in solid
        for part in (0.33, 0.67)
    ]
    seen = picture.quantize(64, method=Image.Quantize.FASTOCTREE).getpalette() or []
    found = [tuple(seen[i : i + 3]) for i in range(0, len(seen), 3)]
    table = np.array(list(dict.fromkeys((*solid, *map(rgb, edges), *found, *blends)))[:255], dtype=np.int32)
    codes = np.arange(65536)
    values = np.stack((((codes >> 11) << 3) + 4, ((codes >> 5) % 64 << 2) + 2, (codes % 32 << 3) + 4), axis=1)
    distance = np.zeros((65536, len(table)), dtype=np.int32)
    for channel, weight in enumerate((3, 6, 1)):  # as the eye weighs red, green and blue
        distance += weight * (values[:, channel, None] - table[None, :, channel]) ** 2
    palette = np.zeros((256, 3), dtype=int)
    palette[: len(table)] = table
    return palette.ravel().tolist(), distance.argmin(axis=1).astype(np.uint8)


def _write_mp4(path: Path, frames: Iterator[Image]) -> None:
    first = next(frames)
    command = [
        "ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24",
        "-s", f"{first.width}x{first.height}", "-r", f"{1.0 / FRAME_PERIOD:.6f}", "-i", "-",
        "-an", "-c:v", "libx264", "-pix_fmt", "yuv420p", "-movflags", "+faststart", str(path),
    ]  # fmt: skip
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdin is not None and process.stderr is not None
        is_broken = False
        try:
            for frame in (first, *frames):
                process.stdin.write(frame.tobytes())
            process.stdin.close()
        except BrokenPipeError:
            is_broken = True
        said = process.stderr.read().decode(errors="replace").strip().splitlines()
    if is_broken or process.returncode:
        raise OutputError(f"ffmpeg could not write {str(path)!r}: {(said or ['it ended early'])[-1]}. Ask for a .gif")
