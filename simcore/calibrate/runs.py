"""Runs of a log: what the motors were given, and what the wheels or the mechanism did, at common times."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from simcore.typing import FloatArray

__all__ = ["TICK", "Run", "thinned_run"]

TICK = 0.02  # [s], between two stamps of a run


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """One drive from standstill, or one motion of a mechanism, on n stamps."""

    name: str
    times: FloatArray
    """Rising from 0 [s], shape (n,)."""
    volts: FloatArray
    """Voltage of the motors from each stamp to the next [V], shape (n, sides)."""
    way: FloatArray
    """Distance of the wheels [m], or angle of the mechanism [rad], 0 at first, shape (n, sides)."""
    yaw: FloatArray | None = None
    """Yaw of the gyro, counter-clockwise, 0 at first [rad], shape (n,)."""
    ground: FloatArray | None = None
    """Distance over ground, not measured by the wheels, 0 at first [m], shape (n,)."""
    bus: FloatArray | None = None
    """Voltage of the battery [V], shape (n,)."""
    amps: FloatArray | None = None
    """Battery current [A], shape (n,)."""
    origin: float = 0.0
    """Angle of a mechanism at first [rad]."""

    @property
    def span(self) -> float:
        """Total distance that the wheels roll, forward and back [m]; 0 for a robot that stands."""
        return float(np.abs(np.diff(self.way, axis=0)).sum(axis=0).mean())

    def rows(self, first: int, last: int) -> Run:
        """Return a part of the run as a separate run, which starts at 0."""
        part = slice(first, last)
        cut = {name: None if (column := getattr(self, name)) is None else column[part] - column[first]
               for name in ("yaw", "ground")}  # fmt: skip
        kept = {name: None if (column := getattr(self, name)) is None else column[part] for name in ("bus", "amps")}
        return Run(
            self.name, self.times[part] - self.times[first], self.volts[part], self.way[part] - self.way[first],
            **cut, **kept, origin=self.origin + float(self.way[first].mean()),
        )  # fmt: skip


def thinned_run(run: Run, period: float = TICK) -> Run:
    """Return the run on stamps a period [s] apart or more: volts are means over what follows each, the rest stays."""
    times = run.times
    if len(times) < 3 or np.median(np.diff(times)) > 0.75 * period:
        return run
    starts = np.unique(np.searchsorted(times, np.arange(0.0, times[-1] + 1e-9, period) - 1e-6))
    means = np.add.reduceat(run.volts, starts, axis=0) / np.diff(starts, append=len(times))[:, None]
    kept: dict[str, Any] = {name: None if (column := getattr(run, name)) is None else column[starts]
                            for name in ("yaw", "ground", "bus", "amps")}  # fmt: skip
    return replace(run, times=times[starts], volts=means, way=run.way[starts], **kept)
