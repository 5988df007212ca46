"""Drivetrain classes of teams: odometry agrees with the true motion without extra code, and `init` describes them.

Where a program's odometry is wrong, simcore names the cause.
"""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

import simcore

pytestmark = pytest.mark.slow

PACKAGES = Path(simcore.__file__).resolve().parents[1]
ROBOTS = Path(__file__).parent / "robots"
NEEDS = ("wpilib", "pyfrc", "phoenix6", "rev", "commands2", "magicbot")
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
TANK_PWM = """
import math
import wpilib
from wpilib.drive import DifferentialDrive
from wpimath.kinematics import DifferentialDriveKinematics, DifferentialDriveOdometry


class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.left, self.right, self.left_back, self.right_back = (wpilib.Spark(k) for k in range(4))
        {sides}
        self.left_encoder, self.right_encoder = wpilib.Encoder(0, 1), wpilib.Encoder(2, 3, True)
        for encoder in (self.left_encoder, self.right_encoder):
            encoder.setDistancePerPulse(math.pi * 0.1524 / 360)
        self.gyro, self.pad = wpilib.ADXRS450_Gyro(), wpilib.Joystick(0)
        self.kinematics = DifferentialDriveKinematics(0.6)
        self.odometry = DifferentialDriveOdometry(self.gyro.getRotation2d(), 0.0, 0.0)

    def robotPeriodic(self):
        ways = self.left_encoder.getDistance(), self.right_encoder.getDistance()
        self.odometry.update(self.gyro.getRotation2d(), *ways)

    def teleopPeriodic(self):
        self.drive.arcadeDrive(-self.pad.getRawAxis(1), -self.pad.getRawAxis(4), False)
"""
FOLLOWERS = """self.left.addFollower(self.left_back)
        self.right.addFollower(self.right_back)
        self.right.setInverted(True)
        self.right_back.setInverted(True)
        self.drive = DifferentialDrive(self.left, self.right)"""
GROUPS = """self.left = wpilib.MotorControllerGroup(self.left, self.left_back)
        self.right = wpilib.MotorControllerGroup(self.right, self.right_back)
        self.right.setInverted(True)
        self.drive = DifferentialDrive(lambda speed: self.left.set(speed), lambda speed: self.right.set(speed))"""
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
CLEAN: dict[str, str | Path] = {
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
    "MAXSwerve": ROBOTS / "own_maxswerve",
    "TalonFX and CANcoders": ROBOTS / "own_talons",
    "PWM controllers and ports": ROBOTS / "own_rio_loops",
    "MagicBot of two makers": ROBOTS / "own_magic",
    "SPARKs seeded from CANcoders": _with(
        SWERVE,
        ("import wpilib\n", "import wpilib\nfrom phoenix6.configs import CANcoderConfiguration\n"
         "from phoenix6.hardware import CANcoder, Pigeon2\n"),
        *[("        c.closedLoop", "        c.inverted(True)\n        c.closedLoop")] * 2,
        ("    def angle(self):", "        self.can_coder, c = CANcoder(20 + k), CANcoderConfiguration()\n"
         "        c.magnet_sensor.magnet_offset = 0.15 * k - 0.2\n        self.can_coder.configurator.apply(c)\n"
         "        absolute = self.can_coder.get_absolute_position().value\n"
         "        self.steer.getEncoder().setPosition(math.tau * absolute)\n\n    def angle(self):"),
        ("wpilib.ADXRS450_Gyro()", "Pigeon2(9)"),
    ),
    "six modules of SPARK Flex": _with(
        SWERVE.replace("SparkMax", "SparkFlex").replace("Drive4", "Drive6")
        .replace("self.steer.getEncoder()", "self.steer.getAbsoluteEncoder()"),
        ("c.encoder.positionConversionFactor(TURNS).velocityConversionFactor(TURNS / 60)",
         "c.absoluteEncoder.positionConversionFactor(math.tau)"),
        ("c.closedLoop.pid(1.0, 0, 0)",
         "c.closedLoop.setFeedbackSensor(rev.FeedbackSensor.kAbsoluteEncoder).pid(0.8, 0, 0)"),
        ("Translation2d(X, Y), Translation2d(X, -Y), Translation2d(-X, Y), Translation2d(-X, -Y)",
         "*(Translation2d(x, y) for x in (0.32, 0.0, -0.32) for y in (Y, -Y))"),
        ("range(4)", "range(6)"),
    ),
    "tank on PWM with followers": TANK_PWM.format(sides=FOLLOWERS),
    "tank of groups by functions": TANK_PWM.format(sides=GROUPS),
}  # fmt: skip
"""Correct programs by habit; their odometry holds without extra code."""

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
"""Robot that builds its motors only on the real robot."""

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
        "the opposite way",
    ),
    "a heading that is half of it": (
        _with(SWERVE, ("return self.gyro.getRotation2d()", "return self.gyro.getRotation2d() * 0.5")),
        "",
        "times as far",
    ),
}  # fmt: skip
"""Programs with an error: source, keys of [drivetrain], and a part of the warning."""

