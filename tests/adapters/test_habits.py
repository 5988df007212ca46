"""Legitimate habits of robot programs, each with its own robot, checked by robot tests as teams write them."""

from __future__ import annotations

from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROBOTS = Path(__file__).parent / "robots"
HELPERS = """
import logging, math
import pytest

def apart(sim, believed=None):
    believed = believed or sim.robot.drivetrain.get_state().pose
    return believed.translation().distance(sim.pose.translation())

def warnings(caplog):
    return [r.getMessage() for r in caplog.records if r.levelno == logging.WARNING and "its auto begins" in r.message]
"""


HEADSET = """
import measures
import wpilib
from phoenix6.swerve import requests
from questnav import QuestNav
from wpimath.geometry import Pose2d, Pose3d, Rotation3d, Transform3d, Translation3d

ROBOT_TO_QUEST = Transform3d(Translation3d(0.15, 0.2, 0.5), Rotation3d.fromDegrees(0, 0, 90))


class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.drivetrain = measures.build()
        self.quest, self.believed = QuestNav(), Pose2d()
        {init}

    def tell(self, pose):
        self.quest.set_pose(Pose3d(pose).transformBy(ROBOT_TO_QUEST))

    def robotPeriodic(self):
        for frame in self.quest.unread_frames():
            self.believed = frame.pose.transformBy(ROBOT_TO_QUEST.inverse()).toPose2d()

    def autonomousInit(self):
        self.drivetrain.reset_pose(Pose2d(3.5, 5.0, 0.0))
        self.tell(Pose2d(3.5, 5.0, 0.0))

    def teleopPeriodic(self):
        self.drivetrain.set_control(requests.RobotCentric().with_velocity_x(1.0))
"""
"""Robot with a headset that faces left and is told its pose."""


def test_a_headset_reset_in_the_first_loop_of_an_auto_sets_the_start_pose(project_of):
    """After the headset is told its pose, simcore carries the robot there, as if it had started there."""
    code, said = project_of(HEADSET.format(init=""))(
        HELPERS
        + """
def test_it(sim):
    sim.start()
    assert sim.pose.X() < 3.0
    sim.autonomous(seconds=1.0)
    assert sim.pose.X() == pytest.approx(3.5, abs=0.02) and sim.pose.Y() == pytest.approx(5.0, abs=0.02)
    assert apart(sim, sim.robot.believed) < 0.02
    mount = sim.match.cameras.headsets[0].mount
    assert (mount.x, mount.y, mount.yaw_deg) == pytest.approx((0.15, 0.2, 90.0), abs=0.05)
    sim.disable(seconds=0.2)
    sim.place(5.5, 5.0, 1.0)  # carried elsewhere by people without a reset: a headset measures the displacement
    sim.run(0.2)
    assert apart(sim, sim.robot.believed) < 0.1
"""
    )
    assert code == 0, said


def test_a_headset_told_its_pose_before_the_first_tick_measures_from_that_pose(project_of):
    code, said = project_of(HEADSET.format(init="self.tell(Pose2d())"))(
        HELPERS
        + """
def test_it(sim):
    sim.start()
    first = sim.robot.believed
    assert abs(first.X()) < 0.02 and abs(first.Y()) < 0.02 and abs(first.rotation().degrees()) < 2.0
    begin = sim.pose
    sim.teleop(seconds=1.0)
    true, believed = sim.pose.relativeTo(begin), sim.robot.believed.relativeTo(first)
    assert true.X() > 0.7
    assert (believed.X(), believed.Y()) == pytest.approx((true.X(), true.Y()), abs=0.03)
"""
    )
    assert code == 0, said


SEEDING = """
import os

import measures
import wpilib
from phoenix6.swerve import requests
from wpimath.geometry import Pose2d

PLACES = {"left": (3.0, 6.0, 1.0), "right": (3.0, 2.0, 0.0), "in the hub": (4.6, 4.035, 0.0), "none": None}


class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.drivetrain = measures.build()
        if "AT_ONCE" in os.environ:
            self.drivetrain.reset_pose(Pose2d(3.0, 6.0, 1.0))
        self.chooser = wpilib.SendableChooser()
        self.chooser.setDefaultOption("none", "none")
        for name in PLACES:
            self.chooser.addOption(name, name)
        wpilib.SmartDashboard.putData("Auto", self.chooser)
        self.chosen = "none"

    def disabledPeriodic(self):
        name = self.chooser.getSelected()
        if name != self.chosen:
            self.chosen = name
            if PLACES[name] is not None:
                self.drivetrain.reset_pose(Pose2d(*PLACES[name]))

    def autonomousPeriodic(self):
        self.drivetrain.set_control(requests.RobotCentric().with_velocity_x(1.0))

    def disabledInit(self):
        self.drivetrain.set_control(requests.SwerveDriveBrake())
"""
"""Robot that sets its pose while disabled: in robotInit, on a chooser change, or never; its auto drives ahead."""


