"""Programs with rare habits drive with true odometry, or end with a sentence that names the program's line."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.adapters.conftest import PACKAGES, ROBOTPY_TEST

pytest.importorskip("pyfrc", reason="robot programs need pyfrc: pip install -e .[robotpy]")

pytestmark = pytest.mark.slow

TANK = """
import threading
import hal
import wpilib
from wpilib.drive import DifferentialDrive
from wpimath.geometry import Pose2d, Rotation2d
from wpimath.kinematics import DifferentialDriveOdometry


class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.left, self.right = wpilib.PWMVictorSPX(0), wpilib.PWMVictorSPX(1)
        self.right.setInverted(True)
        self.left_encoder, self.right_encoder = wpilib.Encoder(0, 1), wpilib.Encoder(2, 3)
        self.drive = DifferentialDrive(self.left, self.right)
        self.gyro, self.pad = wpilib.ADXRS450_Gyro(), wpilib.XboxController(0)
        self.odometry = DifferentialDriveOdometry(Rotation2d(), 0, 0)
        self.heard, self.forward = [], 0.0
        {init}

    def update(self, left=4278.0, right=4278.0, sign=-1):
        turned = Rotation2d.fromDegrees(sign * self.gyro.getAngle())
        self.odometry.update(turned, self.left_encoder.get() / left, self.right_encoder.get() / right)

    def hear(self):
        self.heard.append(self.left_encoder.get())

    def robotPeriodic(self):
        {loop}

    def teleopPeriodic(self):
        {teleop}
        self.forward = -self.pad.getLeftY()
        self.drive.arcadeDrive(self.forward, -self.pad.getRightX(), False)
{more}
"""
HOLDS = """
def test_it(sim):
    pad, robot = sim.xbox(0), None
    sim.teleop(seconds=0.3)
    robot = sim.robot_sim
    true, told = robot.chassis.pose, robot.estimated_pose
    pad.left_y, pad.right_x = -0.5, {turn}
    sim.run(1.5)
    pad.center()
    sim.run(0.6)
    way, believed = robot.chassis.pose[0] - true[0], robot.estimated_pose[0] - told[0]
    turned, turning = robot.chassis.pose[2] - true[2], robot.estimated_pose[2] - told[2]
    assert way > 0.7 and abs(believed - way) < 0.06 * way and abs(turned - turning) < 0.06, (way, believed)
    assert not [text for text in sim.warnings if "odometry is off" in text]
"""
HELD = "def test_it(sim):\n    sim.teleop(seconds=0.1)\n    assert held\n"
DRIVES = "def test_it(sim):\n    sim.xbox(0).left_y = -0.5\n    sim.teleop(seconds=1.0)\n"
REAL_ONLY = {
    "loop": "if wpilib.RobotBase.isReal(): self.update()",
    "more": "    def simulationPeriodic(self):\n"
    "        self.odometry.resetPosition(Rotation2d(), 0, 0, self.odometry.getPose())\n",
}
THREAD = "threading.Thread(target=lambda: None, name='short').start() if not self.forward else None"
FINDS = """
def test_it(sim):
    sim.teleop(seconds=0.1)
    assert sim.robot.loops == [1], sim.robot.loops
    assert sim.own_threads == []
"""
FINDER = """
    def teleopInit(self):
        from pathplannerlib.pathfinders import LocalADStar
        from wpimath.geometry import Translation2d
        self.finder, self.loops, self.loop = LocalADStar(), [], 0
        self.finder.setStartPosition(Translation2d(2, 2))
        self.finder.setGoalPosition(Translation2d(12, 6))

    def find(self):
        from pathplannerlib.path import GoalEndState, PathConstraints
        self.loop += 1
        if self.finder.isNewPathAvailable() and self.finder.getCurrentPath(
                PathConstraints(3, 3, 6, 6), GoalEndState(0, 0)):
            self.loops.append(self.loop)
"""
HEARS = """
def test_it(sim):
    sim.xbox(0).left_y = -0.6
    sim.teleop(seconds=1.5)
    heard = sim.robot.heard[-240:]
    assert sum(a == b for a, b in zip(heard, heard[1:])) < 12, heard
"""

PROGRAMS: dict[str, tuple[dict[str, str], str, str, str]] = {
    # name: parts of the program, simcore.toml, test, words of a failed test (empty if it passes)
    "counts without a scale, another one each side": (
        {"loop": "self.update(4278.0, 1000.0)"}, "", HOLDS.format(turn=-0.1), ""),
    "gyro upside down": (
        {"loop": "self.update(sign=1)"}, "[drivetrain]\ngyro_upside_down = true\n", HOLDS.format(turn=-0.1), ""),
    "yaw counts the other way": (
        {"loop": "self.update(sign=1)"}, "[drivetrain]\ngyro_reversed = true\n", HOLDS.format(turn=-0.1), ""),
    "odometry on the robot alone": (REAL_ONLY, "", DRIVES.replace("1.0)", "2.0)\n    assert not sim.warnings"),
                                    "asks isReal or isSimulation (robot.py:"),
    "odometry on the robot alone, told so": (REAL_ONLY, "[robot]\nreal = true\n", HOLDS.format(turn=0.0), ""),
    "waits in a loop": (
        {"teleop": "while self.left_encoder.get() < 50: pass"}, "", DRIVES, "the program is at robot.py:32 in"),
    "a notifier on which no thread waits": (
        {"init": "self.raw = hal.initializeNotifier()"}, "", DRIVES, "initializeNotifier at robot.py:19 in robotInit"),
    "a serial number decides": (
        {"init": "assert wpilib.RobotController.getSerialNumber() == '03248A12'"},
        '[robot]\nserial_number = "03248A12"\n', DRIVES, ""),
    "a serial number that nobody says": (
        {"init": "assert wpilib.RobotController.getSerialNumber() == '03248A12'"}, "", DRIVES,
        "robot.py:19: the program asks for the serial number"),
    "a fast addPeriodic": ({"init": "self.addPeriodic(self.hear, 0.004)"}, "", HEARS, ""),
    "a fast Notifier": (
        {"init": "self.fast = wpilib.Notifier(self.hear); self.fast.startPeriodic(0.004)"}, "", HEARS, ""),
    "threads that end at once": (
        {"teleop": THREAD}, "", HELD.replace("held", "sim.own_threads == ['short']"), ""),
    "a planner's thread": ({"teleop": "self.find()", "more": FINDER}, "", FINDS, ""),
}  # fmt: skip

BENCH = """
import wpilib


