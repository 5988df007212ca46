"""What the marks of a drawing from above mean."""

from __future__ import annotations

from simcore.show.field_drawing import FieldDrawing, end_mark
from simcore.show.palette import color
from simcore.show.svg import element, line

__all__ = ["legend"]

_BELIEVED = "where it believed to be"


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