def test_a_pose_set_while_disabled_is_the_start_pose_of_the_auto(project_of):
    code, said = project_of(SEEDING)(
        HELPERS
        + """
def test_it(sim, caplog):
    caplog.set_level(logging.INFO, "simcore")
    for name, (x, y, yaw) in (("left", (3.0, 6.0, 1.0)), ("right", (3.0, 2.0, 0.0))):  # again: people carry it back
        sim.autonomous(name, seconds=0.04)
        assert (sim.pose.X(), sim.pose.Y()) == pytest.approx((x, y), abs=0.01)
        assert sim.pose.rotation().radians() == pytest.approx(yaw, abs=0.02)
        sim.run(0.6)
        assert apart(sim) < 0.05 and not warnings(caplog)
        sim.disable(seconds=0.5)

    before = sim.pose
    sim.autonomous("in the hub", seconds=1.0)
    assert sim.pose.translation().distance(before.translation()) < 1.2
    (said,) = warnings(caplog)
    assert "(4.60, 4.0" in said and "inside of a field element" in said and f"({before.X():.2f}, " in said, said


def test_nothing_set(sim, caplog):
    sim.autonomous("none", seconds=1.0)
    (said,) = warnings(caplog)  # the estimate starts at the origin
    assert "believes it is at (0." in said and "but it is at (2." in said and "m and" in said, said


def test_the_last_reset_counts_and_teleop_moves_no_robot(sim, caplog):
    caplog.set_level(logging.INFO, "simcore")
    sim.start()
    before = sim.pose
    from simcore.robotcode.sim.driver_controls import choose_auto
    for name in ("left", "right"):
        choose_auto(name)
        sim.run(0.1)
    sim.teleop(seconds=0.3)
    assert sim.pose.translation().distance(before.translation()) < 0.01
    assert not warnings(caplog)


def test_a_given_place_stays_with_one_warning(sim, caplog):
    sim.start()
    sim.place(6.0, 1.0, 0.5)
    sim.autonomous("right", seconds=1.0)
    (said,) = warnings(caplog)
    assert "believes it is at (3." in said and "but it is at (6." in said, said
"""
    )
    assert code == 0, said


def test_a_pose_set_in_robotinit_is_the_start_pose_of_the_auto(project_of):
    code, said = project_of(SEEDING)(
        HELPERS
        + """
def test_it(sim, caplog):
    sim.autonomous(seconds=0.6)
    assert apart(sim) < 0.05 and not warnings(caplog) and sim.pose.Y() > 5.9
""",
        AT_ONCE="1",
    )
    assert code == 0, said


def test_wpilib_odometry_counts_as_an_estimate_too(project_of):
    """A kit bot without CTRE devices sets its pose while disabled and reports it by WPILib's odometry."""
    code, said = project_of(ROBOTS / "tank")(
        HELPERS
        + """
from wpimath.geometry import Pose2d, Rotation2d

def set_pose(sim, x, y, heading):
    robot = sim.robot
    robot.odometry.resetPosition(
        robot.gyro.getRotation2d(), *(e.getDistance() for e in robot.encoders), Pose2d(x, y, heading)
    )

def test_it(sim, caplog):
    sim.start()
    set_pose(sim, 3.0, 6.0, 1.0)
    sim.run(0.1)
    sim.autonomous(seconds=0.7)
    assert (sim.pose.X(), sim.pose.Y()) == pytest.approx((3.0, 6.0), abs=0.01)
    assert sim.robot_sim.believed_pose == pytest.approx((3.0, 6.0, 1.0), abs=0.02) and not warnings(caplog)
    set_pose(sim, 4.0, 6.0, 1.0)
    sim.disable(seconds=0.1)
    sim.autonomous(seconds=0.7)
    (said,) = warnings(caplog)
    assert "believes it is at (4.00, 6.00) m, 57 deg" in said and "1.00 m and 0 deg apart" in said, said
"""
    )
    assert code == 0, said


EARLY = """
import os

def test_it_drives(sim):
    stick = sim.joystick(0)
    sim.teleop()
    stick.axis(1, -0.8)
    begin = sim.pose.X()
    sim.run(1.5)
    assert 1.0 < sim.pose.X() - begin < 3.5
    intake, feeder, wheels = sim.robot.facts()["speeds"]
    assert intake > 10.0 and wheels > 10.0 and feeder > 5.0
    assert "intake" in sim.robot_sim.mechanisms
    with open(os.environ["DIGESTS"], "a") as file:
        file.write(sim.digest + "\\n")

def test_a_second_one(sim):
    test_it_drives(sim)
"""


def test_devices_built_at_import_exist_in_every_test(project_of, tmp_path):
    """Devices are built at the top of robot.py, in a class body and in another module; a path may be given."""
    digests = tmp_path / "digests"
    run = project_of(ROBOTS / "early")
    for command in (
        ("-m", "robotpy", "test", "--", "-v"),
        ("-m", "robotpy", "test", "--", "tests/test_robot.py"),
    ):
        code, said = run(EARLY, command=command, DIGESTS=str(digests))
        assert code == 0 and "2 passed" in said, said
    lines = digests.read_text().split()
    assert len(lines) == 4 and len(set(lines)) == 1, "each test once in a process of its own"


