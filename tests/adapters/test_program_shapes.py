"""Programs as teams write them behave with no line of code; where one does not, simcore says why."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

import simcore

pytestmark = pytest.mark.slow

SWERVE = """
import math
import rev
import wpilib
from wpilib import RobotBase
from wpimath.controller import PIDController
from wpimath.estimator import SwerveDrive4PoseEstimator
from wpimath.geometry import Pose2d, Rotation2d, Translation2d
from wpimath.kinematics import (
    ChassisSpeeds, SwerveDrive4Kinematics, SwerveDrive4Odometry, SwerveModulePosition, SwerveModuleState)

X = Y = 0.28
KIN = SwerveDrive4Kinematics(Translation2d(X, Y), Translation2d(X, -Y), Translation2d(-X, Y), Translation2d(-X, -Y))
METERS = 0.1016 * math.pi / 6.75
TURNS = math.tau / 21.43
BRUSHLESS = rev.SparkLowLevel.MotorType.kBrushless


class Module:
    def __init__(self, k):
        self.drive = rev.SparkMax(2 * k + 1, BRUSHLESS)
        self.steer = rev.SparkMax(2 * k + 2, BRUSHLESS)
        c = rev.SparkMaxConfig()
        c.encoder.positionConversionFactor(METERS).velocityConversionFactor(METERS / 60)
        c.closedLoop.pid(0.1, 0, 0)
        c.closedLoop.feedForward.kV(2.4)
        self.drive.configure(c, rev.ResetMode.kResetSafeParameters, rev.PersistMode.kNoPersistParameters)
        c = rev.SparkMaxConfig()
        c.encoder.positionConversionFactor(TURNS).velocityConversionFactor(TURNS / 60)
        c.closedLoop.pid(1.0, 0, 0).positionWrappingEnabled(True).positionWrappingInputRange(-math.pi, math.pi)
        self.steer.configure(c, rev.ResetMode.kResetSafeParameters, rev.PersistMode.kNoPersistParameters)

    def angle(self):
        return Rotation2d(self.steer.getEncoder().getPosition())

    def get_position(self):
        return SwerveModulePosition(self.drive.getEncoder().getPosition(), self.angle())

    def steer_to(self, angle):
        self.steer.getClosedLoopController().setReference(angle.radians(), rev.SparkLowLevel.ControlType.kPosition)

    def go(self, state):
        state.optimize(self.angle())
        self.drive.getClosedLoopController().setReference(state.speed, rev.SparkLowLevel.ControlType.kVelocity)
        self.steer_to(state.angle)


class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.modules = [Module(k) for k in range(4)]
        self.gyro, self.pad = wpilib.ADXRS450_Gyro(), wpilib.XboxController(0)
        self.odometry = SwerveDrive4Odometry(KIN, self.heading(), self.positions())

    def heading(self):
        return self.gyro.getRotation2d()

    def positions(self):
        return tuple(m.get_position() for m in self.modules)

    def robotPeriodic(self):
        self.odometry.update(self.heading(), self.positions())

    def teleopPeriodic(self):
        speeds = ChassisSpeeds(-3 * self.pad.getLeftY(), -3 * self.pad.getLeftX(), -2 * self.pad.getRightX())
        for module, state in zip(self.modules, KIN.toSwerveModuleStates(speeds)):
            module.go(state)
"""
TANK = """
import math
import rev
import wpilib
from wpilib.drive import DifferentialDrive
from wpimath.kinematics import DifferentialDriveOdometry

FACTOR = 0.1524 * math.pi / 8.45


def spark(number, inverted=False, leader=None):
    motor = rev.SparkMax(number, rev.SparkLowLevel.MotorType.kBrushless)
    c = rev.SparkMaxConfig().setIdleMode(rev.SparkBaseConfig.IdleMode.kBrake)
    c.encoder.positionConversionFactor(FACTOR).velocityConversionFactor(FACTOR / 60)
    c.inverted(inverted) if leader is None else c.follow(leader)
    motor.configure(c, rev.ResetMode.kResetSafeParameters, rev.PersistMode.kNoPersistParameters)
    return motor


