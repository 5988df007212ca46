"""What is kept of a run while it runs: a digest of the trajectory, and how long the ticks took."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from simcore.errors import ConfigError

__all__ = ["TickTimer", "TickTimes", "TrajectoryDigest"]


class TrajectoryDigest:
    """SHA-256 over a run's state: two runs with the same digest were the same to the last bit.

    >>> one, two = TrajectoryDigest(), TrajectoryDigest()
    >>> one.update(np.array([0.0, 1.0]))
    >>> two.update(np.array([-0.0, 1.0]))
    >>> one.hexdigest() == two.hexdigest()
    True
    """

    def __init__(self) -> None:
        self._hash = hashlib.sha256()

    def update(self, *arrays: npt.NDArray[Any]) -> None:
        """Feed the state of one tick, always the same arrays in the same order.

        Arrays are of any numbers, and their shapes are part of the digest. Values count as little-endian float64, so
        any computer agrees; -0.0 counts as 0.0, for they are equal and which of the two comes out of a sum is an
        accident.
        """
        for array in arrays:
            # Adding +0.0 turns -0.0 into 0.0, changes nothing else and makes the copy that is hashed.
            values = np.asarray(array, dtype="<f8") + 0.0
            self._hash.update(f"{values.shape}".encode())
            self._hash.update(values.astype("<f8", copy=False).tobytes())

    def hexdigest(self) -> str:
        """The digest so far, 64 hexadecimal digits; updating may go on."""
        return self._hash.hexdigest()


@dataclass(frozen=True, slots=True, kw_only=True)
class TickTimes:
    """How long ticks took [ms]; all 0 when there was none."""

    median: float
    p95: float
    p99: float
    max: float


class TickTimer:
    """Collects how long each tick took.

    It reads no clock: the runner takes `time.perf_counter` before and after a tick and hands over the difference.
    """

    def __init__(self) -> None:
        self._seconds: list[float] = []

    def __len__(self) -> int:
        return len(self._seconds)

    def add(self, seconds: float) -> None:
        """Note one tick [s].

        Raises:
            ConfigError: A negative or non-finite time.
        """
        if not (math.isfinite(seconds) and seconds >= 0.0):
            raise ConfigError(f"a tick takes a finite time >= 0 s, got {seconds}")
        self._seconds.append(seconds)

    def times(self) -> TickTimes:
        """Median, 95th and 99th percentile and worst tick so far."""
        if not self._seconds:
            return TickTimes(median=0.0, p95=0.0, p99=0.0, max=0.0)
        median, p95, p99, worst = np.percentile(np.array(self._seconds) * 1e3, [50.0, 95.0, 99.0, 100.0]).tolist()
        return TickTimes(median=median, p95=p95, p99=p99, max=worst)
