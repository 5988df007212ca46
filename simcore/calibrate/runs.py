"""Runs of a log: motor voltages and the motion of wheels or a mechanism, at common sample times."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from simcore.typing import FloatArray

__all__ = ["TICK", "Run", "thinned_run"]

TICK = 0.02  # [s], time between two samples of a run


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """Part of a log with one motion of a robot or a mechanism, at n sample times."""

    name: str
    times: FloatArray
    """Sample times in ascending order from 0 [s], shape (n,)."""
    volts: FloatArray
    """Motor voltage from each sample to the next [V], shape (n, sides)."""
    way: FloatArray
    """Wheel distance [m] or mechanism angle [rad] from the start of the run, shape (n, sides)."""
    yaw: FloatArray | None = None
    """Gyro yaw from the start of the run, counter-clockwise [rad], shape (n,); None if not logged."""
    ground: FloatArray | None = None
    """Distance over ground from the start of the run, measured without the wheels [m], shape (n,); None if not logged.
    """
    bus: FloatArray | None = None
    """Battery voltage [V], shape (n,); None if not logged."""
    amps: FloatArray | None = None
    """Battery current [A], shape (n,); None if not logged."""
    origin: float = 0.0
    """Mechanism angle at the start of the run [rad]."""

    @property
    def span(self) -> float:
        """Total distance forward and backward, as the mean over the sides [m]; total angle [rad] for a mechanism."""
        return float(np.abs(np.diff(self.way, axis=0)).sum(axis=0).mean())

    def rows(self, first: int, last: int) -> Run:
        """Return the samples from `first` to before `last` as a new run that starts at time 0 and distance 0."""
        part = slice(first, last)
        cut = {name: None if (column := getattr(self, name)) is None else column[part] - column[first]
               for name in ("yaw", "ground")}  # fmt: skip
        kept = {name: None if (column := getattr(self, name)) is None else column[part] for name in ("bus", "amps")}
        return Run(
            self.name, self.times[part] - self.times[first], self.volts[part], self.way[part] - self.way[first],
            **cut, **kept, origin=self.origin + float(self.way[first].mean()),
        )  # fmt: skip


def thinned_run(run: Run, period: float = TICK) -> Run:
    """Return a run with samples about one period [s] apart, with averaged voltages and other values subsampled.

    A run with a median sample interval above 0.75 periods, or with fewer than 3 samples, is unchanged.
    """
    times = run.times
    if len(times) < 3 or np.median(np.diff(times)) > 0.75 * period:
        return run
    starts = np.unique(np.searchsorted(times, np.arange(0.0, times[-1] + 1e-9, period) - 1e-6))
    means = np.add.reduceat(run.volts, starts, axis=0) / np.diff(starts, append=len(times))[:, None]
    kept: dict[str, Any] = {name: None if (column := getattr(run, name)) is None else column[starts]
                            for name in ("yaw", "ground", "bus", "amps")}  # fmt: skip
    return replace(run, times=times[starts], volts=means, way=run.way[starts], **kept)