class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.wheel, self.encoder = wpilib.PWMSparkMax(0), wpilib.Encoder(0, 1)

    def teleopPeriodic(self):
        self.wheel.set(0.5)
"""
TURNS = """
def test_it(sim):
    sim.teleop(seconds=1.0)
    assert max(abs(m.velocity) for m in sim.robot_sim.mechanisms.values()) > 10.0
    assert abs(sim.pose.X() - 2.0) < 1e-3
"""

TALON = """
import wpilib
from phoenix6 import hardware


class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.wheel, self.pigeon, self.rows = hardware.TalonFX(0), hardware.Pigeon2(1), []

    def teleopPeriodic(self):
        self.wheel.set(0.5)
        self.pigeon.get_acceleration_x().value
        self.rows.append((wpilib.Timer.getFPGATimestamp(), self.wheel.get_velocity().value,
                          self.wheel.get_acceleration().value))
"""
SLOPE = """
def test_it(sim):
    sim.teleop(seconds=0.3)
    times, speeds, slopes = zip(*sim.robot.rows[3:11])
    slope = (speeds[-1] - speeds[0]) / (times[-1] - times[0])
    assert slope > 20.0 and abs(sum(slopes) / len(slopes) - slope) < 0.25 * slope, (slope, slopes)
    assert sum("acceleration x is not modelled" in text for text in sim.warnings) == 1
"""

REFUSED = {
    'sim.autonomous("shoot preloads")': "the robot shows no SendableChooser",
    "sim.place(20, 3, 0)": "outside of the field",
    "sim.place(3, 3, 90)": "As degrees that is 1.57 rad",
    "sim.xbox(7)": "port must be 0..5",
    "sim.xbox(0).leftY = 1": "Did you mean 'left_y'?",
    "sim.xbox(0).left_y = -100": "left_y must be a number from -1 to 1",
    'sim.match.pieces.spawn("Fuel", [[3, 3, 1]] * 600)': "600 more wanted, but 504 of 504 are in play",
    "sim.scored > 3": "Did you mean 'sim.pieces.scored'?",
}


WHEEL = '[[mechanism]]\nname = "wheel"\nkind = "flywheel"\ncontroller = "PWM"\nleader = 0\ninertia = 0.002\n'


def _run(folder: Path, robot: str, toml: str, test: str) -> tuple[int, str]:
    (folder / "robot.py").write_text(robot)
    (folder / "simcore.toml").write_text('game = "none"\n' * ("Fuel" not in test) + toml)
    (folder / "tests").mkdir()
    (folder / "tests" / "test_it.py").write_text(test)
    done = subprocess.run(
        [sys.executable, *ROBOTPY_TEST, "-p", "no:cacheprovider"], cwd=folder, capture_output=True, text=True,
        env={**os.environ, "PYTHONPATH": str(PACKAGES)}, timeout=300, check=False,
    )  # fmt: skip
    return done.returncode, done.stdout + done.stderr


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_program_with_a_rare_habit_drives_with_true_odometry_or_reports_why(name, tmp_path):
    parts, toml, test, words = PROGRAMS[name]
    if "planner" in name and find_spec("pathplannerlib") is None:
        pytest.skip("needs pathplannerlib")
    robot = TANK.format(**{"init": "pass", "loop": "self.update()", "teleop": "pass", "more": "", **parts})
    code, said = _run(tmp_path, robot, toml, test)
    assert (code != 0) == bool(words) and words in said, said[-3000:]


def test_a_bench_without_a_drivetrain_turns_its_motor(tmp_path):
    code, said = _run(tmp_path, BENCH, WHEEL, TURNS)
    assert code == 0, said[-3000:]


@pytest.mark.skipif(find_spec("phoenix6") is None, reason="needs phoenix6")
def test_a_talon_measures_acceleration_and_a_pigeon_names_unmodelled_signals(tmp_path):
    toml = WHEEL.replace("PWM", "TalonFX").replace("0.002", "0.01")
    code, said = _run(tmp_path, TALON, toml, SLOPE)
    assert code == 0, said[-3000:]


def test_the_traceback_of_a_refused_call_ends_at_the_line_of_the_test(tmp_path):
    tests = "".join(f"def test_{k}(sim):\n    sim.start()\n    {call}\n" for k, call in enumerate(REFUSED))
    code, said = _run(tmp_path, TANK.format(init="pass", loop="self.update()", teleop="pass", more=""), "", tests)
    assert code == 1
    for call, words in REFUSED.items():
        assert f">       {call}\n" in said and words in said, (call, said[-3000:])
    shown = [line for line in said.splitlines() if line.startswith(str(PACKAGES / "simcore"))]
    assert not shown, shown
