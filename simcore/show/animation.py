"""A run as a moving picture: GIF, or MP4 where ffmpeg is installed. Drawn by Pillow at twice the size, then reduced."""

from __future__ import annotations

import contextlib
import itertools
import math
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from simcore.errors import ConfigError, OutputError
from simcore.quantities import POSITIVE, require
from simcore.show.field_drawing import FieldDrawing
from simcore.show.frames import filled
from simcore.show.palette import COLORS, flat, rgb, tint
from simcore.show.raster import pixels
from simcore.show.run_events import BoardRecord, score_keys
from simcore.show.run_track import Placed, RunTrack
from simcore.show.scene import RobotLook, Scene
from simcore.show.shots import shots_of
from simcore.telemetry.recording import Recording
from simcore.telemetry.sinks import output_error, require_writable
from simcore.typing import FloatArray

if TYPE_CHECKING:
    from PIL.Image import Image

__all__ = ["FRAME_PERIOD", "FramePainter", "animate", "check_animation", "frame_times"]

FRAME_PERIOD = 0.04
"""Time that a frame is shown [s]: a whole number of hundredths, as a GIF needs, and as often as pieces are recorded."""
_LONGEST = 40.0  # [s]; longer runs are shown faster
_HEADER, _FINE, _TRAIL = 44, 2, 0.4  # [px]; pixels drawn for one shown; [s] for which a shot stays after its end


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
    write = _write_gif if path.suffix.lower() == ".gif" else _write_mp4
    try:
        write(path, map(painter.draw, times))
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


class FramePainter:
    """Draws moments of one run; the arguments are those of `animate`."""

    def __init__(
        self, recording: Recording, scene: Scene, title: str = "", width: int = 960, speed: float = 1.0
    ) -> None:
        self._track, self._scene, self._shots = RunTrack(recording, scene), scene, shots_of(recording, scene)
        field = FieldDrawing(self._track, self._shots)
        left, top, across, down = field.box
        self._scale, self._down = _FINE * width / across, field.width
        self._corner = np.array((left, top - _FINE * _HEADER / self._scale))
        ground = pixels(field.drawing(field.ground()), _FINE * width)  # says which library is missing
        from PIL import Image, ImageFont

        size = (_FINE * width, 2 * _FINE * math.ceil((_HEADER + down * width / across) / 2.0))  # even, for video
        self._ground = Image.new("RGB", size, "#ffffff")
        self._ground.paste(ground, (0, _FINE * _HEADER), ground)
        self._fonts = [ImageFont.load_default(_FINE * points) for points in (15, 17)]
        board, told = BoardRecord(scene), ("period", *(label for label, _ in score_keys(scene)))
        for snapshot in filled(recording):
            board.take(snapshot)
        self._board = [item for item in board.items if item.label in told][::-1]
        self._title = title if speed == 1.0 else f"{title}, {speed:g} times as fast"

    def draw(self, time: float) -> Image:
        """The frame of a simulated time [s]."""
        from PIL import ImageDraw

        frame = self._ground.copy()
        self._pen: Any = ImageDraw.Draw(frame)
        placed = self._track.placed(self._track.table(time))
        for one in placed:
            if one.holder == 0:
                self._piece(one, np.eye(2), np.zeros(2))
        for shot in self._shots:
            rows = int(np.searchsorted(shot.times, time + 1e-9))
            if rows > 1 and shot.times[-1] > time - _TRAIL:
                ink = COLORS[shot.result if shot.result in ("hit", "miss") else "muted"][0]
                way = 100.0 * shot.points[:rows, :2] * (1.0, -1.0) + (0.0, self._down)
                self._pen.line(self.points(way), fill=ink, width=2 * _FINE)
        for believed, (number, look) in itertools.product((True, False), enumerate(self._scene.robots)):
            pose = self._track.robot_at(number, time, estimate=believed)
            if pose is not None:
                self._robot(look, pose, believed, [one for one in placed if one.holder == number + 1])
        ink, right = COLORS["ink"][0], float(frame.width - 10 * _FINE)
        self._pen.text((10 * _FINE, 12 * _FINE), self._title, fill=ink, font=self._fonts[0])
        told = [(item.label, item.at(time)) for item in self._board]
        for label, value in (("", f"{time:.2f} s"), *told):
            text = value if label in ("", "period") else f"{label} {value}"
            right -= self._pen.textlength(text, font=self._fonts[1])
            paint = COLORS[label if label in ("blue", "red") else "ink"][0]
            self._pen.text((right, 11 * _FINE), text, fill=paint, font=self._fonts[1])
            right -= 14 * _FINE
        return frame.reduce(_FINE)

    def points(self, places: FloatArray) -> list[tuple[float, ...]]:
        """Places of a `FieldDrawing` [cm] in a frame of twice its size [px]."""
        return [tuple(row) for row in (self._scale * (places - self._corner)).tolist()]

    def _piece(self, one: Placed, turn: FloatArray, middle: FloatArray) -> None:
        """A piece, turned and moved as what holds it [cm]."""
        look = self._scene.look(self._track.types[self._track.kinds[one.row]])
        paint = {"fill": look.air_color if one.in_air else look.color, "outline": look.edge_color}
        place = middle + turn @ (one.x, one.y)
        if look.size is None:
            r = look.reach * one.scale_x
            self._pen.ellipse([*itertools.chain(*self.points(np.array([place - r, place + r])))], **paint)
        else:
            corners = 0.5 * _SQUARE * (one.scale_x, one.scale_y)
            self._pen.polygon(self.points(place + corners @ _turn(one.angle).T @ turn.T), **paint)

    def _robot(self, look: RobotLook, pose: tuple[float, float, float], believed: bool, held: Sequence[Placed]) -> None:
        """A robot with what it holds; of where it believed to be the outline."""
        middle, turn = np.array((100.0 * pose[0], self._down - 100.0 * pose[1])), _turn(-math.degrees(pose[2]))
        x, y = 50.0 * look.bumpers[0], 50.0 * look.bumpers[1]
        box = self.points(middle + _SQUARE * (x, y) @ turn.T)
        if believed:
            self._pen.line([*box, box[0]], fill=COLORS["ghost"][0], width=2 * _FINE)
            return
        edge = COLORS[look.ink][0] if look.ink else flat(tint(look.alliance)[1])
        self._pen.polygon(box, fill=edge)
        self._pen.polygon(self.points(middle + _SQUARE * (x - 8.0, y - 8.0) @ turn.T), fill="#eceef2")
        for one in held:
            self._piece(one, turn, middle)
        arrow = np.array([(x - 8.0, 0.0), (0.3 * x - 8.0, 0.35 * y), (0.3 * x - 8.0, -0.35 * y)])
        self._pen.polygon(self.points(middle + arrow @ turn.T), fill=edge)


_SQUARE = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])


def _turn(degrees: float) -> FloatArray:
    """Clockwise in a drawing whose y is down, shape (2, 2)."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([(c, -s), (s, c)])


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
