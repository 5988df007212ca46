"""Which SPARKs a team's own simulation moves: through `SparkMaxSim`, `SparkFlexSim` and their encoders."""

from __future__ import annotations

import functools
import inspect
import weakref
from collections.abc import Callable
from typing import Any

import rev

__all__ = ["watch_spark_sims"]

Key = tuple[str, int]

_SIMS: dict[str, Any] = {"SPARK MAX": rev.SparkMaxSim, "SPARK Flex": rev.SparkFlexSim}
_WRITES = (
    *("iterate", "setPosition", "setVelocity", "setAppliedOutput", "setMotorCurrent", "setBusVoltage"),
    *("getRelativeEncoderSim", "getAbsoluteEncoderSim", "getAlternateEncoderSim", "getExternalEncoderSim"),
)
"""What writes, and what gives away something to write with."""

_sparks: weakref.WeakKeyDictionary[Any, Key] = weakref.WeakKeyDictionary()


def watch_spark_sims(may_write: Callable[[Key], bool]) -> None:
    """Ask before each write of a team's own simulation.

    Args:
        may_write: Gets model and id; False drops the write, as the device belongs to simcore.
    """
    for model, cls in _SIMS.items():
        cls.__init__ = _remembering(inspect.unwrap(cls.__init__), model)
        for name in _WRITES:
            if hasattr(cls, name):
                is_write = not name.startswith("get")
                setattr(cls, name, _guarded(inspect.unwrap(getattr(cls, name)), may_write, drop=is_write))


def _remembering(build: Any, model: str) -> Any:
    @functools.wraps(build)
    def init(self: Any, spark: Any, motor: Any) -> None:
        build(self, spark, motor)
        _sparks[self] = model, int(spark.getDeviceId())

    return init


def _guarded(call: Any, may_write: Callable[[Key], bool], *, drop: bool) -> Any:
    @functools.wraps(call)
    def guarded(self: Any, *args: Any) -> Any:
        key = _sparks.get(self)
        if key is not None and not may_write(key) and drop:
            return None
        return call(self, *args)

    return guarded
