"""One moment of a run as an image: pixels of the same drawing that a page shows, for animations.

What stands still is rendered once, each look of a piece once; a frame is then put together in some milliseconds.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING

import numpy as np

from simcore.show.field_drawing import FieldDrawing, piece_symbol
from simcore.show.palette import color
from simcore.show.raster import pixels
from simcore.show.run_events import board_of
from simcore.show.run_track import AWAY, Placed, RunTrack, Table
from simcore.show.scene import Scene
from simcore.show.shots import shots_of
from simcore.show.svg import document, element, words
from simcore.telemetry.recording import Recording

if TYPE_CHECKING:
    from PIL.Image import Image

__all__ = ["FramePainter"]

_HEADER, _CLOCK = 44, 150  # [px]
_TRAIL = 0.4  # [s] for which a shot's flight stays after its end


class FramePainter:
    """Draws moments of one run.

    Args:
        recording: The run.
        scene: What it took place on.
        title: In the upper left corner.
        width: Of a frame [px].
        speed: Shown beside the clock, if it is not 1.

    Raises:
        OutputError: A library is missing.
    """

    def __init__(self, recording: Recording, scene: Scene, *, title: str = "", width: int = 960, speed: float = 1.0):
        self._track = RunTrack(recording, scene)
        self._field = FieldDrawing(self._track, shots_of(recording, scene))
        self._board = [item for item in board_of(recording) if item.label != "time left"]
        self._title, self._speed, self._width = title, speed, width
        self._left, self._top, across, down = self._field.box
        self._scale = width / across
        self._height = 2 * math.ceil((_HEADER + down * self._scale) / 2.0)  # even, for video
        ground = pixels(self._field.drawing(self._field.ground()), width)
        from PIL import Image  # there, or `pixels` has said that it is not

        self._ground = Image.new("RGB", (width, self._height), "#ffffff")
        self._ground.paste(ground, (0, _HEADER), ground)
        self._resting = self._ground.copy()
        self._before = self._track.table(-math.inf)
        self._at_rest = np.full_like(self._before, AWAY)
        largest = max((scene.look(name).reach for name in self._track.types), default=0.1)
        self._largest = math.ceil(150.0 * largest * self._scale) + 3
        """Half of the largest piece that lies [px]."""
        self._piece = functools.lru_cache(maxsize=4096)(self._rendered_piece)
        self._title_and_board = functools.lru_cache(maxsize=2)(self._rendered_head)

    def pixel(self, x: float, y: float) -> tuple[float, float]:
        """Where a place of the field [m] is in a frame, from the left and the top."""
        return self._on_frame(100.0 * x, self._field.width - 100.0 * y)

    def draw(self, time: float) -> Image:
        """The frame of a simulated time [s]."""
        table = self._track.table(time)
        self._update_resting(table)
        frame = self._resting.copy()
        moving = (table[:, 0] == 0) & (self._at_rest[:, 0] != 0)
        for placed in self._track.placed(np.where(moving[:, None], table, AWAY)):
            self._put(frame, placed)
        self._put_moving(frame, time)
        frame.paste(self._head(time), (0, 0))
        return frame

    # --- inside -------------------------------------------------------------------------------------------------

    def _on_frame(self, x: float, y: float) -> tuple[float, float]:
        return (x - self._left) * self._scale, _HEADER + (y - self._top) * self._scale

    def _put(self, frame: Image, placed: Placed, left: int = 0, top: int = 0) -> None:
        """Draw a piece into an image whose corner is at a pixel of the frame."""
        x, y = self._on_frame(placed.x, placed.y)
        shift = (round(4 * (x % 1)) / 4, round(4 * (y % 1)) / 4)  # a quarter of a pixel is what an eye can see
        look = (self._track.kinds[placed.row], placed.scale_x, placed.scale_y, placed.angle, placed.in_air)
        sprite = self._piece(look, shift)
        half = sprite.width // 2
        frame.paste(sprite, (math.floor(x) - half - left, math.floor(y) - half - top), sprite)

    def _update_resting(self, table: Table) -> None:
        """Keep an image of all that lies still, as most pieces do: a frame draws only what moves.

        Where a piece leaves, the ground and its neighbors are drawn anew.
        """
        for row in np.nonzero((self._at_rest[:, 0] == 0) & (table != self._at_rest).any(axis=1))[0].tolist():
            x, y = self._on_frame(*self._at_rest[row, 1:3].tolist())
            self._at_rest[row, 0] = AWAY
            left, top = math.floor(x) - self._largest, math.floor(y) - self._largest
            patch = self._ground.crop((left, top, left + 2 * self._largest, top + 2 * self._largest))
            away = np.abs(self._at_rest[:, 1:3] - self._at_rest[row, 1:3]).max(axis=1)
            near = away < 2 * self._largest / self._scale
            for placed in self._track.placed(np.where(near[:, None], self._at_rest, AWAY)):
                self._put(patch, placed, left, top)
            self._resting.paste(patch, (left, top))
        new = (table[:, 0] == 0) & (self._at_rest[:, 0] != 0) & (table == self._before).all(axis=1)
        for placed in self._track.placed(np.where(new[:, None], table, AWAY)):
            self._put(self._resting, placed)
        self._at_rest[new] = table[new]
        self._before = table

    def _rendered_piece(self, look: tuple[int, int, int, int, int], shift: tuple[float, float]) -> Image:
        """A piece of one look, its middle in the middle pixel, moved by parts of a pixel."""
        kind, scale_x, scale_y, angle, in_air = look
        shape = self._track.scene.look(self._track.types[kind])
        reach = 100.0 * shape.reach if shape.size is None else 50.0
        half = math.ceil(1.5 * reach * max(scale_x, scale_y) / 100.0 * self._scale) + 2
        size = 2 * half + 1
        place = f"translate({half + shift[0]:g} {half + shift[1]:g}) scale({self._scale:g}) rotate({angle})"
        if shape.size is None:
            symbol = piece_symbol(shape, in_air=bool(in_air))
            body = element("g", symbol, transform=f"{place} scale({scale_x / 100:g} {scale_y / 100:g})")
        else:  # resvg scales strokes with their shapes
            fill = shape.air_color if in_air else shape.color
            body = element(
                "rect", x=-scale_x / 2, y=-scale_y / 2, width=scale_x, height=scale_y, fill=fill,
                stroke=shape.edge_color, stroke_width=1.4, transform=place,
            )  # fmt: skip
        return pixels(document((0, 0, size, size), body), size)

    def _put_moving(self, frame: Image, time: float) -> None:
        """Robots with what they hold, and flights of the last moments: rendered where there is any, in one piece."""
        places = [
            (100.0 * pose[0], self._field.width - 100.0 * pose[1])
            for number in range(len(self._track.robots))
            for estimate in (False, True)
            if (pose := self._track.robot_at(number, time, estimate=estimate)) is not None
        ]
        for shot in self._field.shots:
            if shot.times[0] <= time + 1e-9 and shot.times[-1] >= time - _TRAIL:
                places += self._field.points(shot.points).tolist()
        if not places:
            return
        xs, ys = zip(*places, strict=True)
        step = 1.0 / self._scale  # whole pixels, so that nothing is blurred
        left = self._left + step * math.floor((min(xs) - 90.0 - self._left) / step)
        top = self._top + step * math.floor((min(ys) - 90.0 - self._top) / step)
        across = math.ceil((max(xs) + 90.0 - left) / step)
        down = math.ceil((max(ys) + 90.0 - top) / step)
        body = self._field.moment(time, pieces=False) + self._field.shot_traces(time, time - _TRAIL)
        drawing = document((left, top, across * step, down * step), self._field.symbols(), body)
        x, y = self._on_frame(left, top)
        moving = pixels(drawing, across)
        frame.paste(moving, (round(x), round(y)), moving)

    def _head(self, time: float) -> Image:
        """Title, score board and clock; only the clock is new in most frames."""
        speed = f" ({self._speed:g}x)" if self._speed != 1.0 else ""
        says = [(item.label, item.at(time)) for item in self._board]
        head = self._title_and_board(tuple(says)).copy()
        back = element("rect", width=_CLOCK, height=_HEADER, fill=color("paper"))
        clock = words(_CLOCK - 14.0, 28, f"{time:.1f} s{speed}", 17, ink=color("ink"), anchor="end", bold=True)
        head.paste(pixels(document((0, 0, _CLOCK, _HEADER), back, clock), _CLOCK), (self._width - _CLOCK, 0))
        return head

    def _rendered_head(self, says: tuple[tuple[str, str], ...]) -> Image:
        title = _cut(self._title, int(0.4 * self._width / 8.6))
        parts = [
            element("rect", width=self._width, height=_HEADER, fill=color("paper")),
            words(14, 28, title, 16, ink=color("ink")),
        ]
        x = 14.0 + 8.6 * len(title) + 24.0
        for label, said in says:  # what counts least is left out first
            text = said if label == "period" else label if said == "yes" else f"{label} {said}"
            if said != "no" and x + 8.4 * len(text) < self._width - _CLOCK:
                ink = color(label) if label in ("blue", "red") else color("muted")
                parts.append(words(x, 28, text, 15, ink=ink, bold=label in ("blue", "red")))
                x += 8.4 * len(text) + 20.0
        return pixels(document((0, 0, self._width, _HEADER), *parts), self._width)


def _cut(text: str, most: int) -> str:
    """As much of a text as there is room for."""
    return text if len(text) <= most else f"{text[: most - 3]}..."
