"""Robots whose loop is not wpilib's, none of which knows simcore: in the fixture `sim`, two processes, one digest."""

from __future__ import annotations

from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROBOTS = Path(__file__).parent / "robots"
DRIVES = """
import os

def test_it_drives(sim):
    stick = sim.joystick(0)
    sim.teleop()
    stick.axis(1, -0.8)
    begin = sim.pose.X()
    sim.run(1.5)
    assert 1.0 < sim.pose.X() - begin < 3.0
    assert sim.physics.times.ticks == 101  # of 20 ms: the first, half a second disabled, and 1.5
    assert sim.own_threads == []
    with open(os.environ["DIGESTS"], "a") as file:
        file.write(sim.digest + "\\n")
"""


@pytest.mark.parametrize(
    ("robot", "loop"), [("magic", ""), ("ownloop", ""), ("sleeping", "sleep"), ("sleeping", "event")]
)
def test_a_loop_of_its_own_gets_physics_and_repeats(project_of, tmp_path, robot, loop, whole):
    """Under plain pytest and under `robotpy test`: 2.4 m/s from a stick at 0.8."""
    if loop == "sleep" and not whole:
        pytest.skip("with --whole; waiting for an event is the sample")
    if robot == "magic":
        pytest.importorskip("magicbot", reason="needs magicbot: pip install robotpy-wpilib-utilities")
    digests = tmp_path / "digests"
    run = project_of(ROBOTS / robot)
    for command in (("-m", "pytest", "-q"), ("-m", "robotpy", "test")):
        code, said = run(DRIVES, command=command, DIGESTS=str(digests), LOOP=loop)
        assert code == 0, said
    first, second = digests.read_text().split()
    assert first == second


def test_a_loop_that_never_waits_fails_by_name_and_says_where(project_of):
    run = project_of(ROBOTS / "sleeping")
    code, said = run("def test_it(sim):\n    sim.teleop(seconds=1.0)\n", "-o", "simcore_hang=6", LOOP="spin")
    assert code == 1, said
    assert "Robot gets no physics: its loop is its own" in said and "in startCompetition" in said, said


def test_a_robot_without_a_drivetrain_fails_with_that_alone(project_of):
    pytest.importorskip("magicbot", reason="needs magicbot: pip install robotpy-wpilib-utilities")
    pytest.importorskip("pyfrc", reason="MagicBot of 2027 ends with an error of its own, which hides this one")
    run = project_of(ROBOTS / "magic")
    (run.folder / "robot.py").write_text(
        "import magicbot\n\nclass Robot(magicbot.MagicRobot):\n    def createObjects(self) -> None:\n        pass\n"
    )
    code, said = run("def test_it(sim):\n    sim.teleop(seconds=1.0)\n")
    assert code == 1 and "no drivetrain found" in said and "no physics" not in said, said


def test_a_team_s_own_physics_runs_beside(project_of):
    run = project_of(ROBOTS / "sleeping")
    code, said = run(
        """
def test_it(sim):
    sim.teleop(seconds=1.0)
    assert 70 <= sim.robot.their_physics.calls <= sim.physics.times.ticks
"""
    )
    assert code == 0, said
