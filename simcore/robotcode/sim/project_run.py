"""One run of a robot project in a sweep, as a robot test in the current process.

The test uses `pytest_plugin` to build the robot, place the robot on the field and play the auto.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import pytest

from simcore import season
from simcore.errors import SimcoreError, start_sentence
from simcore.match.runner import auto_seconds
from simcore.robotcode.sim.pytest_plugin import INIT_TIMEOUT
from simcore.robotcode.sim.robot_program import load_robot_class
from simcore.robotcode.sim.robot_test import RobotTest
from simcore.sweep.run_metrics import measure
from simcore.telemetry.wpilog import WpilogSink
from simcore.units import TICK

__all__ = ["ProjectRun", "play_auto", "play_project", "test_auto"]


class ProjectRun:
    """Pytest plugin that plays one run of a sweep and stores the result.

    Args:
        task: Description of the run (`simcore.sweep.one_run`).
    """

    def __init__(self, task: dict[str, Any]) -> None:
        self._task = task
        self._folder = Path(task["project"])
        self.answer: dict[str, Any] = {"error": "the robot test of the run has not begun"}
        """Metrics and digest of the run. After an error, only the error message under the key `error`."""

    @pytest.fixture
    def project_run(self) -> ProjectRun:
        """Provide this plugin as a fixture for `test_auto`."""
        return self

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Store the last line of the error as the answer if the setup of the test fails."""
        if report.failed and report.when == "setup":
            lines = [line for line in report.longreprtext.splitlines() if line.strip()]
            self.answer = {"error": lines[-1].removeprefix("E").strip() if lines else "the robot could not be built"}

    def play(self, sim: RobotTest) -> None:
        """Play the auto, and store the metrics and digest or the error message as the answer."""
        try:
            self.answer = play_auto(sim, self._task)
        except (Exception, pytest.fail.Exception) as error:  # pytest.fail reports errors in the project
            self.answer = {"error": _sentence(error, self._folder)}


def play_auto(sim: RobotTest, task: dict[str, Any]) -> dict[str, Any]:
    """Play the auto of a task in a robot test, write the log if the task names one, and return metrics and digest."""
    sim.alliance(task["alliance"])
    if task["log"] is not None:
        sim.add_sink(WpilogSink(task["log"]))
    sim.start()
    seconds = task["seconds"] or auto_seconds(sim.match.game)
    sim.autonomous(task["auto"], seconds=0.0)
    sim.run(max(1, round(seconds / TICK)) * TICK)
    metrics = measure(sim.match, task["metrics"])
    return {**metrics, "digest": sim.digest}


def test_auto(sim: RobotTest, project_run: ProjectRun) -> None:
    """Play the auto of the run. Pytest collects this function as the only test."""
    project_run.play(sim)


def play_project(task: dict[str, Any]) -> dict[str, Any]:
    """Play a run in this process, and return the run's metrics and digest.

    The process cannot play another run after this call.

    Args:
        task: Description of the run (`simcore.sweep.one_run`).

    Raises:
        SimcoreError: The robot code failed; the message states the error.
    """
    run = ProjectRun(task)
    folder = Path(task["project"])
    os.chdir(folder)
    sys.path.insert(0, str(folder))
    del sys.argv[1:]
    try:
        _play(task, run, folder)
    except Exception as error:
        raise SimcoreError(_sentence(error, folder)) from error
    if "error" in run.answer:
        raise SimcoreError(run.answer["error"])
    return run.answer


def _sentence(error: BaseException, folder: Path) -> str:
    text = str(error) if isinstance(error, pytest.fail.Exception) else start_sentence(error, folder)
    return " ".join(text.split())


def _play(task: dict[str, Any], run: ProjectRun, folder: Path) -> None:
    from simcore.robotcode.sim.attach import watch_program
    from simcore.robotcode.sim.attached_physics import AttachedPhysics
    from simcore.robotcode.sim.repeatable_runs import seed_generators
    from simcore.robotcode.sim.run_variation import set_factors

    AttachedPhysics.game_name, AttachedPhysics.engine_name = task["game"], task["engine"]
    set_factors(task["values"])
    seed_generators()  # a program may use random numbers while it is imported
    watch_program(simulated=True)
    robot_file = folder / "robot.py"
    robot = season.robot_test_plugin(load_robot_class(robot_file), robot_file, INIT_TIMEOUT)
    spreads = [] if task["scatter"] is None else [f"--sim-scatter={task['scatter']}"]
    own_settings = ["--noconftest", f"--rootdir={folder}", "-c", os.devnull]  # ignore the project's test settings
    without = [f"-pno:{name}" for name in ("cacheprovider", "cov", "terminal", "xdist")]
    varied = [f"--sim-seed={task['seed']}", *spreads]
    pytest.main([__file__, *own_settings, *without, *varied], plugins=[robot, run])
