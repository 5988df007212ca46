"""Each robot test in a process of its own, under plain pytest: HAL, NetworkTables and devices are then always fresh.

The parent hands the child one test; the child runs it with pytest and writes its reports to a file, a JSON object a
line. `robotpy test` has its own isolation; this one is for `pytest`, with or without xdist.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import pytest

from simcore import season
from simcore.errors import start_sentence
from simcore.sweep.child_process import run_process

__all__ = ["INIT_TIMEOUT", "ChildTask", "end_process", "load_robot_plugin", "play_test", "run_isolated", "wait_longer"]

INIT_TIMEOUT = 30.0
"""In which a robot program must come through robotInit [s]."""
_TAIL = 4000  # characters of a dead child's words, at the start and at the end


@dataclass(frozen=True, slots=True, kw_only=True)
class ChildTask:
    """What a child process shall run."""

    robot_file: str
    test: str
    """Path and test, as pytest wants it."""
    nodeid: str
    arguments: Sequence[str]
    """For pytest."""
    reports: str
    """File for the reports."""


def run_isolated(
    item: pytest.Item, robot_file: Path, arguments: Sequence[str], *, timeout: float, folder: Path | None
) -> list[pytest.TestReport]:
    """Run a test in a new process.

    Args:
        item: The test.
        robot_file: The project's robot.py.
        arguments: Pytest's, for the child.
        timeout: Wall time after which the child is ended [s].
        folder: Where it runs; None: in a folder of its own, which is then deleted.

    Returns:
        The reports of its phases; if the process died, a failed one that says how.
    """
    work = Path(tempfile.mkdtemp(prefix="simcore-test-"))
    try:
        task = ChildTask(
            robot_file=str(robot_file),
            test="::".join((str(item.path), *item.nodeid.split("::")[1:])),
            nodeid=item.nodeid,
            arguments=[*arguments, f"--basetemp={work / 'tmp'}"],
            reports=str(work / "reports"),
        )
        out = work / "out"
        where = work if folder is None else folder
        code = run_process("simcore.robotpy.isolation:play_test", task, said=out, timeout=timeout, folder=where)
        reports = _read(item, Path(task.reports))
        if {"call", "teardown"} <= {r.when for r in reports} or any(r.failed or r.skipped for r in reports):
            return reports
        said = out.read_text("utf-8", "replace")
        if len(said) > 2 * _TAIL:
            said = f"{said[:_TAIL]}\n[...]\n{said[-_TAIL:]}"
        how = f"was ended after {timeout:g} s of wall time (simcore_timeout)" if code is None else f"died (exit {code})"
        return [*reports, _failed(item, f"the process of this robot test {how}. Its last words:\n\n{said}")]
    finally:
        shutil.rmtree(work, ignore_errors=True)


def _read(item: pytest.Item, path: Path) -> list[pytest.TestReport]:
    if not path.exists():
        return []
    lines = path.read_text("utf-8").splitlines()
    hook = item.config.hook
    reports = [hook.pytest_report_from_serializable(config=item.config, data=json.loads(line)) for line in lines]
    for report in reports:
        if isinstance(report.longrepr, list):  # of a skipped test; JSON knows no tuples
            report.longrepr = tuple(report.longrepr)
    return reports


def _failed(item: pytest.Item, text: str) -> pytest.TestReport:
    return pytest.TestReport(
        nodeid=item.nodeid, location=item.location, keywords={}, outcome="failed", longrepr=text, when="call"
    )


# --- in the child -------------------------------------------------------------------------------------------------


class _Reporter:
    """Writes the reports, under the parent's name of the test."""

    def __init__(self, task: ChildTask) -> None:
        self._task = task
        self._config: Any = None

    def pytest_configure(self, config: pytest.Config) -> None:
        self._config = config

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        data = self._config.hook.pytest_report_to_serializable(config=self._config, report=report)
        self.write({**data, "nodeid": self._task.nodeid})

    def write(self, data: dict[str, Any]) -> None:
        with open(self._task.reports, "a", encoding="utf-8") as stream:
            stream.write(json.dumps(data, default=str) + "\n")


def load_robot_plugin(robot_file: Path, *, simulated: bool = True) -> Any:
    """RobotPy's plugin of pytest for the robot program of a project. Errors of the robot code pass through.

    Args:
        robot_file: Its robot.py.
        simulated: Whether Phoenix 6 runs in simulated time.
    """
    from simcore.robotpy.program_watch import watch_program
    from simcore.robotpy.repeatable_runs import seed_generators
    from simcore.robotpy.robot_program import load_robot_class

    seed_generators()  # a program may draw while it is imported
    watch_program(simulated=simulated)
    return season.robot_test_plugin(load_robot_class(robot_file), robot_file, INIT_TIMEOUT)


def wait_longer(plugin: Any) -> None:
    """Let a plugin of RobotPy's wait `INIT_TIMEOUT` for the start of a program: building a field takes 1 s of it.

    pyfrc's waits 2 s; that of wpilib.testing asks a thousand times, 1 ms apart.
    """
    if hasattr(plugin, "_init_timeout"):
        plugin._init_timeout = max(plugin._init_timeout, INIT_TIMEOUT)
        return
    has_started = season.wpilib_simulation.get_program_started

    def has_started_by_then() -> bool:
        if not has_started():
            time.sleep(1e-3 * INIT_TIMEOUT)
        return bool(has_started())

    season.test_controller().get_program_started = has_started_by_then


def end_process(code: int) -> NoReturn:
    """End a process in which a robot has run, at once: the interpreter's own end can hang on HAL threads."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def play_test(task: ChildTask) -> int:
    """Run a test in this process; returns the exit code, or ends the process with it."""
    reporter = _Reporter(task)
    try:
        robot = load_robot_plugin(Path(task.robot_file), simulated="--phoenix=simulated" in task.arguments)
    except BaseException as error:
        why = start_sentence(error, Path(task.robot_file).parent)
        print(f"could not load the robot project {task.robot_file}: {why}", flush=True)
        return 3
    end_process(int(pytest.main([task.test, *task.arguments], plugins=[robot, reporter])))