FOUND = {
    "MAXSwerve": ("swerve", "SPARK MAX", "wired"),
    "SPARKs seeded from CANcoders": ("swerve", "SPARK MAX", "CANcoder"),
    "TalonFX and CANcoders": ("swerve", "TalonFX", "CANcoder"),
    "PWM controllers and ports": ("swerve", "PWM", "DutyCycleEncoder"),
    "MagicBot of two makers": ("swerve", "TalonFX", "AnalogEncoder"),
    "six modules of SPARK Flex": ("swerve", "SPARK Flex", "wired"),
    "tank of motors L1 and R1": ("tank", "SPARK MAX", None),
    "tank on PWM with followers": ("tank", "PWM", None),
    "tank of groups by functions": ("tank", "PWM", None),
    "tank of two makers": ("tank", None, None),
    "mecanum": ("mecanum", "SPARK MAX", None),
}
"""Kind of drivetrain, controller of the drive motors and absolute encoder of the modules, as simcore finds them."""
SAMPLE = (
    *("SparkSim in simulationPeriodic", "steer motors turn the other way", "tank of motors L1 and R1"),
    *("MAXSwerve", "TalonFX and CANcoders", "tank of groups by functions", "mecanum"),
)
"""Programs that run without `--whole`."""
COURSE = """
import legs

def test_course(sim):
    legs.drive(sim, legs.{legs})
"""


def sampled(name: str, request: pytest.FixtureRequest) -> None:
    if name not in SAMPLE and not request.config.getoption("--whole"):
        pytest.skip("not in the sample: --whole runs all of them")


@pytest.fixture
def own(project_of) -> Callable[[str | Path], Any]:
    """Return `project_of`, or skip if a maker's library is not installed."""
    for module in NEEDS:
        if find_spec(module) is None:
            pytest.skip(f"needs {module}, which is not installed")
    return project_of


def drive(run: Any, legs: str = "HOLONOMIC") -> dict[str, Any]:
    """Drive the legs in a separate process; return their figures."""
    code, said = run(COURSE.format(legs=legs))
    assert code == 0, said
    return json.loads((run.folder / "facts.json").read_text())


def init(run: Any) -> tuple[str, str]:
    """Write a simcore.toml; return the printed text and the text of the file."""
    code, said = run("", command=("-m", "simcore", "init"))
    assert code == 0, said
    return said, (run.folder / "simcore.toml").read_text(encoding="utf-8")


def legs_of(name: str) -> str:
    return "TANK" if name.startswith("tank") else "HOLONOMIC"


def check_legs(name: str, facts: dict[str, Any]) -> None:
    legs = facts["legs"]
    for leg in ("ahead",) if name.startswith("tank") or name == "mecanum" else ("ahead", "left"):
        true, told, turned = legs[leg]
        assert true > 0.8 and told == pytest.approx(true, rel=0.05) and abs(turned) < 0.2, (leg, legs)
    assert legs["turn"][2] > (0.0 if "places" in name else 0.5), "counter-clockwise, on the spot"
    assert "curve" not in legs or legs["curve"][2] > 0.3
    assert not [text for text in facts["warnings"] if "odometry is off" in text]


@pytest.mark.parametrize("name", CLEAN)
def test_a_teams_own_drivetrain_has_true_odometry_with_and_without_a_file_from_init(name, own, request):
    sampled(name, request)
    run = own(CLEAN[name])
    facts = drive(run, legs_of(name))
    check_legs(name, facts)
    if name in (SAMPLE[0], "MAXSwerve"):
        assert drive(run, legs_of(name)) == facts
    if name not in FOUND:
        return
    kind, controller, encoder = FOUND[name]
    _, text = init(run)
    assert f'kind = "{kind}"' in text and (controller is None or f'controller = "{controller}"' in text)
    assert encoder is None or f'encoder = "{encoder}"' in text
    for leg, figures in drive(run, legs_of(name))["legs"].items():  # dimensions are written with seven digits
        assert figures == pytest.approx(facts["legs"][leg], rel=5e-3, abs=0.02), leg
    code, said = run("", command=("-m", "simcore", "check"))
    assert code == 0 and f"note: {kind} drive: as simcore.toml says" in said and "nothing wrong" in said, said


