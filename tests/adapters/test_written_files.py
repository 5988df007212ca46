"""`simcore init` with settings of PathPlanner and Choreo: its file passes `check`, and the program starts."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROBOTS = Path(__file__).parent / "robots"
SIMCORE = ("-m", "simcore")
DRIVES = """
def test_it_drives(sim):
    pad = sim.xbox(0)
    sim.teleop(seconds=0.3)
    before = sim.pose
    pad.left_y = -0.5
    sim.run(1.0)
    assert sim.pose.relativeTo(before).X() > 0.3
"""
HEAD = """
import math
import rev, wpilib
from phoenix6 import hardware
from wpilib.drive import DifferentialDrive, MecanumDrive
from wpimath.controller import PIDController
from wpimath.geometry import Rotation2d, Translation2d
from wpimath.kinematics import (
    ChassisSpeeds, MecanumDriveKinematics, SwerveDrive4Kinematics, SwerveDrive4Odometry, SwerveModulePosition,
)
def spark(number):
    return rev.SparkMax(number, rev.SparkLowLevel.MotorType.kBrushless)
PLACES = [Translation2d(x, y) for x in (0.29, -0.29) for y in (0.29, -0.29)]
METERS = 0.1016 * math.pi / 6.75
"""
SWERVE = """
class Module:
    def __init__(self, k):
        self.drive, self.turn, self.azimuth = spark(2 * k + 1), spark(2 * k + 2), hardware.CANcoder(20 + k)
        self.loop = PIDController(5.0, 0, 0)
        self.loop.enableContinuousInput(-math.pi, math.pi)
    def get_position(self):
        turns = self.azimuth.get_absolute_position().value
        return SwerveModulePosition(METERS * self.drive.getEncoder().getPosition(), Rotation2d.fromRotations(turns))
    def go(self, state):
        angle = self.get_position().angle
        state.optimize(angle)
        self.turn.setVoltage(self.loop.calculate(angle.radians(), state.angle.radians()))
        self.drive.setVoltage(2.6 * state.speed)
class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.kinematics = SwerveDrive4Kinematics(*PLACES)
        self.modules = [Module(k) for k in range(4)]
        self.gyro, self.pad = wpilib.ADXRS450_Gyro(), wpilib.XboxController(0)
    def teleopPeriodic(self):
        speeds = ChassisSpeeds(-2 * self.pad.getLeftY(), -2 * self.pad.getLeftX(), -4 * self.pad.getRightX())
        for module, state in zip(self.modules, self.kinematics.toSwerveModuleStates(speeds)):
            module.go(state)
"""
TANK = """
class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.left, self.right, self.pad = spark(1), spark(2), wpilib.XboxController(0)
        self.right.setInverted(True)
        self.drive, self.gyro = DifferentialDrive(self.left, self.right), wpilib.ADXRS450_Gyro()
    def teleopPeriodic(self):
        self.drive.arcadeDrive(-self.pad.getLeftY(), -self.pad.getRightX(), False)
"""
MECANUM = """
class Robot(wpilib.TimedRobot):
    def robotInit(self):
        motors = [spark(k) for k in (1, 2, 3, 4)]
        motors[2].setInverted(True), motors[3].setInverted(True)
        self.drive, self.pad = MecanumDrive(*motors), wpilib.XboxController(0)
    def teleopPeriodic(self):
        self.drive.driveCartesian(-self.pad.getLeftY(), 0, 0)
