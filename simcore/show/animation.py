"""A run as a moving picture: GIF, or MP4 where ffmpeg is installed."""

from __future__ import annotations

import contextlib
import itertools
import math
import shutil
import subprocess
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from simcore.errors import ConfigError, OutputError
from simcore.quantities import POSITIVE, require
from simcore.show.field_drawing import DrawnPiece, FieldDrawing, planar, turned_box
from simcore.show.frames import FrameLayout, filled, piece_kinds
from simcore.show.palette import COLORS, rgb
from simcore.show.raster import pixels
from simcore.show.run_events import board_now, score_keys
from simcore.show.run_track import RunTrack
from simcore.show.scene import Scene
from simcore.show.shots import shots_of
from simcore.show.svg import document, element
from simcore.telemetry.recording import Recording
from simcore.telemetry.sinks import output_error, require_writable
from simcore.telemetry.snapshot import Snapshot
from simcore.typing import FloatArray

if TYPE_CHECKING:
    from PIL.Image import Image

__all__ = ["FRAME_PERIOD", "FramePainter", "animate", "check_animation", "frame_times"]

FRAME_PERIOD = 0.04
"""Time that a frame is shown [s]: a whole number of hundredths, as a GIF needs, and as often as pieces are recorded."""
_LONGEST = 40.0  # [s]; longer runs are shown faster
_HEADER, _FINE, _TRAIL = 44, 2, 0.4  # [px]; pixels drawn for one shown; [s] for which a shot stays after its end
_REACH = 150.0  # [cm] of a robot's symbol from its center at most


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
    times = frame_times(start, end, speed)
    painter = FramePainter(recording, scene, title, width, speed)
    frames = map(painter.draw, _at(filled(recording), times))
    write = _write_gif if path.suffix.lower() == ".gif" else _write_mp4
    try:
        write(path, frames)
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


def _at(snapshots: Iterable[Snapshot], times: Iterable[float]) -> Iterator[Snapshot]:
    """The newest snapshot at each of some rising times [s]."""
    left, newest = iter(times), None
    time = next(left, None)
    for snapshot in snapshots:
        while newest is not None and time is not None and time < snapshot.time - 1e-9:
            yield newest
            time = next(left, None)
        newest = snapshot
    if newest is not None and time is not None:
        yield from itertools.repeat(newest, 1 + len([*left]))