class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.motorL1, self.motorL2 = spark(1), spark(2, leader=1)
        self.motorR1, self.motorR2 = spark(3, True), spark(4, leader=3)
        self.drive = DifferentialDrive(self.motorL1, self.motorR1)
        self.gyro, self.pad = wpilib.ADXRS450_Gyro(), wpilib.XboxController(0)
        self.odometry = DifferentialDriveOdometry(self.gyro.getRotation2d(), 0.0, 0.0)

    def robotPeriodic(self):
        left, right = self.motorL1.getEncoder().getPosition(), self.motorR1.getEncoder().getPosition()
        self.odometry.update(self.gyro.getRotation2d(), left, right)

    def teleopPeriodic(self):
        self.drive.arcadeDrive(-self.pad.getLeftY(), -self.pad.getRightX(), False)
"""
MECANUM = """
import math
import rev
import wpilib
from wpilib.drive import MecanumDrive
from wpimath.geometry import Translation2d
from wpimath.kinematics import MecanumDriveKinematics, MecanumDriveOdometry, MecanumDriveWheelPositions

FACTOR = 0.1524 * math.pi / 8.45
PLACES = [(0.26, 0.28), (0.26, -0.28), (-0.26, 0.28), (-0.26, -0.28)]
KIN = MecanumDriveKinematics(*(Translation2d(*place) for place in PLACES))


class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.wheels = []
        for number in (1, 2, 3, 4):
            motor = rev.SparkMax(number, rev.SparkLowLevel.MotorType.kBrushless)
            c = rev.SparkMaxConfig().inverted(number in (2, 4))
            c.encoder.positionConversionFactor(FACTOR).velocityConversionFactor(FACTOR / 60)
            motor.configure(c, rev.ResetMode.kResetSafeParameters, rev.PersistMode.kNoPersistParameters)
            self.wheels.append(motor)
        fl, fr, rl, rr = self.wheels
        self.drive = MecanumDrive(fl, rl, fr, rr)
        self.gyro, self.pad = wpilib.ADXRS450_Gyro(), wpilib.XboxController(0)
        self.odometry = MecanumDriveOdometry(KIN, self.gyro.getRotation2d(), self.positions())

    def positions(self):
        now = MecanumDriveWheelPositions()
        now.frontLeft, now.frontRight, now.rearLeft, now.rearRight = (
            motor.getEncoder().getPosition() for motor in self.wheels)
        return now

    def robotPeriodic(self):
        self.odometry.update(self.gyro.getRotation2d(), self.positions())

    def teleopPeriodic(self):
        self.drive.driveCartesian(-self.pad.getLeftY(), self.pad.getLeftX(), self.pad.getRightX())
"""
_RIO = (
    "self.steer.getClosedLoopController().setReference(angle.radians(), rev.SparkLowLevel.ControlType.kPosition)",
    "self.steer.setVoltage({sign}self.loop.calculate(self.angle().radians(), angle.radians()))",
)
_LOOP = (
    "    def angle(self):",
    "        self.loop = PIDController(8.0, 0, 0)\n        self.loop.enableContinuousInput(-math.pi, math.pi)\n"
    "{more}\n    def angle(self):",
)
_DIO = (
    "return Rotation2d(self.steer.getEncoder().getPosition())",
    "return Rotation2d.fromRotations({sign}self.azimuth.get())",
)
_SIM_WRITES = (
    "    def teleopPeriodic(self):",
    "    def {hook}(self):\n        for sim in self.sims:\n            sim.iterate(3.0, 12.0, 0.02)\n"
    "            sim.getRelativeEncoderSim().setPosition(0.1)\n\n    def teleopPeriodic(self):",
)
_SIMS = (
    "        self.odometry = ",
    "        from wpimath.system.plant import DCMotor\n"
    "        motors = [m for module in self.modules for m in (module.drive, module.steer)]\n"
    "        self.sims = [rev.{cls}(m, DCMotor.NEO()) for m in motors]\n"
    "        self.odometry = ",
)
_MOVES_ITSELF = (
    "        self.odometry.update(self.heading(), self.positions())",
    "        self.odometry.update(self.heading(), self.positions())\n        if RobotBase.isSimulation():\n"
    "            p = self.odometry.getPose()\n            p = Pose2d(p.x, p.y + 0.014 * self.asked, p.rotation())\n"
    "            self.odometry.resetPosition(self.heading(), self.positions(), p)",
)
_ASKED = (
    "        for module, state in",
    "        self.asked = -3 * self.pad.getLeftX()\n        for module, state in",
)


def _with(text: str, *changes: tuple[str, str], **words: str) -> str:
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new.format(**words) if words else new, 1)
    return text


_IDLE = ("        self.modules = [", "        self.asked = 0.0\n        self.modules = [")
_AZIMUTH = "        self.azimuth = wpilib.DutyCycleEncoder(k)\n"
_QUADRATURE = """
        self.azimuth = wpilib.Encoder(2 * k, 2 * k + 1)
        self.azimuth.setDistancePerPulse(math.tau / 4096)
