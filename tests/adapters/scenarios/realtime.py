"""Real time for the real Phoenix 6: its simulation runs on the wall clock, so physics must keep to it.

With SIMULATED set the same scenario runs on the emulator, as fast as it can.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable

import hal
import numpy as np
from phoenix6 import unmanaged
from wpilib.simulation import DriverStationSim, RoboRioSim, pauseTiming, stepTiming

from simcore.robotcode import emulator

DT = 0.005
SIMULATED = bool(os.environ.get("SIMULATED"))


def start() -> None:
    """The HAL without a robot, and no diagnostics server that could meet another process."""
    if SIMULATED:
        emulator.install()
        pauseTiming()
    unmanaged.set_phoenix_diagnostics_start_time(-1)
    hal.initialize(500, 0)
    RoboRioSim.setVInVoltage(12.0)


def enable(on: bool = True) -> None:
    DriverStationSim.setDsAttached(True)
    DriverStationSim.setEnabled(on)
    DriverStationSim.notifyNewData()


class Loop:
    """Calls `each` every 5 ms by the wall clock and remembers how late it was."""

    def __init__(self, each: Callable[[], None]) -> None:
        self.each = each
        self.late: list[float] = []
        self.work: list[float] = []

    def run(self, seconds: float, watch: Callable[[float], None] = lambda t: None) -> None:
        begin = time.perf_counter()
        for k in range(round(seconds / DT)):
            due = begin + k * DT
            rest = due - time.perf_counter()
            if rest > 0.0 and not SIMULATED:
                time.sleep(rest)
            now = time.perf_counter()
            self.late.append(0.0 if SIMULATED else now - due)
            self.each()
            watch(k * DT)
            if SIMULATED:
                stepTiming(DT)  # the library feeds its enable signal by the robot's clock
                emulator.installed().step(DT)
            self.work.append(time.perf_counter() - now)

    @property
    def lateness_ms(self) -> float:
        """99th percentile [ms]; above 5 the devices saw stale rotors, and results mean nothing."""
        return 1e3 * float(np.percentile(self.late, 99))


def report(loop: Loop, **results: object) -> None:
    """The last line of the output: what the test reads."""
    work = 1e3 * np.array(loop.work)
    print(
        json.dumps(
            {
                "lateness_ms": loop.lateness_ms,
                "work_ms_median": float(np.median(work)),
                "work_ms_p99": float(np.percentile(work, 99)),
                **results,
            }
        ),
        flush=True,
    )
