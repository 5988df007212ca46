"""A test that fails under `robotpy test` leaves its run, with what a running game has there."""

from __future__ import annotations

import math
import os
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
from page_reader import PageReader

import simcore

pytestmark = [pytest.mark.slow, pytest.mark.realtime]

PACKAGES = Path(simcore.__file__).resolve().parents[1]
PLAIN = Path(__file__).parent / "robots" / "plain"

TEST = """
from simcore.robotpy.robot_physics import RobotPhysics
from simcore.show.failed_run import save_failed_run
from simcore.show.scene import scene_of
from simcore.telemetry.recording import Recording


def test_drives_ten_meters(control, robot, monkeypatch):
    recording, engines = Recording(), []
    start = RobotPhysics.__init__

    def with_recording(self, *args, **options):
        start(self, *args, **options)
        self.match.sinks.append(recording)
        engines.append(self)

    monkeypatch.setattr(RobotPhysics, "__init__", with_recording)
    with control.run_robot():
        control.step_timing(seconds=1.5, autonomous=False, enabled=True)
    left = save_failed_run(
        recording, "evidence", name="test_drives[ten]", scene=scene_of(engines[0].match), note="driven >= 10"
    )
    print("LEFT", left, left.problems)
    assert recording.poses("Sim/Robot/Pose3d")[1][-1, 1] > 10.0, "no robot does that in 1.5 s"
"""


def test_what_is_left_of_a_failed_robotpy_test(tmp_path):
    for module in ("phoenix6", "pyfrc", "robotpy_cli" if find_spec("robotpy_cli") else "robotpy"):
        if find_spec(module) is None:
            pytest.skip(f"needs {module}: pip install .[phoenix6,robotpy]")
    project = tmp_path / "project"
    shutil.copytree(PLAIN, project)
    (project / "tests").mkdir()
    (project / "tests" / "drive_test.py").write_text(TEST)
    run = subprocess.run(
        [sys.executable, "-m", "robotpy", "test", "--", "-s"],
        cwd=project,
        env={**os.environ, "PYTHONPATH": str(PACKAGES)},
        capture_output=True,
        text=True,
        timeout=90,
    )
    said = run.stdout + run.stderr
    assert run.returncode != 0 and "no robot does that" in said, said[-3000:]
    files = {path.suffix: path for path in project.rglob("test_drives_ten.*")}
    assert set(files) == {".html", ".png", ".wpilog"}, said[-3000:]
    page = PageReader(files[".html"])
    assert "driven >= 10" in page.words and "Tick time" in page.words, "the wall time of ticks is known there too"
    times, _ = page.group("robots")
    (x, y, *_), (to_x, to_y, *_) = (100.0 * page.robot(0, time)[0] for time in times[[0, -1]])
    assert math.hypot(to_x - x, to_y - y) > 50.0, "half a meter [cm]"
    (at_x, at_y, *_), (believed_x, believed_y, _) = (100.0 * place for place in page.robot(0, times[0]))
    assert (at_x, at_y) != (believed_x, believed_y), (
        "CTRE's drivetrain begins at the corner of the field, the robot not"
    )
    assert "Pose estimate off by" in page.words and "transition" in page.words
