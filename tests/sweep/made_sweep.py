"""Synthetic runs of a sweep, with the columns of a real sweep."""

import base64
import functools
import gzip
import json
import re
from types import SimpleNamespace

import numpy as np

from simcore.sweep.results import Results


def described(*factors, **rest):
    """Return a stand-in for an experiment, with the attributes that Results reads."""
    named = tuple(SimpleNamespace(name=name) for name in factors)
    told = {"factors": named, "game": "made", "auto": "depot", **rest}
    return SimpleNamespace(project=None, red="", blue="", **told)


def blocks_of(page):
    """Return the blocks of a report from the text of its page."""
    text = re.search(r'id="report">([^<]*)<', page)[1]
    return json.loads(gzip.decompress(base64.b64decode(text)))


def same(results):
    """Return the rows without the processor time, which may differ between equal runs."""
    return [{name: value for name, value in row.items() if name != "cpu_seconds"} for row in results.rows]


def runs_of(points, columns, *, seeds=1):
    """Return a row for each point and seed.

    Args:
        points: Values of the factors by name; each array has a value for each point.
        columns: Function of the values of a point and a seed that returns the metrics of that run.
        seeds: Number of seeds, counted from 0.
    """
    count = len(next(iter(points.values())))
    rows = []
    for point in range(count):
        values = {name: float(column[point]) for name, column in points.items()}
        for seed in range(seeds):
            beside = {"run": len(rows), "point": point, "seed": seed}
            after = {"digest": f"{len(rows):064x}", "version": "1", "error": "", "cpu_seconds": 3.5}
            rows.append({**beside, **values, **columns(values, seed), **after})
    return rows


@functools.cache
def tired_battery():
    """Return results of 20 seeds for three battery charges and two masses; a fuller battery raises the score."""

    def play(values, seed):
        generator = np.random.default_rng([seed, 7])
        luck = generator.integers(-4, 5)
        points = int(20 + 8 * values["battery.charge"] - 0.2 * (values["robot.mass"] - 50) + luck)
        shots = 32
        hits = min(shots, max(0, points))
        return {"score": points, "shots": shots, "hits": hits, "min_battery_v": 7.0 + 3.0 * values["battery.charge"],
                "brownouts": 0}  # fmt: skip

    grid = np.array([(c, m) for c in (0.3, 0.65, 1.0) for m in (45.0, 60.0)])
    rows = runs_of({"battery.charge": grid[:, 0], "robot.mass": grid[:, 1]}, play, seeds=20)
    return Results(rows, described("battery.charge", "robot.mass"))
