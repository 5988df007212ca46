"""Reader for pages of runs and of reports that works like their script."""

from __future__ import annotations

import base64
import gzip
import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np


def packed_block(text: str, name: str) -> bytes:
    """Return the data block of a page with a given name."""
    found = re.search(rf'<script type="text/plain" id="{name}">([^<]*)</script>', text)
    assert found, f"no {name} in the page"
    return gzip.decompress(base64.b64decode(found[1]))


def report_blocks(text: str) -> list[dict[str, Any]]:
    """Return the blocks of a report page."""
    blocks: list[dict[str, Any]] = json.loads(packed_block(text, "report"))
    return blocks


class PageReader:
    """Page of a run, read from a file."""

    def __init__(self, path: Path) -> None:
        self.text = path.read_text(encoding="utf-8")
        self.meta: dict[str, Any] = json.loads(packed_block(self.text, "run"))
        self._block = packed_block(self.text, "data")
        self.facts: dict[str, str] = dict(self.meta["facts"])
        self.words = json.dumps(self.meta, ensure_ascii=False)
        """All metadata as text, to search for words."""

    def array(self, place: list[int]) -> np.ndarray:
        """Return an array of 16-bit numbers, shape (n, m)."""
        offset, rows, columns = place
        n = rows * columns
        low, high = (np.frombuffer(self._block, np.uint8, n, offset + part * n).astype(int) for part in (0, 1))
        return (low + 256 * high).reshape(columns, rows).T.cumsum(axis=0).astype(np.uint16).astype(np.int16)

    def group(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Return times [s] and rows of a group of columns."""
        group = self.meta["groups"][name]
        if "rows" not in group:
            return np.empty(0), np.empty((0, group["width"]), np.int16)
        return self.meta["start"] + self.array(group["times"])[:, 0].cumsum() / 1000, self.array(group["rows"])

    def robot(self, number: int, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the pose [m, -], shape (7,), and the estimated pose [m, m, rad] of a robot at a frame."""
        times, rows = self.group("robots")
        row = rows[np.searchsorted(times, time - 1e-6)][11 * number : 11 * number + 11].astype(float)
        return np.concatenate((row[:3] / 1e3, row[3:7] / 32767)), row[7:10] / (1e3, 1e3, 1e4)

    def pieces(self, time: float) -> np.ndarray:
        """Return `x, y, z` [m] and the place code of each piece at a frame, shape (n, 4); kinds of balls only."""
        times, rows = self.group("pieces")
        found = rows[np.searchsorted(times, time - 1e-6)].reshape(-1, 4).astype(float)
        return found / (1e3, 1e3, 1e3, 1.0)

    def curve(self, title: str, label: str) -> tuple[np.ndarray, np.ndarray]:
        """Return times [s] and values of a curve in a chart."""
        (chart,) = (chart for chart in self.meta["charts"] if chart["title"] == title)
        (curve,) = (curve for curve in chart["curves"] if curve["label"] == label)
        steps, values = self.array(curve["data"]).astype(float).T
        return self.meta["start"] + steps.cumsum() / 1000, curve["low"] + (values + 32000) * curve["scale"]

    def table(self, start: str) -> list[list[str]]:
        """Return the rows of the table whose title begins with `start`, with cells as text."""
        (table,) = (table for table in self.meta["tables"] if table["title"].startswith(start))
        return [[cell if isinstance(cell, str) else cell[1] for cell in row] for row in (table["head"], *table["rows"])]

    def board(self, label: str, time: float) -> str:
        """Return the value of a line on the score board."""
        (item,) = (item for item in self.meta["board"] if item["label"] == label)
        return item["values"][max(0, int(np.searchsorted(item["times"], time + 1e-6)) - 1)]


def yaw_of(pose: np.ndarray) -> float:
    w, x, y, z = pose[3:]
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
