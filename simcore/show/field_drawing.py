"""The one drawing of a field from above: page, picture and animation are made of these elements.

Lengths are centimeters, x to the right, y down from the field's upper edge.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from simcore.show.frames import HELD, IN_FLIGHT, FrameLayout
from simcore.show.palette import color, tint
from simcore.show.run_track import RunTrack
from simcore.show.scene import PieceLook, RobotLook, Scene
from simcore.show.shots import ShotResult, ShotTrace
from simcore.show.svg import document, element, line, polygon, polyline, ticks, words
from simcore.telemetry.snapshot import Snapshot
from simcore.typing import FloatArray, IntArray

__all__ = ["MARGIN", "DrawnPiece", "FieldDrawing", "end_mark", "path_ink", "planar", "robot_symbol", "turned_box"]

MARGIN = 78.0
"""Around the field, where its scale is written [cm]."""
_BUMPER = 8.0  # wide, as drawn
_MOST = 150.0  # that is seen beside the field
_FEW = 2  # robots of which it is drawn where they believed to be: more would hide the field
_STAMP = 30  # outlines of a robot along its path, at most
_HIGH = 0.35  # [m]; a flying piece whose center is higher is drawn darker and larger


@dataclass(frozen=True, slots=True)
class DrawnPiece:
    """A piece as a drawing places it; one that flies high is larger and darker."""

    look: PieceLook
    robot: int | None
    """In which it is and whose center is then the origin; None: it is on the field or in the air."""
    x: float
    """To the right [cm]."""
    y: float
    """Down [cm]."""
    length: float
    """Of its outline [cm]; of a disk the diameter."""
    width: float
    degrees: float
    """Heading of the length, clockwise."""
    is_high: bool

    @property
    def fill(self) -> str:
        """Its color."""
        return self.look.air_color if self.is_high else self.look.color

    @property
    def corners(self) -> FloatArray:
        """Of its outline, or of the square around a disk [cm], shape (4, 2)."""
        return turned_box(self.x, self.y, self.length, self.width, self.degrees)

    def symbol(self) -> str:
        """Its element."""
        paint = {"fill": self.fill, "stroke": self.look.edge_color, "stroke_width": 1.3}
        if self.look.size is None:
            return element("circle", cx=self.x, cy=self.y, r=0.5 * self.length, **paint)
        return polygon(self.corners, **paint)


class FieldDrawing:
    """Draws a run.

    Args:
        track: Where everything was.
        shots: Of the run.
    """

    def __init__(self, track: RunTrack, shots: Sequence[ShotTrace]) -> None:
        self.track, self.shots = track, shots
        self.scene: Scene = track.scene
        self.length, self.width = (100.0 * size for size in self.scene.field_size)
        ends = np.vstack([(-1.25 * MARGIN, -MARGIN / 2), (self.length + MARGIN / 2, self.width + 0.85 * MARGIN),
                          *(self.points(corners) for _, corners in self.scene.field_outlines)])  # fmt: skip
        size = np.array((self.length, self.width))
        low, high = ends.min(axis=0).clip(-_MOST), ends.max(axis=0).clip(max=size + _MOST)
        self.box: tuple[float, float, float, float] = (*low.tolist(), *(high - low).tolist())
        """Left, top, width and height of what is seen, with all that stands at the field's edge."""

    def drawing(self, *inside: str, **attributes: object) -> str:
        """A drawing of the field with these elements."""
        return document(self.box, *inside, role="img", aria_label="the field from above", **attributes)

    def points(self, rows: FloatArray) -> FloatArray:
        """Places of the field [m] as places of the drawing, shape (n, 2)."""
        return np.column_stack((100.0 * rows[:, 0], self.width - 100.0 * rows[:, 1]))

    # --- what stands still ----------------------------------------------------------------------------------------

    def ground(self) -> str:
        """Carpet, walls, field elements, and the scale in meters."""
        length, width = self.length, self.width
        parts = [element("rect", width=length, height=width, fill=color("carpet"))]
        scale = []
        along, up = ticks(0.0, length, 9), ticks(0.0, width, 6)
        for x in along:
            parts.append(line(x, 0, x, width, stroke=color("seams")))
            scale.append(words(x, width + 54.0, f"{x / 100:g}", 22, anchor="middle"))
        for y in up:
            parts.append(line(0, width - y, length, width - y, stroke=color("seams")))
            scale.append(words(-38.0, width - y + 7.0, f"{y / 100:g}", 22, anchor="end"))
        scale.append(words(_last_gap(along), width + 54.0, "x [m]", 22, anchor="middle", class_="axis"))
        scale.append(words(self.box[0] + 2.0, width - _last_gap(up) + 7.0, "y [m]", 22, class_="axis"))
        for name, corners in self.scene.field_outlines:
            fill, edge = tint(name)
            look = {"fill": fill, "stroke": edge, "stroke_width": 1.5, "opacity": 0.8}
            parts.append(polygon(self.points(corners), element("title", _plain(name)), **look))
        for y in (0.0, width):
            parts.append(line(0, y, length, y, stroke=color("ink"), stroke_width=3))
        for x, alliance in ((0.0, "blue"), (length, "red")):
            parts.append(line(x, 0, x, width, stroke=color(alliance), stroke_width=6))
        return element("g", *parts) + element("g", *scale, class_="scale")

    def paths(self, *, stamps: bool = False) -> str:
        """Where robots drove: darker with time, a part each second; dashed where they believed to be.

        Args:
            stamps: Draw the robot's outline along it, too.
        """
        parts = []
        for number, robot in enumerate(self.scene.robots):
            ink = path_ink(self.scene, robot)
            times, believed = self.track.estimates[number]
            if len(believed) and len(self.scene.robots) <= _FEW:
                look = {"stroke": color("ghost"), "stroke_width": 2.5, "stroke_dasharray": "9 7"}
                for way in self._ways(number, times, np.arange(len(believed)), max(1, len(believed) // 500)):
                    parts.append(polyline(self.points(believed[way]), opacity=0.9, class_="believed", **look))
            times, path = self.track.robots[number]
            if not len(path):
                continue
            start, end = float(times[0]), float(times[-1])
            step = max(1.0, (end - start) / _STAMP)
            for part in range(max(1, math.ceil((end - start) / step))):
                begin = start + part * step
                rows = np.nonzero((times >= begin - 0.021) & (times <= begin + step + 1e-9))[0]
                strength = 0.35 + 0.65 * (begin - start) / max(end - start, step)
                look = {"stroke": ink, "stroke_width": 5, "stroke_linecap": "round", "opacity": strength}
                if len(self.scene.robots) > 1 and robot.alliance == "red":
                    look |= {"stroke_dasharray": "18 9", "stroke_linecap": "butt"}
                for way in self._ways(number, times, rows, max(1, len(rows) // 40)):
                    parts.append(polyline(self.points(path[way]), **look))
                if stamps and len(rows):
                    parts.append(self._stamp(robot, path[rows[0]], ink, strength))
        return element("g", *parts, class_="paths")

    def _ways(self, number: int, times: FloatArray, rows: IntArray, step: int) -> list[IntArray]:
        """Rows of a robot's path, every `step` of them and the last: a list where it drove, from one place to the next.

        Args:
            number: Of the robot.
            times: Of all rows [s].
            rows: Which are drawn.
            step: How many are left out.
        """
        parts = np.searchsorted(self.track.placed_times(number), times[rows] + 1e-9)
        found = np.split(rows, np.nonzero(np.diff(parts))[0] + 1)
        return [np.append(way[::step], way[-1:]) for way in found]

    def _stamp(self, robot: RobotLook, pose: FloatArray, ink: str, strength: float) -> str:
        length, width = (100.0 * size for size in robot.bumpers)
        box = element("rect", x=-length / 2, y=-width / 2, width=length, height=width, fill="none")
        front = line(length / 2, -width / 2, length / 2, width / 2, stroke_width=5)
        place = self.place(*pose.tolist())
        return element("g", box, front, stroke=ink, stroke_width=1.5, opacity=strength, transform=place)

    def shot_traces(self, until: float | None = None, since: float = -math.inf) -> str:
        """Flights from above: solid to a dot for hits, dashed to a cross for misses.

        Args:
            until: Draw them as far as they came until then [s]; None: whole.
            since: Leave out those that ended before [s].
        """
        parts = []
        for shot in self.shots:
            rows = len(shot.times) if until is None else int(np.searchsorted(shot.times, until + 1e-9))
            if not rows or shot.times[-1] < since:
                continue
            way = self.points(shot.points[:rows])
            tip = (
                f"{shot.result}{f', {shot.side}' if shot.side else ''}, shot at {shot.time:.2f} s by robot {shot.robot}"
            )
            body = _flight(way, shot.result, is_whole=rows == len(shot.times))
            parts.append(element("g", element("title", tip), body))
        return element("g", *parts)

    def intake_marks(self, places: FloatArray) -> str:
        """Where pieces lay that were taken in."""
        marks = [_plus(x, y, 5.0) for x, y in self.points(places).tolist()]
        return element("path", d="".join(marks), stroke=color("path"), stroke_width=2, fill="none") if marks else ""

    def heat_maps(self) -> dict[str, str]:
        """By name: where robots were for how long, and where shots came down that missed."""
        driven = [rows[:, :2] for _, rows in self.track.robots if len(rows)]
        fell = [shot.points[-1:, :2] for shot in self.shots if shot.result == "miss"]
        maps = {"robot": (driven, "path"), "misses": (fell, "miss")}
        return {name: self.heat(np.concatenate(rows), ink) for name, (rows, ink) in maps.items() if rows}

    def heat(self, places: FloatArray, ink: str, *, cell: float = 0.5) -> str:
        """Cells, the denser the more was there; what is beside the field counts in the outermost ones.

        Args:
            places: In the field frame [m], shape (n, 2).
            ink: Name of a color.
            cell: Edge of a cell [m].
        """
        across, up = (math.ceil(size / cell) for size in self.scene.field_size)
        inside = np.clip(places, 0.0, np.array(self.scene.field_size) - 1e-6)
        counts, _, _ = np.histogram2d(
            inside[:, 0], inside[:, 1], bins=(across, up), range=((0.0, across * cell), (0.0, up * cell))
        )
        most = float(counts.max()) or 1.0
        cells = []
        for i, k in zip(*(rows.tolist() for rows in np.nonzero(counts)), strict=True):
            ((x, y),) = self.points(np.array([[i * cell, (k + 1) * cell]])).tolist()
            tip = element("title", f"{counts[i, k]:.0f} at x {(i + 0.5) * cell:g} m, y {(k + 0.5) * cell:g} m")
            look = {
                "width": 100.0 * cell,
                "height": 100.0 * cell,
                "opacity": 0.2 + 0.7 * math.sqrt(counts[i, k] / most),
            }
            cells.append(element("rect", tip, x=x, y=y, **look))
        return element("g", *cells, fill=color(ink))

    # --- what moves -----------------------------------------------------------------------------------------------

    def place(self, x: float, y: float, yaw: float) -> str:
        """The transform that puts a robot's symbol to a pose [m, m, rad]."""
        return f"translate({100.0 * x:.1f} {self.width - 100.0 * y:.1f}) rotate({-math.degrees(yaw):.1f})"

    def pieces(self, snapshot: Snapshot, layout: FrameLayout) -> Iterator[DrawnPiece]:
        """All pieces that are somewhere, small ones after large ones.

        Args:
            snapshot: When; with the newest of all arrays.
            layout: Knows where pieces are.
        """
        kinds = [one for one in layout.pieces(snapshot) if not one[0].key]
        for kind, poses, states in sorted(kinds, key=lambda one: -self.scene.look(one[0].name).reach):
            look = self.scene.look(kind.name)
            rows = np.column_stack((poses[:, :3], look.rectangles(poses), states))[states > 0]
            for x, y, z, length, width, heading, state in rows.tolist():
                robot = int(state) - HELD if state >= HELD else None
                is_high = state == IN_FLIGHT and z > _HIGH
                scale = 100.0 * (min(1.6, 1.15 + 0.25 * (z - _HIGH)) if is_high else 1.0)
                down = (self.width if robot is None else 0.0) - 100.0 * y
                degrees = -math.degrees(heading)
                yield DrawnPiece(look, robot, 100.0 * x, down, scale * length, scale * width, degrees, is_high)

    def moment(self, snapshot: Snapshot, layout: FrameLayout) -> str:
        """Everything that moves; see `pieces`."""
        pieces = [*self.pieces(snapshot, layout)]
        lying = [one.symbol() for one in pieces if one.robot is None]
        ghosts, robots = [], []
        for number, robot in enumerate(self.scene.robots):
            pose, believed = (snapshot.poses.get(f"{robot.prefix}/Robot/{end}") for end in ("Pose3d", "EstimatedPose"))
            if believed is not None:
                ghosts.append(robot_symbol(robot, is_ghost=True, transform=self.place(*planar(believed))))
            if pose is not None:
                place = self.place(*planar(pose))
                robots.append(element("g", self.robot(number, snapshot, pieces), transform=place))
        return "".join((*lying, *ghosts, *robots))

    def robot(self, number: int, snapshot: Snapshot, pieces: Sequence[DrawnPiece]) -> str:
        """A robot that is somewhere, with what it holds, its front to the right."""
        look = self.scene.robots[number]
        return robot_symbol(
            look,
            held="".join(one.symbol() for one in pieces if one.robot == number),
            label=self.labels[number],
            yaw=planar(snapshot.poses[look.pose_key])[2],
            is_active=snapshot.booleans.get(f"{look.prefix}/Debug/IntakeZoneActive", False),
        )

    @property
    def labels(self) -> list[str]:
        """What is written on each robot: its name or number; nothing on one that is alone."""
        robots = self.scene.robots
        return [(look.name or str(number)) if len(robots) > 1 else "" for number, look in enumerate(robots)]


def turned_box(x: float, y: float, length: float, width: float, degrees: float) -> FloatArray:
    """Corners of a rectangle about a place of a drawing, its length turned clockwise, shape (4, 2)."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    half = np.array([(-length, -width), (length, -width), (length, width), (-length, width)]) / 2.0
    found: FloatArray = (x, y) + half @ np.array([(c, s), (-s, c)])
    return found


def path_ink(scene: Scene, robot: RobotLook) -> str:
    """Color of a robot's path: its own, that of all paths if it is alone, else that of its alliance."""
    return color(robot.ink) if robot.ink else color("path") if len(scene.robots) == 1 else tint(robot.alliance)[1]


def planar(row: FloatArray) -> tuple[float, float, float]:
    """`x, y, yaw` [m, m, rad] of a pose `x, y, z, qw, qx, qy, qz`."""
    x, y, _, w, a, b, c = row.tolist()
    return x, y, math.atan2(2.0 * (w * c + a * b), 1.0 - 2.0 * (b * b + c * c))


def robot_symbol(
    look: RobotLook,
    *,
    held: str = "",
    label: str = "",
    yaw: float = 0.0,
    is_active: bool = False,
    is_ghost: bool = False,
    **attributes: object,
) -> str:
    """A robot with its front to the right: bumpers, what it holds, an arrow whose tip is at the front edge.

    Args:
        look: Its sizes and alliance.
        held: Pieces in it, in its own frame.
        label: Its number, which stays upright.
        yaw: Its heading, for that [rad].
        is_active: Show the zones of its intakes.
        is_ghost: Draw only a dashed outline: where it believes to be.
        attributes: Of the group.
    """
    length, width = (100.0 * size for size in look.bumpers)
    fill, edge = (color(look.ink), color(look.ink)) if look.ink else tint(look.alliance)
    box = {"x": -length / 2, "y": -width / 2, "width": length, "height": width, "rx": 5}
    tip, neck, head = length / 2 - _BUMPER, 0.5 * length - _BUMPER - 0.34 * length, 0.17 * width
    arrow = [(tip, 0.0), (neck, head), (neck, -head)]
    if is_ghost:
        look_of = {"fill": "none", "stroke": color("ghost"), "stroke_width": 3, "stroke_dasharray": "9 6"}
        return element("g", element("rect", **box, **look_of), polygon(arrow, **look_of), class_="ghost", **attributes)
    inner = {
        "x": -length / 2 + _BUMPER, "y": -width / 2 + _BUMPER, "width": length - 2 * _BUMPER,
        "height": width - 2 * _BUMPER, "rx": 2,
    }  # fmt: skip
    parts = [
        *(
            polygon([(100.0 * x, -100.0 * y) for x, y in zone], class_="intake", fill=color("path"),
                    fill_opacity=0.25, stroke=color("path"), stroke_width=2, stroke_dasharray="5 4",
                    visibility=None if is_active else "hidden")
            for zone in look.intakes
        ),
        element("rect", **box, fill=edge, stroke=color("paper"), stroke_width=1),
        element("rect", **inner, fill=fill, stroke="none"),
        element("rect", **inner, fill=color("paper"), opacity=0.72, stroke="none"),
        element("g", held or element("desc", "empty"), class_="held"),
        line(-0.5 * length + 2 * _BUMPER, 0, neck, 0, stroke=edge, stroke_width=5, opacity=0.9),
        polygon(arrow, fill=edge, stroke=color("paper"), stroke_width=1),
    ]  # fmt: skip
    if label:
        upright = f"rotate({math.degrees(yaw):.1f})"
        reach = max(17.0, 8.0 * len(label) + 6.0)
        badge = element(
            "rect", x=-reach, y=-17, width=2 * reach, height=34, rx=17, fill=color("paper"), stroke=edge, stroke_width=2
        )
        number = words(0.0, 9.5, label, 27, ink=color("ink"), anchor="middle", bold=True)
        parts.append(element("g", badge, number, class_="label", transform=upright))
    return element("g", *parts, class_="robot active" if is_active else "robot", **attributes)


def end_mark(x: float, y: float, size: float, result: ShotResult) -> str:
    """Where a shot ended: a dot for a hit, a cross for a miss, nothing for a pass and for one that flies."""
    if result in ("flying", "pass"):
        return ""
    if result == "hit":
        return element("circle", cx=x, cy=y, r=size * 0.8, fill=color("hit"), stroke=color("paper"), stroke_width=1)
    cross = f"M{x - size:.1f} {y - size:.1f}l{2 * size:g} {2 * size:g}m0 {-2 * size:g}l{-2 * size:g} {2 * size:g}"
    return element("path", d=cross, stroke=color("miss"), stroke_width=size / 2.2, fill="none")


def _flight(way: FloatArray, result: ShotResult, *, is_whole: bool = True) -> str:
    """A flight in a view: solid for hits, dashed for misses, and its mark if it is drawn to its end."""
    ink, dashes = {"hit": ("hit", None), "miss": ("miss", "10 6")}.get(result, ("muted", "3 4"))
    look = {"stroke": color(ink), "stroke_width": 2.5, "stroke_dasharray": dashes, "opacity": 0.85}
    return polyline(way, **look) + (end_mark(float(way[-1, 0]), float(way[-1, 1]), 7.0, result) if is_whole else "")


def _last_gap(marks: Sequence[float]) -> float:
    """The middle between the last two marks of a scale, where its name goes."""
    return 0.5 * (marks[-1] + marks[-2]) if len(marks) > 1 else 0.5 * marks[-1]


def _plus(x: float, y: float, size: float) -> str:
    return f"M{x - size:.1f} {y:.1f}h{2 * size:g}m{-size:g} {-size:g}v{2 * size:g}"


def _plain(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;")