class FramePainter:
    """Draws moments of one run at twice the size and reduces them; the arguments are those of `animate`."""

    def __init__(
        self, recording: Recording, scene: Scene, title: str = "", width: int = 960, speed: float = 1.0
    ) -> None:
        field = self._field = FieldDrawing(RunTrack(recording, scene), shots_of(recording, scene))
        self._layout = FrameLayout(scene, (), piece_kinds(recording, scene))
        left, top, across, down = field.box
        height = 2 * math.ceil((_HEADER + down * width / across) / 2.0)  # even, for video
        self._scale = _FINE * width / across  # [px/cm]
        self._corner = np.array((left, top - _HEADER * across / width))
        box = (*self._corner.tolist(), across, height * across / width)
        self._ground = pixels(document(box, field.ground()), _FINE * width, background="#ffffff").convert("RGB")
        self._title = title if speed == 1.0 else f"{title}, {speed:g} times as fast"

    def draw(self, snapshot: Snapshot) -> Image:
        """The frame of a snapshot with the newest of all arrays: pieces and flights, then robots, then the header."""
        from PIL import ImageDraw

        frame, field = self._ground.copy(), self._field
        pen: Any = ImageDraw.Draw(frame)
        pieces = [*field.pieces(snapshot, self._layout)]
        for one in pieces:
            if one.robot is None:
                corners, paint = self.points(one.corners), {"fill": one.fill, "outline": one.look.edge_color}
                if one.look.size is None:
                    pen.ellipse([*corners[0], *corners[2]], **paint)
                else:
                    pen.polygon(corners, **paint)
        for shot in field.shots:
            rows = int(np.searchsorted(shot.times, snapshot.time + 1e-9))
            if rows > 1 and shot.times[-1] > snapshot.time - _TRAIL:
                ink = COLORS[shot.result if shot.result in ("hit", "miss") else "muted"][0]
                pen.line(self.points(field.points(shot.points[:rows])), fill=ink, width=2 * _FINE)
        for robot in field.scene.robots:
            believed = snapshot.poses.get(f"{robot.prefix}/Robot/EstimatedPose")
            if believed is not None:
                x, y, yaw = planar(believed)
                length, width = (100.0 * size for size in robot.bumpers)
                box = turned_box(100.0 * x, field.width - 100.0 * y, length, width, -math.degrees(yaw))
                pen.line(self.points(box[[0, 1, 2, 3, 0]]), fill=COLORS["ghost"][0], width=2 * _FINE)
        for number, robot in enumerate(field.scene.robots):
            if robot.pose_key in snapshot.poses:
                layer = self._robot(number, snapshot, pieces)
                x, y, _ = planar(snapshot.poses[robot.pose_key])
                ((across, down),) = self.points(field.points(np.array([(x, y)])) - _REACH)
                frame.paste(layer, (round(across), round(down)), layer)
        self._write_header(pen, frame.width, snapshot)
        return frame.reduce(_FINE)

    def _robot(self, number: int, snapshot: Snapshot, pieces: Sequence[DrawnPiece]) -> Image:
        """A robot with what it holds, in the middle of a layer of its own."""
        yaw = planar(snapshot.poses[self._field.scene.robots[number].pose_key])[2]
        symbol = self._field.robot(number, snapshot, pieces)
        turned = element("g", symbol, transform=f"rotate({-math.degrees(yaw):.1f})")
        size = 2.0 * _REACH
        return pixels(document((-_REACH, -_REACH, size, size), turned), round(size * self._scale))

    def _write_header(self, pen: Any, width: int, snapshot: Snapshot) -> None:
        """Title from the left; clock, period and scores from the right, over it where it is long."""
        from PIL import ImageFont

        small, large = (ImageFont.load_default(_FINE * points) for points in (15, 17))
        pen.text((10 * _FINE, 12 * _FINE), self._title, fill=COLORS["ink"][0], font=small)
        labels = [label for label, _ in score_keys(self._field.scene)]
        told = [(label, text) for label, text in board_now(snapshot, self._field.scene) if label in ("period", *labels)]
        right = width - 10.0 * _FINE
        for label, value in (("", f"{snapshot.time:.2f} s"), *told[::-1]):
            text = f"{label} {value}" if label in labels else value
            right -= pen.textlength(text, font=large)
            paint = COLORS[label if label in ("blue", "red") else "ink"][0]
            pen.text((right, 11 * _FINE), text, fill=paint, font=large)
            right -= 14 * _FINE

    def points(self, places: FloatArray) -> list[tuple[float, ...]]:
        """Places of a `FieldDrawing` [cm] in a frame of twice its size [px]."""
        return [tuple(row) for row in (self._scale * (places - self._corner)).tolist()]


def _write_gif(path: Path, frames: Iterator[Image]) -> None:
    """With one palette for all frames: that of the first one and of all that we draw with."""
    from PIL import Image

    first = next(frames)
    seen = (first.quantize(255 - len(COLORS)).getpalette() or [])[: 3 * (255 - len(COLORS))]
    palette = Image.new("P", (1, 1))
    palette.putpalette([*seen, *itertools.chain(*(rgb(light) for light, _ in COLORS.values()))])
    more = (frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in itertools.chain((first,), frames))
    next(more).save(path, format="GIF", save_all=True, append_images=more, duration=round(1e3 * FRAME_PERIOD), loop=0)


def _write_mp4(path: Path, frames: Iterator[Image]) -> None:
    first = next(frames)
    command = [
        "ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24",
        "-s", f"{first.width}x{first.height}", "-r", f"{1.0 / FRAME_PERIOD:g}", "-i", "-",
        "-an", "-pix_fmt", "yuv420p", "-movflags", "+faststart", str(path),
    ]  # fmt: skip
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdin is not None and process.stderr is not None
        with contextlib.suppress(BrokenPipeError), process.stdin as pipe:  # what it says of it is told below
            for frame in itertools.chain((first,), frames):
                pipe.write(frame.tobytes())
        said = process.stderr.read().decode(errors="replace").strip().splitlines() or ["it ended early"]
        if process.wait():
            raise OutputError(f"ffmpeg could not write {str(path)!r}: {said[-1]}. Ask for a .gif")
