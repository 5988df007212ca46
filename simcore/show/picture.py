"""The summary of a run as one picture: the field from above with paths, shots and pieces, and the curves under it."""

from __future__ import annotations

from pathlib import Path

from simcore.show.charts import PLOT, chart_drawing, charts_of
from simcore.show.field_drawing import FieldDrawing, end_mark
from simcore.show.frames import FrameLayout, filled, piece_kinds
from simcore.show.palette import color
from simcore.show.place_board import PlaceBoard
from simcore.show.raster import save_drawing, writable_picture
from simcore.show.run_events import ending_of
from simcore.show.run_track import RunTrack
from simcore.show.scene import Scene
from simcore.show.shots import intake_places, shots_of
from simcore.show.svg import document, element, line, nested, words
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot

__all__ = ["draw_summary", "legend"]

_WIDTH, _LEFT, _TOP = 1600.0, 40.0, 92.0  # [px]
_FIELD = (1280.0, 700.0)  # [px]; the field is drawn as large as fits
_CHARTS, _CHARTS_IN_A_ROW = 6, 3
_FEW = 2  # robots of which all shots are drawn
_BELIEVED = "where it believed to be"


def draw_summary(path: str | Path, recording: Recording, scene: Scene, *, title: str = "", subtitle: str = "") -> None:
    """Draw what was recorded as a picture 1600 pixels wide; missing folders are made.

    Args:
        path: A `.png`, `.svg` or `.pdf` file.
        recording: The run.
        scene: What it took place on.
        title: In large letters.
        subtitle: Under it, in small ones.

    Raises:
        OutputError: The picture cannot be written there, or as that kind of file.
    """
    path = writable_picture(path)
    track = RunTrack(recording, scene)
    shots = shots_of(recording, scene)
    field = FieldDrawing(track, shots)
    start, end = track.span
    taken = intake_places(recording)
    board = PlaceBoard(recording, scene)
    counts = board.field_counts(end, field.width)
    around = [field.ground(), field.paths(stamps=len(scene.robots) == 1)]
    if len(scene.robots) <= _FEW:  # a match has hundreds: they would hide the field
        around += [field.intake_marks(taken), field.shot_traces()]
    last = [*filled(recording)][-1:] or [Snapshot(time=0.0, tick=0)]
    moving = field.moment(last[0], FrameLayout(scene, (), piece_kinds(recording, scene)))
    drawing = field.drawing(*around, moving, counts)

    parts = [
        words(_LEFT, 44, title, 27, ink=color("ink"), bold=True),
        words(
            _LEFT, 74, ". ".join(filter(None, (subtitle, *(text.splitlines()[0] for text in ending_of(recording))))), 16
        ),
    ]
    scale = min(_FIELD[0] / field.box[2], _FIELD[1] / field.box[3])
    width, height = scale * field.box[2], scale * field.box[3]
    parts.append(nested(drawing, _LEFT, _TOP, width, height))
    marks = legend(field, intakes=len(taken))
    marks = [mark for mark in marks if len(scene.robots) <= _FEW or mark[1] != _BELIEVED]
    for number, (mark, label) in enumerate(marks):
        y = _TOP + 40 + 30 * number
        parts.append(element("g", mark, transform=f"translate({_LEFT + width + 22:g} {y - 5:g})"))
        parts.append(words(_LEFT + width + 54, y, label, 14, ink=color("ink")))
    bottom = _TOP + max(height, 40.0 + 30.0 * len(marks)) + 10
    wide = (_WIDTH - 2 * _LEFT - 40) / _CHARTS_IN_A_ROW
    tall = wide * (PLOT["bottom"] + 22) / PLOT["total"]
    drawings = [board.board(alliance, end, titled=True) for alliance in board.alliances]
    drawings += [
        chart_drawing(chart, start, end) for chart in charts_of(track)[: _CHARTS + -len(drawings) % _CHARTS_IN_A_ROW]
    ]
    for number, drawing in enumerate(drawings):
        row, column = divmod(number, _CHARTS_IN_A_ROW)
        place = (_LEFT + (wide + 20) * column, bottom + 10 + (tall + 16) * row)
        parts.append(nested(drawing, *place, wide, tall))
    rows = -(-len(drawings) // _CHARTS_IN_A_ROW)
    save_drawing(document((0, 0, _WIDTH, bottom + 20 + rows * (tall + 16)), *parts), path, round(_WIDTH))


def legend(field: FieldDrawing, *, intakes: int) -> list[tuple[str, str]]:
    """What each mark of a drawing means: an element 24 by 14 units around the origin, and words.

    Args:
        field: The drawing.
        intakes: Pieces that were taken in.
    """
    scene, shots = field.scene, field.shots
    hits, misses = (len([shot for shot in shots if shot.result == result]) for result in ("hit", "miss"))

    def stroke(ink: str, dashes: str | None = None, width: float = 3.0) -> str:
        return line(-12, 0, 12, 0, stroke=color(ink), stroke_width=width, stroke_dasharray=dashes)

    marks: list[tuple[str, str]] = []
    for name, look in scene.pieces.items():
        shape = {"fill": look.color, "stroke": look.edge_color}
        ball, box = element("circle", r=6, **shape), element("rect", x=-7, y=-5, width=14, height=10, **shape)
        marks.append((box if look.size else ball, name.lower()))
    apart = any(robot.score_key for robot in scene.robots)
    if apart:  # two runs
        marks += [(stroke(robot.ink, None, 4.0), f"path, {robot.name}") for robot in scene.robots]
    elif len(scene.robots) == 1:
        marks.append((stroke("path", None, 4.0), "path"))
    else:
        for ink in sorted({robot.alliance for robot in scene.robots}):
            marks.append((stroke(ink, "9 4" if ink == "red" else None, 4.0), f"path of a {ink} robot"))
    if any(len(times) for times, _ in field.track.estimates):
        marks.append((stroke("ghost", "7 4"), _BELIEVED))
    if shots:
        marks.append((stroke("hit", width=2) + end_mark(12, 0, 5, "hit"), "hit" if apart else f"hit ({hits})"))
        miss = stroke("miss", "6 4", 2) + end_mark(12, 0, 5, "miss")
        marks.append((miss, "miss" if apart else f"miss ({misses})"))
    if intakes:
        cross = element("path", d="M-5 0h10m-5 -5v10", stroke=color("path"), stroke_width=2)
        marks.append((cross, "taken in" if apart else f"taken in ({intakes})"))
    return marks
