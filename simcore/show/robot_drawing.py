"""A described robot as one picture: from above and from its right side, to one scale, with a legend."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from simcore.physics.shapes import outline
from simcore.show.palette import color, tint
from simcore.show.raster import save_drawing, writable_picture
from simcore.show.robot_sketch import RobotSketch, SketchWay
from simcore.show.svg import Axes, document, element, line, polygon, polyline, words
from simcore.typing import FloatArray

__all__ = ["draw_robot"]

_INKS = {
    "intake": color("hit"), "shooter": color("miss"), "storage": "#8a6a00", "camera": "#0b6675", "claw": color("path"),
    "hook": "#a3195b", "way": color("blue"),
}  # fmt: skip
_WIDTH, _TOP, _LEFT = 1600.0, 128.0, 84.0  # [px]
_VIEW, _GAP = (700.0, 655.0), 84.0  # [px]
_LEGEND_ROW, _LEGEND_COLUMNS = 29.0, 2
_MARGIN = 0.12  # [m]
_ABOVE, _SIDE = (0, 1), (0, 2)  # columns of a point in the two views


def draw_robot(path: str | Path, sketch: RobotSketch, *, title: str, subtitle: str = "") -> None:
    """Draw a robot from above and from its right side, both to one scale; missing folders are made.

    Args:
        path: A `.png`, `.svg` or `.pdf` file.
        sketch: What is drawn.
        title: In large letters.
        subtitle: Under it, in small ones.

    Raises:
        OutputError: The picture cannot be written there, or as that kind of file.
    """
    path = writable_picture(path)
    points = sketch.points()
    low, high = points.min(axis=0) - _MARGIN, points.max(axis=0) + _MARGIN
    low[2] = min(low[2], -_MARGIN)
    size = high - low
    scale = min(_VIEW[0] / size[0], _VIEW[1] / max(size[1], size[2]))  # [px/m]
    parts = [words(_LEFT, 44, title, 27, ink=color("ink"), bold=True), words(_LEFT, 76, subtitle, 16)]
    for number, (columns, name) in enumerate(((_ABOVE, "from above"), (_SIDE, "from its right side"))):
        left = _LEFT + number * (_VIEW[0] + _GAP)
        parts.append(words(left, _TOP - 12, name, 15))
        view = _View(sketch, columns, low, high, scale)
        parts.append(element("g", view.drawing(), transform=f"translate({left:g} {_TOP:g})"))
    legend, height = _legend(sketch)
    parts.append(element("g", legend, transform=f"translate({_LEFT:g} {_TOP + _VIEW[1] + 84:g})"))
    save_drawing(document((0, 0, _WIDTH, _TOP + _VIEW[1] + 84 + height), *parts), path, round(_WIDTH))


class _View:
    """One view of a robot, its lower left corner at the lower left of a frame of pixels."""

    def __init__(
        self, sketch: RobotSketch, columns: tuple[int, int], low: FloatArray, high: FloatArray, scale: float
    ) -> None:
        self._sketch, self._columns, self._scale = sketch, columns, scale
        self._taken: list[tuple[float, float, float, float]] = []
        """Left and upper edge, width and height of all tags and names [px]."""
        across, up = columns
        self._left = 0.5 * (low[across] + high[across]) - 0.5 * _VIEW[0] / scale  # [m] at the frame's edge
        # from the side on the floor: what is left over is above the robot
        self._bottom = low[up] if up == _SIDE[1] else 0.5 * (low[up] + high[up]) - 0.5 * _VIEW[1] / scale

    def drawing(self) -> str:
        """Grid, robot, and everything that its sketch shows."""
        is_above = self._columns == _ABOVE
        body = self._from_above() if is_above else self._from_the_side()
        volumes, tags = self._volumes()
        parts = [self._grid(), *body, *volumes]
        labels: dict[tuple[float, float], list[str]] = {}
        for way in self._sketch.ways:
            drawn, at = self._way(way)
            parts += drawn
            if at is not None:
                labels.setdefault((round(at[0]), round(at[1])), []).append(way.name)
        tags += self._arrows()
        for (x, y), names in labels.items():
            text = ", ".join(names)
            wide = 5.9 * len(text) + 6.0
            left, top = self._free_place(x + 13.0, y - 24.0, wide, 16.0, across=-(wide + 26.0))
            parts.append(
                element("rect", x=left, y=top, width=wide, height=16, rx=3, fill=color("paper"), opacity=0.8)
                + words(left + 3, top + 12, text, 12, ink=_INKS["way"])
            )
        return "".join((*parts, *tags))

    def _free_place(self, left: float, top: float, wide: float, tall: float, *, across: float) -> tuple[float, float]:
        """The place nearest to the wanted one, above or below it there or aside, where no other words are [px]."""
        steps = [(side, k * (tall + 1.0)) for k in (0, 1, -1, 2, -2, 3, -3, 4, -4) for side in (0.0, across)]
        places = [(left + side, top + step) for side, step in steps]
        for x, y in places:
            if all(x >= a + w or a >= x + wide or y >= b + h or b >= y + tall for a, b, w, h in self._taken):
                break
        else:
            x, y = places[0]
        self._taken.append((x, y, wide, tall))
        return x, y

    def _badge(self, tag: str, x: float, y: float, ink: str) -> str:
        """A tag at a place, or beside it if another one is there."""
        wide = _tag_width(tag)
        left, top = self._free_place(x - wide / 2, y - 10.0, wide, 20.0, across=wide)
        return _tag(tag, left + wide / 2, top + 10.0, ink)

    # --- places -------------------------------------------------------------------------------------------------

    def _at(self, across: float, up: float) -> tuple[float, float]:
        return (across - self._left) * self._scale, _VIEW[1] - (up - self._bottom) * self._scale

    def _places(self, rows: FloatArray) -> list[tuple[float, float]]:
        return [self._at(row[self._columns[0]], row[self._columns[1]]) for row in rows.tolist()]

    def _box(self, low: tuple[float, float], high: tuple[float, float], **look: object) -> str:
        (x, y), (right, top) = self._at(low[0], low[1]), self._at(high[0], high[1])
        return element("rect", x=x, y=top, width=right - x, height=y - top, **look)

    # --- parts --------------------------------------------------------------------------------------------------

    def _grid(self) -> str:
        """Lines and numbers in meters."""
        wide, tall = (size / self._scale for size in _VIEW)
        low = (self._left, self._bottom)
        axes = Axes((0.0, 0.0, *_VIEW), low, (low[0] + wide, low[1] + tall))
        name = "y, to the left [m]" if self._columns == _ABOVE else "z, up [m]"
        return axes.grid("x, to the front [m]", name, size=12.5, most=(14, 14), is_ruled=True)

    def _from_above(self) -> list[str]:
        sketch, (fill, edge) = self._sketch, tint("blue")
        length, width, thick = sketch.body.bumper_length, sketch.body.bumper_width, sketch.body.bumper_thickness
        inner = (length / 2 - thick, width / 2 - thick)
        parts = [
            self._box((-length / 2, -width / 2), (length / 2, width / 2), fill=fill, stroke=edge, rx=10),
            self._box((-inner[0], -inner[1]), inner, fill=color("soft"), stroke=edge),
            self._box((length / 2 - thick, -inner[1]), (length / 2, inner[1]), fill=edge),
        ]
        r = sketch.wheel_radius
        for name, x, y in sketch.wheels:
            parts.append(self._box((x - r, y - 0.019), (x + r, y + 0.019), fill=color("ink")))
            reach = min(abs(x) + r, inner[0] - 0.012)  # its name stays inside of the frame
            place = self._at(math.copysign(reach, x), y + (-0.055 if y > 0.0 else 0.035))
            parts.append(words(*place, name, 11.5, anchor="end" if x > 0.0 else "start"))
        front = (length - thick) / 2
        for share in (-0.6, 0.0, 0.6):
            parts.append(self._front_arrow(front, share * inner[1] * 1.1))
        for share in (-0.33, 0.33):
            across, down = self._at(front, share * inner[1])
            turned = f"translate({across - 5:g} {down:g}) rotate(90)"
            parts.append(words(0.0, 0.0, "FRONT", 13, ink=color("paper"), anchor="middle", bold=True, transform=turned))
        x, y = self._at(0.0, 0.0)
        parts.append(element("path", d=f"M{x - 8:g} {y:g}h16m-8 -8v16", stroke=color("muted"), stroke_width=1.5))
        return parts

    def _front_arrow(self, x: float, y: float) -> str:
        across, down = self._at(x, y)
        corners = [(across + 9, down), (across - 7, down - 8), (across - 7, down + 8)]
        return polygon(corners, fill=color("paper"))

    def _from_the_side(self) -> list[str]:
        sketch, (fill, edge) = self._sketch, tint("blue")
        half, thick = sketch.body.bumper_length / 2, sketch.body.bumper_thickness
        low, high = sketch.body.clearance, sketch.body.bumper_top
        floor = self._at(0.0, 0.0)[1]
        body = {"fill": color("soft"), "stroke": edge, "stroke_dasharray": "3 3"}
        parts = [
            line(0, floor, _VIEW[0], floor, stroke=color("ink"), stroke_width=3),
            self._box((thick - half, high), (half - thick, sketch.body.height), **body),
        ]
        for x in sorted({round(x, 6) for _, x, _ in sketch.wheels}):
            across, down = self._at(x, sketch.wheel_radius)
            parts.append(element("circle", cx=across, cy=down, r=sketch.wheel_radius * self._scale, fill=color("ink")))
        parts.append(self._box((-half, low), (half, high), fill=fill, stroke=edge, stroke_width=1.5, rx=6))
        across, down = self._at(half - 0.03, 0.5 * (low + high))
        parts.append(words(across - 18, down + 5, "FRONT", 13, ink=edge, anchor="end", bold=True))
        parts.append(polygon([(across, down), (across - 13, down - 7), (across - 13, down + 7)], fill=edge))
        return parts

    def _volumes(self) -> tuple[list[str], list[str]]:
        """Bodies and their tags, which go over all lines."""
        parts, tags = [], []
        for volume in self._sketch.volumes:
            ink = _INKS[volume.role]
            edges = outline(volume.corners[:, self._columns])
            corners = [self._at(x, y) for x, y in edges.tolist()]
            strength = {"camera": 0.13, "storage": 0.10}.get(volume.role, 0.28)
            look: dict[str, object] = {"fill": ink, "fill_opacity": strength}
            if volume.is_outline:
                look = {"fill": "none", "stroke_dasharray": "6 4", "opacity": 0.8}
            parts.append(polygon(corners, stroke=ink, stroke_width=1.8, **look))
            if volume.tag:
                middle = edges.mean(axis=0)
                if volume.role == "camera":
                    middle = volume.corners[0, self._columns]
                elif volume.role == "storage":  # out of the way of what stands in it
                    middle = np.array([edges[:, 0].min() + 0.035, edges[:, 1].max() - 0.03])
                tags.append(self._badge(volume.tag, *self._at(*middle.tolist()), ink))
        return parts, tags

    def _way(self, way: SketchWay) -> tuple[list[str], tuple[float, float] | None]:
        """The joint, the link to what it carries, and the way of that from stop to stop; and where its name goes."""
        ink, parts = _INKS["way"], []
        link, places = self._places(way.link), self._places(way.way)
        if way.has_place and np.ptp(link, axis=0).max() > 1e-3:
            parts.append(polyline(link, stroke=ink, stroke_width=4.5, opacity=0.55, stroke_linecap="round"))
        has_way = len(places) > 0 and np.ptp(places, axis=0).max() > 0.005 * self._scale
        if has_way:
            parts.append(polyline(places, stroke=ink, stroke_width=1.8, stroke_dasharray="8 3"))
            parts.append(_arrow_head(places[-3], places[-1], 11.0, ink))
        is_seen_along = abs(way.axis[2 if self._columns == _ABOVE else 1]) > 0.9
        if not (has_way or is_seen_along):
            return parts, None
        if way.has_place:
            x, y = link[0]
            parts.append(element("circle", cx=x, cy=y, r=4.5, fill=color("paper"), stroke=ink, stroke_width=2))
        return parts, places[-1] if has_way else link[0]

    def _arrows(self) -> list[str]:
        parts, tags, ink = [], [], _INKS["shooter"]
        for arrow in self._sketch.arrows:
            start, end = self._places(np.stack((arrow.start, arrow.end)))
            away = math.dist(start, end)
            wide = 2.2 if arrow.is_faint else 4.0
            strength = 0.5 if arrow.is_faint else 1.0
            if away > 0.02 * self._scale:
                head = _arrow_head(start, end, 15.0, ink)
                parts.append(element("g", line(*start, *end, stroke=ink, stroke_width=wide), head, opacity=strength))
            parts.append(element("circle", cx=start[0], cy=start[1], r=4.5, fill=ink, stroke=color("paper")))
            if arrow.tag:
                back = [a + (a - b) / max(away, 1e-9) * 0.05 * self._scale for a, b in zip(start, end, strict=True)]
                tags.append(self._badge(arrow.tag, back[0], back[1], ink))
        return parts + tags


def _arrow_head(start: tuple[float, float], end: tuple[float, float], size: float, ink: str) -> str:
    """A tip at the end of a line."""
    angle = math.atan2(end[1] - start[1], end[0] - start[0])
    sides = [(end[0] - size * math.cos(angle + turn), end[1] - size * math.sin(angle + turn)) for turn in (0.4, -0.4)]
    return polygon([end, *sides], fill=ink)


def _tag_width(tag: str) -> float:
    return 9.0 * len(tag) + 8.0


def _tag(tag: str, x: float, y: float, ink: str) -> str:
    """White letters on a badge."""
    wide = _tag_width(tag)
    badge = element("rect", x=x - wide / 2, y=y - 10, width=wide, height=20, rx=4, fill=ink, stroke=color("paper"))
    return badge + words(x, y + 4.5, tag, 12.5, ink=color("paper"), anchor="middle", bold=True)


def _legend(sketch: RobotSketch) -> tuple[str, float]:
    """Its drawing and its height [px]."""
    notes = [(note.tag, _INKS[note.role], note.text) for note in sketch.notes]
    if any(len(way.way) for way in sketch.ways):
        notes.append(("--", _INKS["way"], "dashed: the way of a mechanism, its arrow at the end of positive motion"))
    rows = -(-len(notes) // _LEGEND_COLUMNS)
    parts = []
    for number, (tag, ink, text) in enumerate(notes):
        column, row = divmod(number, rows)
        x, y = column * (_WIDTH - _LEFT) / _LEGEND_COLUMNS, _LEGEND_ROW * row
        parts.append(_tag(tag, x + 14, y, ink) + words(x + 38, y + 5, text, 14, ink=color("ink")))
    return "".join(parts), _LEGEND_ROW * rows + 10
