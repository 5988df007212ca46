"""Metrics of a run: numbers by name, and functions of a team's own."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from simcore.errors import ConfigError, UnknownNameError
from simcore.match.match import Match
from simcore.match.run_record import ShotRecord
from simcore.quantities import shown
from simcore.typing import FloatArray

__all__ = ["LANDINGS", "METRICS", "PlayedRun", "landings_of", "measure", "metric_name", "named_object"]


@dataclass(frozen=True, slots=True)
class PlayedRun:
    """A match at its end, for metrics."""

    match: Match
    path: FloatArray
    """Of the first robot, a row a tick: x, y, yaw [m, m, rad]."""

    @property
    def alliance(self) -> str:
        """Alliance of the first robot."""
        return self.match.alliances[0]


def _score(run: PlayedRun) -> int:
    return run.match.score.blue if run.alliance == "blue" else run.match.score.red


def _flying(run: PlayedRun) -> list[ShotRecord]:
    """Return the shots that had not touched anything yet at the end."""
    last = {shot.slot: shot for shot in run.match.record.shots}
    return [last[slot] for slot in run.match.record.flying.tolist()]


def _hit_share(run: PlayedRun) -> float:
    ended = len(run.match.record.shots) - len(_flying(run))
    return run.match.record.hits / ended if ended else math.nan


def _last_shot(run: PlayedRun) -> float:
    return max((shot.time for shot in run.match.record.shots), default=math.nan)


def _landings(run: PlayedRun) -> list[list[float]]:
    flying = {id(shot) for shot in _flying(run)}
    shots = [shot for shot in run.match.record.shots if id(shot) not in flying]
    return [[*(round(c, 3) for c in _landing(shot)), int(shot.scored)] for shot in shots]


METRICS: dict[str, Callable[[PlayedRun], Any]] = {
    "score": _score,
    "score_of_others": lambda run: run.match.score.total - _score(run),
    "shots": lambda run: len(run.match.record.shots),
    "hits": lambda run: run.match.record.hits,
    "flying": lambda run: len(_flying(run)),
    "hit_share": _hit_share,
    "taken_in": lambda run: len(run.match.record.taken_in),
    "last_shot_s": _last_shot,
    "scored": lambda run: run.match.count.scored,
    "placed": lambda run: run.match.count.placed,
    "held": lambda run: run.match.count.held,
    "distance_m": lambda run: run.match.record.robots[0].distance,
    "min_battery_v": lambda run: run.match.record.robots[0].battery.min_voltage,
    "brownouts": lambda run: run.match.record.robots[0].battery.brownouts,
    "seconds": lambda run: run.match.time,
}
"""Numbers measured in every run, in this order: points of the robot's own alliance and of the other one; pieces shot,
those scored, those still in the air at the end, and the share of hits among the others; pieces taken in; when the last
one was shot, with which a shooter's cycle ends [s]; pieces scored, placed and held by anybody at the end; way driven,
not carried [m]; lowest battery voltage [V] and brown-outs; simulated time [s]. `breakdown.<name>` follows for what the
game counts, and `landings`."""

LANDINGS = "landings"
_ROWS: dict[str, Callable[[PlayedRun], Any]] = {LANDINGS: _landings, "path": lambda run: run.path[::5].tolist()}
"""Arrays, as text. `landings`: of each shot that came down x, y, z of where it first did [m], and 1 if it scored.
`path`: x, y, yaw of the robot, ten a second [m, m, rad]; only where it is named."""


def measure(run: PlayedRun, names: Sequence[str]) -> dict[str, Any]:
    """Return metrics of a run, in plain types.

    Args:
        run: At its end.
        names: Which; none: all of `METRICS`, the game's breakdown, and of robots that shoot `landings`.

    Raises:
        UnknownNameError: There is no such metric.
        ConfigError: A function has returned what is neither a number, nor a word, nor an array of numbers.
    """
    counts = {**run.match.tracker.pieces, **run.match.rules.breakdown()}
    breakdown = {f"breakdown.{name}": count for name, count in counts.items()}
    found: dict[str, Any] = {}
    shot = [LANDINGS] if run.match.robots[0].shooters else []
    for name in names or (*METRICS, *breakdown, *shot):
        if name in METRICS or name in _ROWS:
            found[name] = _plain(name, (METRICS.get(name) or _ROWS[name])(run))
        elif name in breakdown:
            found[name] = _plain(name, breakdown[name])
        elif ":" in name:
            found[name.partition(":")[2]] = _plain(name, named_object(name, "metric")(run))
        else:
            raise UnknownNameError("metric", name, (*METRICS, *_ROWS, *breakdown))
    return found


def landings_of(texts: Iterable[object]) -> Mapping[str, FloatArray]:
    """Return places of hits and misses from the metric `landings` of runs.

    >>> {name: rows.tolist() for name, rows in landings_of(["[[4.6, 4.0, 1.8, 1], [3.0, 4.0, 0.1, 0]]", None]).items()}
    {'hits': [[4.6, 4.0]], 'misses': [[3.0, 4.0]]}

    Args:
        texts: Of each run a JSON list of `x, y, z, scored`; None: a run without.

    Returns:
        `hits` and `misses`: x, y in the field frame [m], shape (n, 2).

    Raises:
        ValueError: A text is no such list.
    """
    rows = [row for text in texts if text is not None for row in json.loads(str(text))]
    table = np.array(rows, dtype=float).reshape(len(rows), 4)
    has_scored = table[:, 3] > 0.5
    return {"hits": table[has_scored, :2], "misses": table[~has_scored, :2]}


def metric_name(metric: str | Callable[[PlayedRun], Any]) -> str:
    """Return the name of a metric, or `module:function` of a function.

    Raises:
        ConfigError: It is a function that another process cannot find.
        UnknownNameError: There is no such metric.
    """
    if isinstance(metric, str):
        if ":" in metric:
            named_object(metric, "metric")
        elif metric not in METRICS and metric not in _ROWS and not metric.startswith("breakdown."):
            raise UnknownNameError("metric", metric, (*METRICS, *_ROWS))
        return metric
    module, name = getattr(metric, "__module__", ""), getattr(metric, "__qualname__", "")
    if module in ("", "__main__") or not name.isidentifier():
        raise ConfigError(
            f"metric {shown(metric)}: workers can only find a function at the top of a module, as 'module:function'"
        )
    return f"{module}:{name}"


def named_object(text: str, what: str) -> Any:
    """Return what `module:name` names.

    Raises:
        ConfigError: There is no such module, or it has no such name.
    """
    module, _, name = text.partition(":")
    try:
        return getattr(import_module(module), name)
    except (ImportError, AttributeError, ValueError) as error:
        raise ConfigError(f"{what} {text!r} cannot be found: {error}; want module:name") from error


def _landing(shot: ShotRecord) -> tuple[float, float, float]:
    """Return where a shot came down: of a hit where it scored, else its lowest point before it first rose again."""
    if not shot.scored:
        points = shot.points
        for before, at, after in zip(points, points[1:], points[2:], strict=False):
            if before[2] > at[2] <= after[2]:
                return at
    return shot.points[-1]


def _plain(name: str, value: Any) -> Any:
    """Return a value as JSON knows it, arrays as text."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, (list, tuple, Mapping)):
        return json.dumps(value)
    raise ConfigError(f"metric {name}: want a number, a word or an array, got {shown(value)}")
