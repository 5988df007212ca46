"""Drives the course in a robot project under `robotpy sim --nogui --simcore`, in real time.

Run it in the project's folder. Argument: `field` or `robot`, what the program's sticks mean. Prints one line of JSON.
"""

from __future__ import annotations

import json
import os
import sys
import time

import numpy as np
from course import Course
from hal import AllianceStationID
from phoenix6 import unmanaged
from robotpy.main import main as robotpy_main
from wpilib.simulation import DriverStationSim

from simcore.robotpy.robot_physics import RobotPhysics


class Play:
    """Called after every tick of the physics."""

    def __init__(self, *, is_field_centric: bool) -> None:
        DriverStationSim.setAllianceStationId(AllianceStationID.kBlue1)
        self.is_field_centric = is_field_centric
        self.steps = None
        self.walls: list[float] = []

    def __call__(self, physics: RobotPhysics) -> None:
        if self.steps is None:
            self.course = Course(physics, is_field_centric=self.is_field_centric, enable=self.enable)
            self.steps = self.course.run()
        self.walls.append(time.perf_counter())
        try:
            next(self.steps)
        except StopIteration:
            self.finish(physics)

    def enable(self) -> None:
        DriverStationSim.setDsAttached(True)
        DriverStationSim.setEnabled(True)
        DriverStationSim.notifyNewData()

    def finish(self, physics: RobotPhysics) -> None:
        times = physics.times
        late = max(0.0, float(np.percentile(np.diff(self.walls), 99)) - 0.02)
        facts = {
            "lateness_ms": 1e3 * late,
            "late_parts": times.late_parts,
            "skipped_s": times.skipped,
            "real_per_sim": (self.walls[-1] - self.walls[0]) / (0.02 * (len(self.walls) - 1)),
        }
        print(json.dumps({**self.course.results, **facts}), flush=True)
        os._exit(0)


def main() -> None:
    play = Play(is_field_centric=sys.argv[1] == "field")
    unmanaged.set_phoenix_diagnostics_start_time(-1)
    RobotPhysics.after_tick = lambda physics: play(physics)
    sys.argv = ["robotpy", "sim", "--nogui", "--simcore", "--game", "rebuilt"]
    robotpy_main()


if __name__ == "__main__":
    main()
