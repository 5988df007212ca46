"""A shooter table as a picture: which elevations and speeds go in at each distance, and which shot was taken."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable
from pathlib import Path

import numpy as np

from simcore.shooting.shot_band import ShotBand
from simcore.shooting.shot_table import ShotTable, ShotTableRow
from simcore.show.palette import color
from simcore.show.raster import save_drawing, writable_picture
from simcore.show.svg import document, element, line, nested, ticks, words

__all__ = ["draw_bands"]

_WIDTH, _COLUMNS = 1400.0, 4  # [px]
_PANEL = (320.0, 250.0)
_PLOT = (46.0, 26.0, 262.0, 176.0)  # left, top, width, height of the axes in a panel
_MOST = 16  # panels


def draw_bands(path: str | Path, table: ShotTable) -> None:
    """Draw a panel for each row, the first sixteen; missing folders are made.

    Args:
        path: A `.png`, `.svg` or `.pdf` file.
        table: What is drawn.

    Raises:
        OutputError: The picture cannot be written there, or as that kind of file.
    """
    path = writable_picture(path)
    task = table.task
    panels = list(zip(table.rows, table.bands, strict=True))[:_MOST]
    speeds = [band.speeds[np.nonzero(band.inside.any(axis=0))[0]] for band in table.bands if band is not None]
    inside = np.concatenate([some for some in speeds if len(some)] or [np.array([task.min_speed, task.max_speed])])
    low, high = task.elevations
    box = (float(inside.min()) * 0.95, float(inside.max()) * 1.05, math.degrees(low) - 4.0, math.degrees(high) + 4.0)
    parts = [
        words(40.0, 44.0, f"Shots that go into {task.zone.name}", 27, ink=color("ink"), bold=True),
        words(40.0, 72.0, "elevation over speed, by distance, from all barrels; cross: the shot of the table; its "
              "arms: how far speed and elevation alone may be off", 15),
    ]  # fmt: skip
    for number, (row, band) in enumerate(panels):
        y, x = divmod(number, _COLUMNS)
        drawing = _panel(row, band, box)
        parts.append(nested(drawing, 40.0 + x * (_PANEL[0] + 10.0), 90.0 + y * (_PANEL[1] + 14.0), *_PANEL))
    lines = math.ceil(len(panels) / _COLUMNS)
    height = 100.0 + lines * (_PANEL[1] + 14.0)
    save_drawing(document((0.0, 0.0, _WIDTH, height), *parts), path, round(_WIDTH))


def _panel(row: ShotTableRow, band: ShotBand | None, box: tuple[float, float, float, float]) -> str:
    """One row: axes, band and shot."""
    left, top, width, height = _PLOT
    slow, fast, flat, steep = box

    def across(speed: float) -> float:
        return left + (speed - slow) / (fast - slow) * width

    def down(elevation_deg: float) -> float:
        return top + (steep - elevation_deg) / (steep - flat) * height

    moving = "" if row.radial == row.tangential == 0.0 else f", moving {row.radial:g} / {row.tangential:g} m/s"
    parts = [words(left, top - 9.0, f"{row.distance:g} m{moving}", 14, ink=color("ink"), bold=True)]
    if row.share is not None:
        parts.append(words(left + width, top - 9.0, f"{row.share.value:.1%} go in", 12, anchor="end"))
    for speed in ticks(slow, fast, 6):
        parts.append(line(across(speed), top, across(speed), top + height, stroke=color("grid")))
        parts.append(words(across(speed), top + height + 15.0, f"{speed:g}", 11.5, anchor="middle"))
    for angle in ticks(flat, steep, 6):
        parts.append(line(left, down(angle), left + width, down(angle), stroke=color("grid")))
        parts.append(words(left - 5.0, down(angle) + 4.0, f"{angle:g}", 11.5, anchor="end"))
    parts.append(words(left + width, top + height + 30.0, "speed [m/s]", 11.5, anchor="end"))
    middle = f"translate(12 {top + 0.5 * height:g}) rotate(-90)"
    parts.append(words(0.0, 0.0, "[deg]", 11.5, anchor="middle", transform=middle))
    if band is not None:
        parts.append(element("g", *_runs(band, across, down), fill=color("hit"), opacity=0.45))
    if row.is_feasible:
        x, y = across(row.speed), down(math.degrees(row.elevation))
        look = {"stroke": color("ink"), "stroke_width": 1.8}
        parts.append(line(across(row.slowest), y, across(row.fastest), y, **look))
        parts.append(line(x, down(math.degrees(row.flattest)), x, down(math.degrees(row.steepest)), **look))
        parts.append(element("circle", cx=x, cy=y, r=4.0, fill=color("ink")))
    else:
        for number, text in enumerate(textwrap.wrap(row.problem, 34, break_long_words=False, break_on_hyphens=False)):
            parts.append(words(left + 0.5 * width, top + 80.0 + 18.0 * number, text, 13, anchor="middle"))
    return document((0.0, 0.0, *_PANEL), *parts)


def _runs(band: ShotBand, across: Callable[[float], float], down: Callable[[float], float]) -> list[str]:
    """A bar for each unbroken stretch of speeds of each elevation."""
    bars = []
    half = 0.5 * math.degrees(float(band.elevations[1] - band.elevations[0]))
    for elevation, inside in zip(np.degrees(band.elevations).tolist(), band.inside, strict=True):
        edges = np.nonzero(np.diff(np.pad(inside.astype(int), 1)))[0]
        for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
            start, end = across(float(band.speeds[first])), across(float(band.speeds[last - 1]))
            y = down(elevation + half)
            bars.append(element("rect", x=start, y=y, width=max(1.0, end - start), height=down(elevation - half) - y))
    return bars
