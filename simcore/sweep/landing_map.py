"""Where the shots of many runs came down, on the field: heat maps of hits and of misses."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping

import numpy as np

from simcore.show.field_drawing import FieldDrawing
from simcore.show.palette import color
from simcore.show.run_track import RunTrack
from simcore.show.scene import Scene
from simcore.show.svg import element
from simcore.telemetry.recording import Recording
from simcore.typing import FloatArray

__all__ = ["heat_map", "landings_of"]

_CELL = 0.25  # [m]


def landings_of(texts: Iterable[object]) -> Mapping[str, FloatArray]:
    """Places of hits and misses from the metric `landings` of runs.

    >>> {name: rows.tolist() for name, rows in landings_of(["[[4.6, 4.0, 1.8, 1], [3.0, 4.0, 0.1, 0]]", None]).items()}
    {'hits': [[4.6, 4.0]], 'misses': [[3.0, 4.0]]}

    Args:
        texts: Of each run a JSON list of `x, y, z, scored`; what is no text is a run without.

    Returns:
        `hits` and `misses`: x, y in the field frame [m], shape (n, 2).
    """
    rows = [row for text in texts if isinstance(text, str) for row in json.loads(text)]
    table = np.array(rows, dtype=float).reshape(len(rows), 4 if not rows else len(rows[0]))
    has_scored = table[:, -1] > 0.5
    return {"hits": table[has_scored, -4:-2], "misses": table[~has_scored, -4:-2]}


def heat_map(scene: Scene, places: FloatArray, ink: str) -> str:
    """The field with cells of 25 cm, the denser the more came down there.

    Args:
        scene: The bare field.
        places: x, y in the field frame [m], shape (n, 2); those beside the field are counted in its outermost cells.
        ink: Name of a color.
    """
    field = FieldDrawing(RunTrack(Recording(), scene), ())
    length, width = scene.field_size
    across, up = math.ceil(length / _CELL), math.ceil(width / _CELL)
    inside = np.clip(places, 0.0, (length - 1e-6, width - 1e-6))
    counts, _, _ = np.histogram2d(
        inside[:, 0], inside[:, 1], bins=(across, up), range=((0.0, across * _CELL), (0.0, up * _CELL))
    )
    most = float(counts.max()) or 1.0
    size = 100.0 * _CELL
    cells = []
    for i, k in zip(*(rows.tolist() for rows in np.nonzero(counts)), strict=True):
        ((x, y),) = field.points(np.array([[i * _CELL, (k + 1) * _CELL]])).tolist()
        tip = element("title", f"{counts[i, k]:.0f} at x {(i + 0.5) * _CELL:g} m, y {(k + 0.5) * _CELL:g} m")
        strength = 0.25 + 0.7 * math.sqrt(counts[i, k] / most)
        cells.append(element("rect", tip, x=x, y=y, width=size, height=size, opacity=strength))
    return field.drawing(field.ground(), element("g", *cells, fill=color(ink)))
