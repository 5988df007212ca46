"""Code in the docs runs as printed: a Choreo trajectory, and partners and opponents in simcore.toml."""

from __future__ import annotations

import json
import math
import os
import re
from importlib.util import find_spec
from pathlib import Path
from textwrap import indent

import pytest

ROOT = Path(__file__).resolve().parents[2]
FIRST = ROOT / "examples" / "first_robot"

START, WAY, TURN, SECONDS = (2.5, 5.3, 0.0), 1.6, 1.0, 2.0

AUTONOMOUS = """
    def autonomousInit(self):
        self.auto = ChoreoAuto(self.drivetrain, "across")
        self.auto.start()

    def autonomousPeriodic(self):
        self.auto.run()
"""

TEST = f"""
import math
from wpimath.geometry import Pose2d


def test_the_true_pose_ends_where_the_trajectory_does(sim):
    sim.alliance("red")
    sim.autonomous(seconds={SECONDS + 0.5})
    start, end = (Pose2d(16.54 - x, 8.07 - y, math.pi + turn) for x, y, turn in (
        {START}, {(START[0] + WAY, START[1], TURN)}))
    assert sim.pose.translation().distance(end.translation()) < 0.1
    assert abs((sim.pose.rotation() - end.rotation()).radians()) < 0.05
    assert sim.pose.translation().distance(start.translation()) > 1.4
"""


def trajectory() -> dict:
    """Return a trajectory as Choreo writes it: forward while turning, with smooth speeds."""
    samples = []
    for k in range(41):
        t = SECONDS * k / 40
        share = (1.0 - math.cos(math.pi * t / SECONDS)) / 2.0
        rate = math.pi / (2.0 * SECONDS) * math.sin(math.pi * t / SECONDS)
        sample = {"t": t, "x": START[0] + WAY * share, "y": START[1], "heading": TURN * share}
        sample |= {"vx": WAY * rate, "vy": 0.0, "omega": TURN * rate, "ax": 0.0, "ay": 0.0, "alpha": 0.0}
        samples.append(sample | {"fx": [0.0] * 4, "fy": [0.0] * 4})
    return {"name": "across", "version": 3, "trajectory": {"samples": samples, "splits": []}, "events": []}


def block(page: str, beginning: str, language: str = "py") -> str:
    """Return the code block of a page that follows a line or begins with it."""
    text, fence = (ROOT / "docs" / page).read_text(encoding="utf-8"), f"```{language}\n"
    found = re.search(rf"^(?:{beginning}\n\n{fence}|{fence}(?={beginning}))(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    assert found, f"{page}: {beginning}"
    return found[1]


COMPANY = """
def test_a_partner_and_two_opponents_wait_for_the_driver_station_and_then_play(sim):
    sim.alliance("blue")
    sim.start()
    others = sim.match.robots[1:]
    before = [robot.chassis.pose for robot in others]
    sim.run(0.5)
    assert all(abs(robot.chassis.vel[0]) < 0.01 for robot in others)
    sim.autonomous(seconds=3)
    assert sim.match.alliances == ["blue", "blue", "red", "red"]
    ways = [math.dist(robot.chassis.pose[:2], pose[:2]) for robot, pose in zip(others, before)]
    assert ways[0] > 0.5 and ways[1] > 0.3 and ways[2] < 0.01, ways
"""


@pytest.mark.slow
def test_the_scripted_robots_of_the_docs_wait_and_then_play_next_to_robot_code(project_of):
    run = project_of(FIRST)
    (run.folder / "physics.py").unlink()  # simcore finds the drivetrain by itself
    (run.folder / "simcore.toml").write_text(block("whole_match.md", r"\[\[partner\]\]", "toml"))
    script = re.search(
        r"^def defend.*?(?=^\S)", (ROOT / "docs" / "whole_match.md").read_text(encoding="utf-8"), re.M | re.S
    )
    (run.folder / "defense.py").write_text(script[0])
    code, said = run("import math\n" + COMPANY)
    assert code == 0, said


@pytest.mark.slow
@pytest.mark.skipif(find_spec("choreo") is None, reason="needs Choreo: pip install sleipnirgroup-choreolib")
def test_a_robot_follows_a_choreo_trajectory_on_the_field(project_of):
    run = project_of(FIRST)
    (run.folder / "physics.py").unlink()  # simcore finds the drivetrain by itself
    (run.folder / "choreo_auto.py").write_text(block("autos.md", r"`choreo_auto\.py`:"))
    robot = (run.folder / "robot.py").read_text()
    (run.folder / "robot.py").write_text("from choreo_auto import ChoreoAuto\n" + robot.rstrip() + "\n" + AUTONOMOUS)
    (run.folder / "deploy" / "choreo").mkdir(parents=True)
    (run.folder / "deploy" / "choreo" / "across.traj").write_text(json.dumps(trajectory()))
    path = os.pathsep.join(p for p in (os.environ.get("PYTHONPATH", ""), str(ROOT)) if p)
    code, said = run(TEST, PYTHONPATH=os.pathsep.join((str(Path(find_spec("choreo").origin).parents[1]), path)))
    assert code == 0, said


def test_the_pathplanner_code_in_the_docs_appears_unchanged_in_the_example():
    assert indent(block("autos.md", r"AutoBuilder\.configure"), "    ") in (
        ROOT / "examples" / "rebuilt_robot" / "path_autos.py"
    ).read_text(encoding="utf-8")