@pytest.mark.parametrize("environment", [{}, {"THREAD": "1"}])
def test_robotpy_test_without_isolation_finishes(project_of, tmp_path, environment):
    code, said = project_of(ROBOTS / "early")(
        EARLY.split("def test_a_second")[0].replace("sim.digest", "'ended'"),
        command=("-m", "robotpy", "test", "--no-isolation"),
        DIGESTS=str(tmp_path / "digests"),
        **environment,
    )
    assert code == 0 and "1 passed" in said, said


TWICE = """
import os

import measures
import wpilib

AMPS = float(os.environ.get("AMPS", "90"))  # of a drive motor, at which its wheel must not slip


class Container:
    def __init__(self):
        self.drivetrain = measures.build(slip_current=AMPS)

    def drive(self):
        self.drivetrain.set_control(measures.driver_request())


class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.drivetrain = measures.build(slip_current=AMPS)
        self.container = Container()

    def teleopPeriodic(self):
        self.container.drive()
"""
"""Robot that builds its drivetrain twice, in robot.py and in its container, whose copy drives."""


def test_a_drivetrain_that_is_built_twice_drives_and_is_reported_once(project_of):
    code, said = project_of(TWICE)(
        """
import logging
import pytest

def test_it(sim, caplog):
    stick = sim.joystick(0)
    sim.teleop()
    stick.axis(1, -0.8)
    begin = sim.pose.X()
    sim.run(1.0)
    believed = sim.robot.container.drivetrain.get_state().pose.X()
    assert sim.pose.X() - begin > 0.6
    assert believed == pytest.approx(sim.pose.X() - begin, abs=0.02)
    (said,) = [r.getMessage() for r in caplog.records if "on the same devices" in r.getMessage()]
    assert "2 drivetrains" in said
""",
        AMPS="40",
    )
    assert code == 0, said


def test_odometry_differs_from_the_true_pose_only_by_wheel_slip(project_of):
    """The robot drives sideways from rest with all wheels still pointing forward; tires hold 40 A but not 90 A.

    While a module turns, its drive output is scaled by the cosine of its error, so without slip odometry is right from
    the first instant. With full slip it leads by v^2 / (2 mu g) = 0.38 m at 3 m/s.
    """
    leads, run = [], project_of(TWICE)
    for amps in ("40", "90"):
        code, said = run(
            """
def test_it(sim):
    sim.start()
    sim.place(2.0, 2.0)
    stick = sim.joystick(0)
    sim.teleop()
    stick.axis(0, -1.0)
    sim.run(0.4)
    print("LEAD", sim.robot.container.drivetrain.get_state().pose.Y() - (sim.pose.Y() - 2.0))
    assert sim.pose.Y() > 2.05
""",
            "-rA",
            AMPS=amps,
        )
        assert code == 0, said
        leads.append(float(next(line for line in said.splitlines() if line.startswith("LEAD")).split()[1]))
    assert abs(leads[0]) < 0.01 and 0.05 < leads[1] < 0.38, leads


NAMED = """
import measures
import wpilib
from phoenix6 import hardware

LIFT_MOTOR = hardware.TalonFX(40)


class Shooter:
    def __init__(self):
        self.shooterMotorTop, self.bottom = hardware.TalonFX(31), hardware.TalonFX(32)


class IntakeSubsystem:
    def __init__(self):
        self.motor = hardware.TalonFX(33)
        self.m_pivotTalonFX = hardware.TalonFX(34)


class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.drivetrain = measures.build()
        self.shooter, self.intake = Shooter(), IntakeSubsystem()
        self.Feeder1Motor = hardware.TalonFX(35)
        self.WristMotor = hardware.TalonFX(36)
        self.all = [hardware.TalonFX(37)]
"""
"""Motors in attributes named after their mechanisms, in the ways in which teams write them."""


def test_init_gives_mechanisms_the_names_in_robot_code(project_of):
    run = project_of(NAMED)
    code, said = run("", command=("-m", "simcore", "init", "."))
    assert code == 0, said
    text = (run.folder / "simcore.toml").read_text()
    for number, (name, kind) in {
        31: ("shooter_top", "flywheel"), 32: ("shooter_bottom", "flywheel"), 33: ("intake", "roller"),
        34: ("pivot", "arm"), 35: ("feeder1", "roller"), 36: ("wrist", "arm"), 37: ("all", "roller"),
        40: ("lift", "elevator"),
    }.items():  # fmt: skip
        table = next(part for part in text.split("[[mechanism]]") if f"leader = {number}" in part)
        assert f'name = "{name}"' in table, table
        assert f'kind = "{kind}"' in table or f'by its name "{kind}"' in table, table
