"""Which places of a field are taken: a board for each alliance with a row a level, and counts where the places are."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from simcore.show.palette import color, tint
from simcore.show.scene import LevelLook, Scene
from simcore.show.svg import document, element, words
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot
from simcore.typing import IntArray

__all__ = ["PlaceBoard", "counts_now"]

_WIDTH, _TOP, _HEIGHT = 360.0, 22.0, 200.0  # as a chart is, so that both stand in one row
_LEFT, _RIGHT = 44.0, 306.0  # of the cells
_ROW = 30.0  # at most
_MOST_NAMES, _LONGEST = 16, 3  # of the columns, and letters of a name
_LINE, _SIZE = 21.0, 20.0  # of counts on the field [cm]


def counts_now(snapshot: Snapshot, scene: Scene) -> dict[str, int]:
    """How many pieces are in each place, `<level>/<number>`, and on each level, `<level>`."""
    found: dict[str, int] = {}
    for level in scene.levels:
        counts = snapshot.integer_arrays.get(level.key, ())
        found |= {f"{level.name}/{number}": int(count) for number, count in enumerate(counts)}
        found[level.name] = int(np.sum(counts))
    return found


class PlaceBoard:
    """What was placed where in a run; nothing of a game without resting places.

    Args:
        recording: The run.
        scene: With the levels of the game that was played.
    """

    def __init__(self, recording: Recording, scene: Scene) -> None:
        self._recording = recording
        self._levels = [level for level in scene.levels if recording.has(level.key)]

    @property
    def alliances(self) -> list[str]:
        """Whose boards there are; one without a name for levels that are nobody's."""
        return list(dict.fromkeys(level.alliance for level in self._levels))

    def board(self, alliance: str, time: float, *, titled: bool = False) -> str:
        """One alliance's levels at a time [s]: places side by side, a filled mark where a piece is.

        Args:
            alliance: One of `alliances`.
            time: When.
            titled: Write a heading over it, as a picture needs.
        """
        levels = [level for level in self._levels if level.alliance == alliance]
        counts = [self._recording.integers_at(level.key, time) for level in levels]
        fill, edge = tint(alliance)
        widest = max(levels, key=lambda level: len(level.places))
        wide = (_RIGHT - _LEFT) / max(1, len(widest.places))
        tall = min(_ROW, (_HEIGHT - _TOP - 18.0) / len(levels))
        parts = []
        if len(widest.places) <= _MOST_NAMES and all(len(name) <= _LONGEST for name in widest.places):
            for number, name in enumerate(widest.places):
                parts.append(words(_LEFT + wide * (number + 0.5), 10.0, name, 11.5, anchor="middle"))
        for row, (level, taken) in enumerate(zip(levels, counts, strict=True)):
            middle = 18.0 + tall * (row + 0.5)
            parts.append(words(_LEFT - 8.0, middle + 5.0, level.label, 14, ink=color("ink"), anchor="end", bold=True))
            parts += _cells(level, taken, middle, tall, fill, edge)
            total = words(0.0, 0.0, f"{int(taken.sum())}", 14, ink=color("ink"), anchor="end", class_="n", bold=True)
            place = f"translate({_RIGHT + 22.0:g} {middle + 5.0:g})"
            parts.append(element("g", total, data_cell=level.name, transform=place))
            if level.is_single:
                parts.append(words(_RIGHT + 26.0, middle + 5.0, f"of {len(taken)}", 11.5))
        if not titled:
            return document((0, 0, _WIDTH, 22.0 + tall * len(levels)), *parts)
        parts.append(words(_LEFT, -8, self.heading(alliance), 13, ink=color("ink"), bold=True))
        return document((0, -_TOP, _WIDTH, _HEIGHT), element("g", *parts))

    @staticmethod
    def heading(alliance: str) -> str:
        """Of a board.

        >>> PlaceBoard.heading("blue")
        'Placed for blue'
        """
        return f"Placed for {alliance}" if alliance else "Placed"

    def field_counts(self, time: float, width: float) -> str:
        """How many pieces each level has at a time [s], written in the middle of its places on a drawing of the field.

        Args:
            time: When.
            width: Of the field [cm].
        """
        parts = []
        for (x, y), levels in self._spots():
            edge = tint(levels[0].alliance)[1]
            top = width - 100.0 * y - 0.5 * _LINE * len(levels)
            reach = 6.5 * max(len(level.label) for level in levels) + 18.0
            back = {"x": 100.0 * x - reach, "y": top - 3.0, "width": 2 * reach, "height": _LINE * len(levels) + 6.0}
            parts.append(element("rect", **back, rx=8, fill=color("paper"), opacity=0.85, stroke=edge))
            for row, level in enumerate(levels):
                total = int(self._recording.integers_at(level.key, time).sum())
                label = words(-4.0, 0.0, level.label, _SIZE, ink=color("muted"), anchor="end")
                count = words(5.0, 0.0, f"{total}", _SIZE, ink=color("ink"), class_="n", bold=True)
                place = f"translate({100.0 * x + reach - 25.0:.1f} {top + _LINE * (row + 0.75):.1f})"
                parts.append(element("g", label, count, data_cell=level.name, transform=place))
        return element("g", *parts, class_="counts") if parts else ""

    def _spots(self) -> Iterator[tuple[tuple[float, float], Sequence[LevelLook]]]:
        """Levels by the middle of their places."""
        spots: dict[tuple[int, int], list[LevelLook]] = {}
        for level in self._levels:
            if level.middle is not None:
                x, y = np.rint(4.0 * np.array(level.middle)).astype(int).tolist()
                spots.setdefault((x, y), []).append(level)
        for found in spots.values():
            assert found[0].middle is not None
            yield found[0].middle, found


def _cells(level: LevelLook, taken: IntArray, middle: float, tall: float, fill: str, edge: str) -> Iterator[str]:
    """The places of one level: rings that are filled, or boxes with numbers where there is room for several pieces."""
    wide = (_RIGHT - _LEFT) / max(1, len(taken))
    for number, count in enumerate(taken.tolist()):
        left = _LEFT + wide * number
        tip = element("title", f"{level.label} {name}" if (name := _name(level, number)) else level.label)
        hidden = None if count else "hidden"
        if level.is_single:
            at = {"cx": left + 0.5 * wide, "cy": middle}
            empty = element("circle", **at, r=0.3 * min(wide, tall), fill="none", stroke=color("control"))
            full = element("circle", **at, r=0.42 * min(wide, tall), fill=edge, class_="mark", visibility=hidden)
            text = ""
        else:
            box = {"x": left + 2.0, "y": middle - 0.4 * tall, "width": wide - 4.0, "height": 0.8 * tall, "rx": 4}
            empty = element("rect", **box, fill="none", stroke=color("control"))
            full = element("rect", **box, fill=fill, stroke=edge, class_="mark", visibility=hidden, stroke_width=2)
            ink = color("ink")
            text = words(left + 0.5 * wide, middle + 5.0, f"{count}", 14, ink=ink, anchor="middle", class_="n")
        look = "cell full" if count else "cell"
        yield element("g", tip, empty, full, text, class_=look, data_cell=f"{level.name}/{number}")


def _name(level: LevelLook, number: int) -> str:
    return level.places[number] if number < len(level.places) else ""
