"""Measurement of a finished run by standard metrics and by functions that a team provides."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any

import numpy as np

from simcore.errors import ConfigError, UnknownNameError
from simcore.match.match import Match
from simcore.match.run_record import ShotRecord
from simcore.quantities import shown

__all__ = ["METRICS", "measure", "metric_name", "named_object"]


def _score(match: Match) -> int:
    return match.score.blue if match.alliances[0] == "blue" else match.score.red


def _flying(match: Match) -> list[ShotRecord]:
    """Return the shots that are still in flight at the end of the match."""
    last = {shot.slot: shot for shot in match.record.shots}
    return [last[slot] for slot in match.record.flying.tolist()]


def _hit_share(match: Match) -> float:
    ended = len(match.record.shots) - len(_flying(match))
    return match.record.hits / ended if ended else math.nan


def _last_shot(match: Match) -> float:
    return max((shot.time for shot in match.record.shots), default=math.nan)


METRICS: dict[str, Callable[[Match], Any]] = {
    "score": _score,
    "score_of_others": lambda match: match.score.total - _score(match),
    "shots": lambda match: len(match.record.shots),
    "hits": lambda match: match.record.hits,
    "flying": lambda match: len(_flying(match)),
    "hit_share": _hit_share,
    "taken_in": lambda match: len(match.record.taken_in),
    "last_shot_s": _last_shot,
    "scored": lambda match: match.count.scored,
    "placed": lambda match: match.count.placed,
    "held": lambda match: match.count.held,
    "distance_m": lambda match: match.record.robots[0].distance,
    "min_battery_v": lambda match: match.record.robots[0].battery.min_voltage,
    "brownouts": lambda match: match.record.robots[0].battery.brownouts,
    "seconds": lambda match: match.time,
}
"""Functions of the standard metrics, by name.

- `score`, `score_of_others`: points of the alliance of robot 0, and of the other alliance;
- `shots`, `hits`, `flying`: numbers of shots, of shots that scored, and of shots in flight at the end;
- `hit_share`: fraction of hits among the shots that are no longer in flight [-];
- `taken_in`: number of pieces that intakes have picked up;
- `last_shot_s`: time of the last shot [s];
- `scored`, `placed`, `held`: numbers of pieces scored, placed and held by all robots at the end;
- `distance_m`, `min_battery_v`, `brownouts`: distance driven by robot 0, without moves by hand [m], the lowest battery
  voltage [V] and the number of brownouts of robot 0;
- `seconds`: simulated duration [s].

The counts of the game are metrics with the names `breakdown.<name>`.
"""


def measure(match: Match, names: Sequence[str]) -> dict[str, Any]:
    """Return the metrics of a finished match, in plain types.

    Args:
        match: Finished match.
        names: Names of the metrics, or `module:function`; empty for all of `METRICS` and the game's breakdown.

    Raises:
        UnknownNameError: If a metric does not exist.
        ConfigError: If a function does not return a number, a word or an array of numbers.
    """
    breakdown = {f"breakdown.{name}": count for name, count in match.breakdown().items()}
    found: dict[str, Any] = {}
    for name in names or (*METRICS, *breakdown):
        if name in METRICS:
            found[name] = _plain(name, METRICS[name](match))
        elif name in breakdown:
            found[name] = _plain(name, breakdown[name])
        elif ":" in name:
            found[name.partition(":")[2]] = _plain(name, named_object(name, "metric")(match))
        else:
            raise UnknownNameError("metric", name, (*METRICS, *breakdown))
    return found


def metric_name(metric: str | Callable[[Match], Any]) -> str:
    """Check a metric, and return the name of the metric, or `module:function` if the metric is a function.

    Raises:
        ConfigError: If another process could not import the function.
        UnknownNameError: If the metric does not exist.
    """
    if isinstance(metric, str):
        if ":" in metric:
            named_object(metric, "metric")
        elif metric not in METRICS and not metric.startswith("breakdown."):
            raise UnknownNameError("metric", metric, METRICS)
        return metric
    module, name = getattr(metric, "__module__", ""), getattr(metric, "__qualname__", "")
    if module in ("", "__main__") or not name.isidentifier():
        raise ConfigError(
            f"metric {shown(metric)}: workers can only find a function at the top of a module, as 'module:function'"
        )
    return f"{module}:{name}"


def named_object(text: str, what: str) -> Any:
    """Import a module and return the object that a text `module:name` names.

    Args:
        text: Names of the module and of the object.
        what: Kind of the object, for error messages.

    Raises:
        ConfigError: If the module or the name does not exist.
    """
    module, _, name = text.partition(":")
    try:
        return getattr(import_module(module), name)
    except (ImportError, AttributeError, ValueError) as error:
        raise ConfigError(f"{what} {text!r} cannot be found: {error}; write module:name") from error


def _plain(name: str, value: Any) -> Any:
    """Convert the value of a metric to a plain number, text or None.

    NaN and infinity become None. Arrays, lists, tuples and mappings become JSON text.

    Raises:
        ConfigError: If the value has any other type.
    """
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
    raise ConfigError(f"metric {name}: it must return a number, a word or an array, got {shown(value)}")
