"""One way to attach: programs whose loop calls simulation hooks need no extra code, and a bare loop is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

MAGIC = Path(__file__).parent / "robots" / "magic"
LOGGED = """
import measures
from logged_robot import LoggedRobot

class Robot(LoggedRobot):
    def robotInit(self):
        self.drivetrain = measures.build(coupling=3.57)

    def teleopPeriodic(self):
        self.drivetrain.set_control(measures.driver_request())
"""
"""Robot like PyKit's base class: an IterativeRobotBase with a notifier loop of its own."""
BARE = """
import hal
import measures
import wpilib
from robotpy_ext.misc.precise_delay import NotifierDelay

class Robot(wpilib.RobotBase):
    def __init__(self):
        super().__init__()
        self.is_over = False
        self.drivetrain = measures.build(coupling=3.57)
{hooks}
    def startCompetition(self):
        {begin}
        hal.observeUserProgramStarting()
        with NotifierDelay(0.02) as delay:
            while not self.is_over:
                wpilib.DriverStation.refreshData()
                if self.isTeleopEnabled():
                    self.drivetrain.set_control(measures.driver_request())
                {loop}
                delay.wait()

    def endCompetition(self):
        self.is_over = True
"""
HOOKS = """
    def _simulationInit(self):
        pass

    def _simulationPeriodic(self):
        pass
"""
DRIVES = """
def test_it_drives(sim):
    stick = sim.joystick(0)
    sim.teleop()
    stick.axis(1, -0.8)
    begin = sim.pose.X()
    sim.run(1.5)
    assert 1.0 < sim.pose.X() - begin < 3.0
    assert sim.physics.times.ticks in (100, 101)  # ticks of 20 ms: half a second disabled, then 1.5 s
    sim.autonomous(seconds=0.1)
    sim.teleop(seconds=0.1)
    assert sim.own_threads == []
    print("DIGEST", sim.digest)

def test_again(sim):
    test_it_drives(sim)
"""


@pytest.mark.parametrize("robot", ["magic", "logged", "bare loop with the hooks"])
def test_a_custom_loop_with_hooks_runs_physics_and_repeats_exactly(project_of, robot):
    if robot != "logged":
        pytest.importorskip("magicbot", reason="needs magicbot: pip install robotpy-wpilib-utilities")
    cured = BARE.format(hooks=HOOKS, begin="self._simulationInit()", loop="self._simulationPeriodic()")
    code, said = project_of({"magic": MAGIC, "logged": LOGGED}.get(robot, cured))(DRIVES, "-rP")
    assert code == 0, said
    first, second = (line for line in said.splitlines() if line.startswith("DIGEST"))
    assert first == second


@pytest.mark.parametrize("command", ["test", "sim"])
def test_a_loop_without_hooks_raises_an_error_of_one_sentence(project_of, command):
    pytest.importorskip("robotpy_ext", reason="needs robotpy_ext: pip install robotpy-wpilib-utilities")
    run = project_of(BARE.format(hooks="", begin="", loop=""))
    words = ("-m", "robotpy", *(("test",) if command == "test" else ("sim", "--simcore", "--nogui")))
    code, said = run("def test_it(sim):\n    sim.start()\n", command=words)
    (sentence,) = {line[line.index("Robot has") :] for line in said.splitlines() if "nothing calls physics" in line}
    assert code == 1 and "Traceback" not in said, said
    assert sentence.startswith("Robot has a loop without simulation hooks, so nothing calls physics: derive it from ")
    assert "_simulationInit and _simulationPeriodic (they may be empty)" in sentence


def test_hooks_that_are_never_called_are_reported(project_of):
    pytest.importorskip("robotpy_ext", reason="needs robotpy_ext: pip install robotpy-wpilib-utilities")
    run = project_of(BARE)
    for begin, words in (
        ("self.init = 1", "robot program has not finished robotInit in 9 s: the program is at robot.py:"),
        ("self._simulationInit()", "the loop of Robot never calls _simulationPeriodic; it is at "),
    ):
        (run.folder / "robot.py").write_text(BARE.format(hooks=HOOKS, begin=begin, loop=""))
        code, said = run("def test_it(sim):\n    sim.start()\n")
        assert code == 1 and words in said, said


def test_the_only_error_of_a_robot_without_a_drivetrain_is_the_missing_drivetrain(project_of):
    pytest.importorskip("magicbot", reason="needs magicbot: pip install robotpy-wpilib-utilities")
    pytest.importorskip("pyfrc", reason="MagicBot of 2027 ends with an error of its own, which hides this one")
    run = project_of(
        "import magicbot\n\nclass Robot(magicbot.MagicRobot):\n    def createObjects(self) -> None:\n        pass\n"
    )
    code, said = run("def test_it(sim):\n    sim.teleop(seconds=1.0)\n")
    assert code == 1 and "no drivetrain found" in said and "no physics" not in said, said


PHYSICS = """
class PhysicsEngine:
    def __init__(self, physics_controller, robot):
        self.controller, self.robot, robot.calls = physics_controller, robot, 0

    def update_sim(self, now, tm_diff):
        self.robot.calls += 1
        assert self.controller.get_pose() is not None and 0.010 < tm_diff < 0.1
"""


def test_a_teams_own_physics_engine_runs_next_to_simcore_with_pyfrcs_controller(project_of):
    """Without the fixture `sim`, the program runs without simcore."""
    pytest.importorskip("pyfrc", reason="2027 has no physics controller")
    run = project_of({"robot.py": LOGGED, "physics.py": PHYSICS})
    code, said = run(
        """
def test_field(sim):
    sim.teleop(seconds=1.0)
    assert 70 <= sim.robot.calls <= sim.physics.times.ticks

def test_alone(control, robot):
    with control.run_robot():
        control.step_timing(seconds=0.5, autonomous=False, enabled=True)
        assert robot.calls > 10
    from simcore.robotcode.sim.robot_physics import latest_physics
    assert latest_physics() is None
"""
    )
    assert code == 0 and "2 passed" in said, said
