"""Real time for the real Phoenix 6: its simulation runs on the wall clock, so physics must keep up.

With SIMULATED set, the scenario runs on the emulator as fast as possible.
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
    """Start the HAL without a robot, and without a diagnostics server that could clash with another process."""
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
    """Loop that calls `each` every 5 ms by the wall clock and records its delays."""

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
        """99th percentile of the delay [ms]; above 5 ms the devices read stale rotors and results are void."""
        return 1e3 * float(np.percentile(self.late, 99))


def report(loop: Loop, **results: object) -> None:
    """Print the report for the test, as the last line of the output."""
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