@pytest.mark.parametrize("name", FAULTS)
def test_wrong_odometry_is_reported_with_its_cause(name, own, request):
    if name != next(iter(FAULTS)) and not request.config.getoption("--whole"):
        pytest.skip("not in the sample: --whole runs all of them")
    source, keys, cause = FAULTS[name]
    run = own({"robot.py": source, "simcore.toml": f"[drivetrain]\n{keys}\n" if keys else ""})
    said = drive(run, "TANK" if "tank" in name else "HOLONOMIC")["warnings"]
    told = [text for text in said if "odometry is off" in text]
    assert len(told) == 1 and cause in told[0], said


def test_an_io_layer_drives_only_if_the_file_sets_real_to_true(own):
    run = own(IO_LAYERS)
    code, said = run(COURSE.format(legs="HOLONOMIC"))
    assert code == 1 and "real = true" in said, said
    (run.folder / "simcore.toml").write_text("[robot]\nreal = true\n")
    true, told, _ = drive(run)["legs"]["ahead"]
    assert true > 0.8 and told == pytest.approx(true, rel=0.05)


AUTO = """
import math


def test_its_auto_ends_at_its_estimate_and_scores(sim):
    worst = 0.0
    sim.autonomous(seconds=0.1)
    for _ in range(95):
        sim.run(0.2)
        told = sim.robot.container.drive.get_pose()
        worst = max(worst, math.dist((sim.pose.X(), sim.pose.Y()), (told.X(), told.Y())))
    end, estimates = math.dist((sim.pose.X(), sim.pose.Y()), (2.3, 5.4)), sim.robot.container.drive.vision.estimates
    off = math.dist((sim.pose.X(), sim.pose.Y()), (told.X(), told.Y()))
    turned = math.degrees((sim.pose.rotation() - told.rotation()).radians())
    record = sim.record
    print("AUTO", off, worst, end, turned, estimates, sim.score, len(record.taken_in), len(record.shots))
    assert estimates > 100
    assert off < 0.05 and abs(turned) < 1.0
    assert end < 0.25
    assert len(sim.match.record.taken_in) >= 8 and sim.score.blue >= 12 and sim.score.red == 0
"""
FILLED = {
    "# mass = 55.0": "mass = 57.0", "# bumper_length = 0.8": "bumper_length = 0.88",
    "# bumper_width = 0.8": "bumper_width = 0.86", "# capacity = 1": "capacity = 40",
    "\nx = 2.0": "\nx = 2.6", "\ny = 1.2": "\ny = 5.6", "\npreload = 0": "\npreload = 8",
}  # fmt: skip
"""Values that a student writes in place of those that `init` proposes."""


def test_a_spark_swerve_with_a_camera_drives_its_pathplanner_auto_and_scores(own):
    """The robot has MAXSwerve modules, a navX and PhotonVision; its PathPlanner auto leads through the depot."""
    for module in ("navx", "pathplannerlib", "photonlibpy", "cv2", "robotpy_apriltag"):
        pytest.importorskip(module)
    run = own(ROBOTS / "own_paths")
    for name in ("constants.py", "subsystems.py"):
        shutil.copy(ROBOTS / "own_maxswerve" / name, run.folder)
    code, said = run("", command=("-m", "simcore", "init", "--all"))
    assert code == 0, said
    file = run.folder / "simcore.toml"
    text = re.sub(r"(?m)^\[\[mechanism\]\]\n(?:.+\n)+", "", file.read_text(encoding="utf-8"))  # proposed by id alone
    text += (run.folder / "filled.toml").read_text(encoding="utf-8")
    for proposed, true in FILLED.items():
        assert proposed in text
        text = text.replace(proposed, true, 1)
    file.write_text(text, encoding="utf-8")
    code, said = run(AUTO, "-rP")
    print(said)
    assert code == 0