"""
TWO_MAKERS = _with(
    TANK,
    ("self.motorR1, self.motorR2 = spark(3, True), spark(4, leader=3)", "self.motorR1 = wpilib.PWMSparkMax(0)\n"
     "        self.motorR1.setInverted(True)\n        self.rightEncoder = wpilib.Encoder(0, 1)\n"
     "        self.rightEncoder.setDistancePerPulse(0.1524 * math.pi / 2048)"),
    ("self.motorR1.getEncoder().getPosition()", "self.rightEncoder.getDistance()"),
    ("self.drive = ", "self.leftEncoder = wpilib.Encoder(2, 3)\n"
     "        self.leftEncoder.setDistancePerPulse(0.1524 * math.pi / 2048)\n        self.drive = "),
    ("self.motorL1.getEncoder().getPosition()", "self.leftEncoder.getDistance()"),
)  # fmt: skip
CLEAN: dict[str, str] = {
    "loops on SPARKs": SWERVE,
    "SparkSim in simulationPeriodic": _with(
        _with(SWERVE, _SIMS, cls="SparkSim"), _SIM_WRITES, hook="simulationPeriodic"
    ),
    "SparkMaxSim in _simulationPeriodic": _with(
        _with(SWERVE, _SIMS, cls="SparkMaxSim"), _SIM_WRITES, hook="_simulationPeriodic"
    ),
    "loops on the roboRIO, DIO encoders": _with(
        _with(_with(SWERVE, _RIO, sign=""), _LOOP, more=_AZIMUTH), _DIO, sign=""
    ),
    "steer motors turn the other way": _with(
        _with(_with(SWERVE, _RIO, sign="-"), _LOOP, more=_AZIMUTH), _DIO, sign=""
    ),
    "encoders count clockwise": _with(_with(_with(SWERVE, _RIO, sign=""), _LOOP, more=_AZIMUTH), _DIO, sign="-"),
    "quadrature encoders on the azimuths": _with(
        _with(_with(SWERVE, _RIO, sign=""), _LOOP, more=_QUADRATURE),
        (_DIO[0], "return Rotation2d(self.azimuth.getDistance())"),
    ),
    "a class of SPARKs of its own": _with(
        SWERVE,
        ("class Module:", "class Spark(rev.SparkMax):\n    def configure(self, *settings):\n"
         "        return super().configure(*settings)\n\n\nclass Module:"),
        ("self.drive = rev.SparkMax", "self.drive = Spark"),
    ),
    "places in inches": _with(SWERVE, ("X = Y = 0.28", "X = Y = 11.0"), ("getRightX())", "getRightX() * 0)")),
    "a pose that the program moves in simulation": _with(SWERVE, _MOVES_ITSELF, _ASKED, _IDLE),
    "an estimator": _with(SWERVE, ("SwerveDrive4Odometry(KIN, self.heading(), self.positions())",
                                   "SwerveDrive4PoseEstimator(KIN, self.heading(), self.positions(), Pose2d())")),
    "tank of motors L1 and R1": TANK,
    "tank of lDrive and rDrive": TANK.replace("motorL", "lDrive").replace("motorR", "rDrive"),
    "tank of fl_motor and rr_motor": TANK.replace("motorL1", "fl_motor").replace("motorL2", "rl_motor")
    .replace("motorR1", "fr_motor").replace("motorR2", "rr_motor"),
    "tank of two makers": TWO_MAKERS,
    "tank that knows its gears alone": _with(
        TANK,
        ("    c.encoder.positionConversionFactor(FACTOR).velocityConversionFactor(FACTOR / 60)\n", ""),
        ("getRotation2d(), left, right)", "getRotation2d(), 0.04 * left, 0.04 * right)"),
    ),
    "tank whose encoders count inches": _with(
        TWO_MAKERS,
        *[("setDistancePerPulse(0.1524 * math.pi / 2048)", "setDistancePerPulse(6.0 * math.pi / 360)")] * 2,
        ("getRotation2d(), left, right)", "getRotation2d(), 0.0254 * left, 0.0254 * right)"),
    ),
    "mecanum": MECANUM,
}  # fmt: skip
"""Programs with which nothing is wrong, by their habit: belief holds with no line of code."""

IO_LAYERS = _with(
    SWERVE,
    (
        "class Robot(",
        '''class SimulatedModule:
    """What an IO layer builds in simulation: no motor, a model of its own."""

    def __init__(self, k):
        self.way, self.state = 0.0, SwerveModuleState()

    def get_position(self):
        self.way += 0.02 * self.state.speed
        return SwerveModulePosition(self.way, self.state.angle)

    def go(self, state):
        self.state = state


class Robot(''',
    ),
    ("[Module(k) for", "[(Module if RobotBase.isReal() else SimulatedModule)(k) for"),
)
"""Builds motors on the real robot alone."""

FAULTS: dict[str, tuple[str, str, str]] = {
    "a gyro that is not negated": (
        _with(SWERVE, ("return self.gyro.getRotation2d()", "return Rotation2d.fromDegrees(self.gyro.getAngle())")),
        "",
        "gyro is not negated",
    ),
    "wheels of another size": (SWERVE, "drive_gearing = 6.75\nwheel_diameter = 0.13", "wheel size"),
    "zeros that differ": (SWERVE, "zeros_deg = [40.0, 40.0, 40.0, 40.0]", "zeros"),
    "a tank that drives backward": (
        _with(TANK, ("getRotation2d(), left, right)", "getRotation2d(), -left, -right)")),
        "",
        "goes the other way",
    ),
    "a heading that is half of it": (
        _with(SWERVE, ("return self.gyro.getRotation2d()", "return self.gyro.getRotation2d() * 0.5")),
        "",
        "times as far",
    ),
}  # fmt: skip
"""Programs with an error: source, keys of [drivetrain], and what the warning says."""

PACKAGES = Path(simcore.__file__).resolve().parents[1]
SAMPLE = ("SparkSim in simulationPeriodic", "steer motors turn the other way", "tank of motors L1 and R1")
COURSE = """
import json, math
from pathlib import Path