"""
PROGRAMS = {
    "swerve": HEAD + SWERVE,
    "CTRE swerve": (ROBOTS / "plain" / "robot.py")
    .read_text(encoding="utf-8")
    .partition("    def _simulationPeriodic")[0],
    "tank": HEAD + TANK,
    "mecanum": HEAD + MECANUM,
}
SIZES = {"robotWidth": 0.8, "robotLength": 0.8, "robotMass": 60.0, "robotMOI": 6.0, "robotTrackwidth": 0.546}
MODULES = {
    f"{corner}Module{axis}": sign * 0.29
    for corner, signs in (("fl", (1, 1)), ("fr", (1, -1)), ("bl", (-1, 1)), ("br", (-1, -1)))
    for axis, sign in zip("XY", signs, strict=True)
}
PATHPLANNER = {
    **{"holonomicMode": True, "driveWheelRadius": 0.0508, "driveGearing": 6.75, "driveMotorType": "NEO"},
    **{"driveCurrentLimit": 40.0, "wheelCOF": 1.1, "maxDriveSpeed": 4.4, **SIZES, **MODULES},
}
CHOREO = {
    "config": {
        **{
            name: {"exp": str(value), "val": value}
            for name, value in (
                *(("mass", 60.0), ("inertia", 6.0), ("gearing", 6.75), ("radius", 0.0508), ("cof", 1.1)),
                ("differentialTrackWidth", 0.56),
            )
        },
        **{corner: {"x": {"val": x}, "y": {"val": 0.29}} for corner, x in (("frontLeft", 0.29), ("backLeft", -0.29))},
    }
}
FILES = {
    "none": {},
    "PathPlanner": {"pathplanner/settings.json": PATHPLANNER},
    "Choreo": {"choreo/paths.chor": CHOREO},
}
SAMPLE = {("swerve", "PathPlanner"), ("CTRE swerve", "Choreo"), ("tank", "PathPlanner"), ("mecanum", "none")}
"""Cases that run without `--whole`."""


@pytest.fixture
def made(tmp_path, project_of):
    """Return a function that makes a project from the text of a program and settings files, copied by `project_of`."""

    def make(text: str, files: dict[str, object]):
        source = tmp_path / "source"
        for name, content in files.items():
            path = source / "deploy" / name
            path.parent.mkdir(parents=True)
            path.write_text(json.dumps(content))
        source.mkdir(exist_ok=True)
        (source / "robot.py").write_text(text)
        if "import measures" in text:
            shutil.copy(ROBOTS / "shared" / "measures.py", source)
        return project_of(source)

    return make


@pytest.mark.parametrize("files", FILES)
@pytest.mark.parametrize("kind", PROGRAMS)
def test_the_file_written_by_init_passes_check_and_the_robot_drives(kind, files, made, whole):
    if (kind, files) not in SAMPLE and not whole:
        pytest.skip("not in the sample: --whole runs all of them")
    run = made(PROGRAMS[kind], FILES[files])
    code, said = run("", "init", command=SIMCORE)
    assert code == 0 and "now: " in said and "Traceback" not in said, said
    written = (run.folder / "simcore.toml").read_text(encoding="utf-8")
    for guess in re.findall(r"^guess: (x and y|\w+)", said, re.MULTILINE):
        key = "x" if guess == "x and y" else guess
        assert re.search(rf"^{key} = .*# guess", written, re.MULTILINE), (guess, written)
    code, said = run("", "check", command=SIMCORE)
    assert code == 0 and "wrong:" not in said, said
    code, said = run(DRIVES)
    assert code == 0, said


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (
            (HEAD + SWERVE).replace("*PLACES", "PLACES[0], *(PLACES[1:2] * 3)"),
            "modules 1, 2 and 3 are at one position in your kinematics",
        ),
        ("import no_such_package", "does not load (ModuleNotFoundError: No module named 'no_such_package')"),
        ((HEAD + SWERVE).replace("range(4)", "range(3)"), "kinematics have 4 swerve modules, but no 4 objects of one"),
    ],
)
def test_init_names_the_fault_of_a_program_and_check_fails_for_it(text, sentence, made):
    run = made(text, {})
    code, said = run("", "init", command=SIMCORE)
    assert sentence in said and code == (0 if "no 4 objects" in sentence else 1), said
    code, said = run("", "check", command=SIMCORE)
    assert code == 1 and "RobotConfig" not in said, said