def test_without_a_drivetrain_the_program_runs_and_tests_name_the_table_to_write(own):
    run = own(
        "import wpilib\n\nclass Robot(wpilib.TimedRobot):\n    def robotPeriodic(self):\n"
        "        print('loop', wpilib.Timer.getFPGATimestamp() > 1.0, flush=True)\n"
        "        if wpilib.Timer.getFPGATimestamp() > 2.0:\n            raise SystemExit\n"
    )
    code, said = run(COURSE.format(legs="HOLONOMIC"))
    sentence = "no drivetrain found: the program builds none of"
    assert code == 1 and sentence in said and "describe it in a [drivetrain] table in simcore.toml" in said
    _, said = run("", command=("-m", "robotpy", "sim", "--simcore", "--nogui"))
    assert sentence in said and "loop True" in said


def test_swerve_modules_can_use_absolute_encoders_that_are_read_in_volts(own):
    run = own(ROBOTS / "own_magic")
    robot = run.folder / "robot.py"
    robot.write_text(
        _with(
            robot.read_text(),
            ("wpilib.AnalogEncoder(channel)", "wpilib.AnalogInput(channel)"),
            ("self.absolute.get()", "self.absolute.getVoltage() / 5.0"),
        )
    )
    check_legs("read as volts", drive(run))


def test_a_tank_without_a_drive_class_is_found_by_its_motor_names(own):
    """Motors of a lift do not count; a conversion factor of 1 / 10 for wheel turns gives the gearing."""
    run = own(
        "import rev\nimport wpilib\n\nSPARK = rev.SparkLowLevel.MotorType.kBrushless\n\n\n"
        "class Pair:\n    def __init__(self, first: int) -> None:\n"
        "        self.left_motor, self.right_motor = rev.SparkMax(first, SPARK), rev.SparkMax(first + 1, SPARK)\n"
        "        config = rev.SparkMaxConfig()\n        config.encoder.positionConversionFactor(0.1)\n"
        "        for motor in (self.left_motor, self.right_motor):\n            motor.configure(\n"
        "                config, rev.ResetMode.kResetSafeParameters, rev.PersistMode.kPersistParameters)\n\n\n"
        "class Robot(wpilib.TimedRobot):\n    def robotInit(self) -> None:\n"
        "        self.lift, self.drive_base = Pair(1), Pair(3)\n"
    )
    said, text = init(run)
    assert "tank drive: sides of names of motors" in said and "drive_gearing 10 " in said, said
    assert "left = [3]" in text and "right = [4]" in text


def test_modules_with_cached_readings_are_found(own):
    """Logging and input layers cache readings; modules that read no sensor in simulation are reported by name."""
    run, sentence = own(SWERVE), " report the same positions whatever their sensors read"
    asked = "        return SwerveModulePosition(self.drive.getEncoder().getPosition(), self.angle())\n"
    said, table = init(run)
    assert sentence not in said
    keeps = "        return getattr(self, 'last', SwerveModulePosition())\n\n    def periodic(self) -> None:\n"
    for text, is_told in ((keeps + asked.replace("return", "self.last ="), False), (keeps + "        pass\n", True)):
        (run.folder / "robot.py").write_text(_with(SWERVE, (asked, text)))
        (run.folder / "simcore.toml").unlink()
        said, file = init(run)
        assert (sentence in said) is is_told
        assert (file == table) is not is_told


def test_modules_of_an_installed_library_are_found(own, tmp_path):
    library = tmp_path / "robot" / "site-packages"
    head, rest = SWERVE.split("class Module:")
    body, program = rest.split("class Robot(")
    place = f"import sys\n\nsys.path.insert(0, {str(library)!r})\nfrom shared_modules import Module\n"
    run = own(f"{head}{place}\n\nclass Robot({program}")
    library.mkdir()
    (library / "shared_modules.py").write_text(f"{head}class Module:{body}")
    said, _ = init(run)
    assert "swerve drive: 4 modules (Module)" in said, said


def test_the_page_which_robots_equals_the_output_of_its_script(tmp_path, python):
    """`scripts/write_which_robots.py` updates the page."""
    for module in (*NEEDS, "navx"):
        pytest.importorskip(module)
    made = tmp_path / "page.md"
    program = (
        "import runpy, pathlib, sys; m = runpy.run_path('scripts/write_which_robots.py'); "
        "pathlib.Path(sys.argv[1]).write_text(m['text'](), 'utf-8')"
    )
    code, said = python(PACKAGES, "-c", program, str(made))
    assert code == 0, said
    assert made.read_text(encoding="utf-8") == (PACKAGES / "docs" / "which_robots.md").read_text(encoding="utf-8")
