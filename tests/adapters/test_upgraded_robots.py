"""Robots of 2026 that `simcore upgrade-2027` has rewritten drive on the libraries of 2027, with no line by hand."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent / "robots" / "upgraded"
TEST = """
import math


def test_it_drives_3_m_and_a_curve_and_knows_it(sim):
    robot, pad = sim.robot_sim, sim.joystick(0)

    def drive(seconds, ahead, turn, until=lambda: False):
        for _ in range(round(seconds / 0.02)):
            pad.axis(1, -ahead)
            pad.axis(4, -turn)
            sim.run(0.02)
            if until():
                return

    def way(start, end):
        return math.dist(start[:2], end[:2])

    sim.place(2.8, 1.2, 0.5 * math.pi)
    sim.teleop()
    drive(0.5, 0.0, 0.0)
    true, told = robot.chassis.pose, robot.estimated_pose
    drive(6.0, 0.5, 0.0, until=lambda: way(true, robot.chassis.pose) > 3.0)
    drive(0.8, 0.0, 0.0)
    ahead = way(true, robot.chassis.pose)
    assert ahead > 3.0 and abs(way(told, robot.estimated_pose) - ahead) < 0.05 * ahead
    true, told = robot.chassis.pose, robot.estimated_pose
    drive(1.2, 0.4, 0.4)
    drive(0.8, 0.0, 0.0)
    turned, believed = (math.remainder(b[2] - a[2], math.tau) for a, b in (
        (true, robot.chassis.pose), (told, robot.estimated_pose)))
    assert abs(turned) > 0.4 and abs(believed - turned) < 0.1, (turned, believed)
    assert abs(way(told, robot.estimated_pose) - way(true, robot.chassis.pose)) < 0.15
    assert not [text for text in sim.warnings if "does not hold" in text]
"""


@pytest.mark.skipif(not FOLDER.is_dir(), reason="scripts/season_2027.sh writes what is upgraded")
@pytest.mark.parametrize("name", sorted(p.name for p in FOLDER.glob("*")))
def test_it_starts_in_simulation_and_drives_where_the_sticks_say(name, project_of):
    run = project_of(FOLDER / name)
    code, said = run(TEST)
    assert code == 0, said
    with pytest.raises(subprocess.TimeoutExpired) as still_there:
        subprocess.run(
            [sys.executable, "-m", "robotpy", "sim", "--nogui", "--simcore"],
            cwd=run.folder, capture_output=True, timeout=25.0, check=False,
        )  # fmt: skip
    assert b"drivetrain" in still_there.value.stderr and b"Traceback" not in still_there.value.stderr