def test_course(sim):
    pad, legs = sim.xbox(0), {}
    sim.place(1.5, 2.2)
    sim.teleop(seconds=0.3)
    robot = sim.robot_sim

    def drive(name, **sticks):
        true, told, turned = robot.chassis.pose, robot.estimated_pose, 0.0
        for tenth in range(18):
            for stick, value in sticks.items():
                setattr(pad, stick, value if tenth < 12 else 0.0)
            heading = sim.pose.rotation()
            sim.run(0.1)
            turned += (sim.pose.rotation() - heading).radians()
        now, new = robot.chassis.pose, robot.estimated_pose
        legs[name] = math.dist(true[:2], now[:2]), math.dist(told[:2], new[:2]), turned

    for leg in LEGS:
        drive(*leg[:1], **leg[1])
    facts = {"legs": legs, "warnings": sim.warnings, "digest": sim.match.digest.hexdigest()}
    Path(__file__).with_name("facts.json").write_text(json.dumps(facts))
"""
STRAIGHT = [["ahead", {"left_y": -0.4}], ["left", {"left_x": -0.5}], ["turn", {"right_x": -0.6}]]
TANK_LEGS = [["ahead", {"left_y": -0.3}], ["turn", {"right_x": -0.3}], ["curve", {"left_y": 0.3, "right_x": -0.25}]]


@pytest.fixture
def drive(tmp_path) -> Callable[..., dict[str, Any]]:
    """Runs a program over some legs in a process of its own."""
    for module in ("wpilib", "pyfrc", "rev"):
        if find_spec(module) is None:
            pytest.skip(f"needs {module}: pip install .[robotpy,rev]")

    def run(source: str, legs: list[Any], toml: str = "", *, fails: bool = False) -> dict[str, Any]:
        (tmp_path / "robot.py").write_text(source)
        (tmp_path / "tests").mkdir(exist_ok=True)
        (tmp_path / "tests" / "course_test.py").write_text(COURSE.replace("LEGS", repr(legs)))
        (tmp_path / "simcore.toml").write_text(toml)
        path = os.pathsep.join([str(PACKAGES), *filter(None, [os.environ.get("PYTHONPATH")])])
        done = subprocess.run(
            [sys.executable, "-m", "robotpy", "test", "--", "-q", "-p", "no:cacheprovider"],
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": path},
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
        assert (done.returncode != 0) is fails, done.stdout + done.stderr
        if fails:
            return {"said": done.stdout}
        facts: dict[str, Any] = json.loads((tmp_path / "tests" / "facts.json").read_text())
        return facts

    return run


@pytest.mark.parametrize("name", CLEAN)
def test_it_goes_where_the_sticks_say_and_knows_it(name, drive, request):
    if name not in SAMPLE and not request.config.getoption("--whole"):
        pytest.skip("not in the sample: --whole runs all of them")
    is_tank = name.startswith("tank")
    facts = drive(CLEAN[name], TANK_LEGS if is_tank else STRAIGHT)
    legs = facts["legs"]
    for leg in ("ahead",) if is_tank or name == "mecanum" else ("ahead", "left"):
        true, told, turned = legs[leg]
        assert true > 0.8 and told == pytest.approx(true, rel=0.05) and abs(turned) < 0.2, (leg, legs)
    assert legs["turn"][2] > (0.0 if "places" in name else 0.5), "counter-clockwise, on the spot"
    assert "curve" not in legs or legs["curve"][2] > 0.3
    assert not [text for text in facts["warnings"] if "does not hold" in text]
    if name == SAMPLE[0]:
        assert drive(CLEAN[name], STRAIGHT) == facts


@pytest.mark.parametrize("name", FAULTS)
def test_an_odometry_that_does_not_hold_is_told_with_its_cause(name, drive, request):
    if name != next(iter(FAULTS)) and not request.config.getoption("--whole"):
        pytest.skip("not in the sample: --whole runs all of them")
    source, keys, cause = FAULTS[name]
    legs = [*STRAIGHT[:2], ["turn", {"right_x": -0.8}]] if "tank" not in name else TANK_LEGS
    said = drive(source, legs, f"[drivetrain]\n{keys}\n" if keys else "")["warnings"]
    told = [text for text in said if "does not hold" in text]
    assert len(told) == 1 and cause in told[0], said


def test_what_init_writes_of_two_makers_starts_and_drives(drive, tmp_path, request):
    if not request.config.getoption("--whole"):
        pytest.skip("--whole: what init writes is played for more robots elsewhere")
    first = drive(TWO_MAKERS, TANK_LEGS)
    (tmp_path / "simcore.toml").unlink()
    done = subprocess.run([sys.executable, "-m", "simcore", "init"], cwd=tmp_path, capture_output=True, text=True,
                          env={**os.environ, "PYTHONPATH": str(PACKAGES)}, check=False)  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    again = drive(TWO_MAKERS, TANK_LEGS, (tmp_path / "simcore.toml").read_text())
    for leg, figures in first["legs"].items():  # measures are written with seven digits
        assert again["legs"][leg] == pytest.approx(figures, abs=1e-6)


def test_an_io_layer_builds_its_motors_where_the_file_says_that_it_is_real(drive):
    assert "real = true" in drive(IO_LAYERS, STRAIGHT, fails=True)["said"]
    true, told, _ = drive(IO_LAYERS, STRAIGHT, "[robot]\nreal = true\n")["legs"]["ahead"]
    assert true > 0.8 and told == pytest.approx(true, rel=0.05)
