"""Function that plays one run of a sweep with a robot program in another process, over the bridge."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

from simcore import season
from simcore.bridge.robot_process import RobotProcess
from simcore.bridge.served_robot import ServedRobot
from simcore.match.scatter import Scatter
from simcore.robot_file.template import FILE_NAME
from simcore.robotcode.sim.project_run import play_auto
from simcore.robotcode.sim.run_variation import run_variation, set_factors, set_run_variation

__all__ = ["play_project"]


def play_project(task: dict[str, Any]) -> dict[str, Any]:
    """Play one run, and return the metrics and the digest of the run by column.

    The process cannot play a second run.

    Args:
        task: Description of the run from `simcore.sweep.one_run`, with the command that starts the program.

    Raises:
        SimcoreError: If the program has failed; the message gives the reason.
    """
    folder = Path(task["project"])
    os.chdir(folder)
    scatter = None if task["scatter"] is None else Scatter.parse(task["scatter"])
    set_factors(task["values"])
    set_run_variation(replace(run_variation(), seed=task["seed"], scatter=scatter))
    season.ntcore.NetworkTableInstance.get_default().start_local()
    process = RobotProcess(task["command"], patience=120.0, hang=20.0, shows=0)
    with process, ServedRobot(process, folder / FILE_NAME, game=task["game"], engine=task["engine"]) as robot:
        return play_auto(robot, task)
