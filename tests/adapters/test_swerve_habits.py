"""Swerve programs with module classes of their own: modules, zeros and places are found, or requested in a message."""

from __future__ import annotations

import json

import pytest

pytestmark = pytest.mark.slow

DRIVES = """
import math

def test_it_drives_straight_and_turns(sim):
    pad = sim.xbox(0)
    sim.teleop(seconds=0.4)
    before = sim.pose
    pad.left_y = -0.5
    sim.run(1.2)
    way = sim.pose.relativeTo(before)
    pad.left_y = 0.0
    sim.run(0.5)
    assert way.X() > 0.7 and abs(way.Y()) < 0.15, way
    pad.right_x = -0.6
    sim.run(1.0)
    assert (sim.pose.rotation() - before.rotation()).degrees() > 20.0
"""
HEAD = """
import math
import rev, wpilib
from phoenix6 import hardware
from wpimath.controller import PIDController
from wpimath.geometry import Rotation2d, Translation2d
from wpimath.kinematics import ChassisSpeeds, SwerveDrive4Kinematics, SwerveModulePosition, SwerveModuleState
OFFSETS = (0.31, -0.12, 0.44, -0.27)
METERS = 0.1016 * math.pi / 6.75
def spark(number):
    return rev.SparkMax(number, rev.SparkLowLevel.MotorType.kBrushless)
class Module:
    def __init__(self, k):
        self.drive_motor, self.turn_motor, self.azimuth = spark(2 * k + 1), spark(2 * k + 2), hardware.CANcoder(20 + k)
        self.offset = OFFSETS[k]
        self.loop = PIDController(8.0, 0, 0)
        self.loop.enableContinuousInput(-math.pi, math.pi)
    def turns(self):
        return self.azimuth.get_absolute_position().value - self.offset
    def go(self, state):
        angle = Rotation2d.fromRotations(self.turns())
        state.optimize(angle)
        self.turn_motor.setVoltage(self.loop.calculate(angle.radians(), state.angle.radians()))
        self.drive_motor.setVoltage(2.6 * state.speed)
"""
ROBOT = """
class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.modules = [Module(k) for k in range(4)]
        self.gyro, self.pad = wpilib.ADXRS450_Gyro(), wpilib.XboxController(0)
    def teleopPeriodic(self):
        pad = self.pad
        speeds = ChassisSpeeds(-2 * pad.getLeftY(), -2 * pad.getLeftX(), -4 * pad.getRightX())
        for module, state in zip(self.modules, to_states(speeds)):
            module.go(state)
"""
KINEMATICS = """
KIN = SwerveDrive4Kinematics(*(Translation2d(x, y) for x in (0.29, -0.29) for y in (0.29, -0.29)))
def to_states(speeds):
    return KIN.toSwerveModuleStates(speeds)
"""
BY_HAND = """
def to_states(speeds):
    at = [(x, y) for x in (0.29, -0.29) for y in (0.29, -0.29)]
    parts = [(speeds.vx - speeds.omega * y, speeds.vy + speeds.omega * x) for x, y in at]
    return [SwerveModuleState(math.hypot(x, y), Rotation2d(x, y) if x or y else Rotation2d()) for x, y in parts]
"""
LAYERS = (
    """
class Wrapper:
    def __init__(self, number):
        self.real = {"controller": spark(number)}
class Hardware:
    def __init__(self, k):
        self.drive, self.turn, self.azimuth = Wrapper(2 * k + 1), Wrapper(2 * k + 2), hardware.CANcoder(20 + k)
class IO:
    def __init__(self, k):
        self.hardware = Hardware(k)
class Inputs:
    distance, turns = 0.0, 0.0
class Simulated:
    def __init__(self, k):
        self.drive, self.turn = wpilib.PWMVictorSPX(2 * k), wpilib.PWMVictorSPX(2 * k + 1)
class Module(Module):
    def __init__(self, k):
        self.io, self.inputs, self.offset = IO(k), Inputs(), OFFSETS[k]
        self.loop = PIDController(8.0, 0, 0)
        self.loop.enableContinuousInput(-math.pi, math.pi)
    def turns(self):
        return self.inputs.turns
    def get_position(self):
        return SwerveModulePosition(self.inputs.distance, Rotation2d.fromRotations(self.turns()))
    def go(self, state):
        angle, part = Rotation2d.fromRotations(self.turns()), self.io.hardware
        state.optimize(angle)
        part.turn.real["controller"].setVoltage(self.loop.calculate(angle.radians(), state.angle.radians()))
        part.drive.real["controller"].setVoltage(2.6 * state.speed)
"""
    + ROBOT
    + """
class Robot(Robot):
    def robotInit(self):
        super().robotInit()
        self.simulated = [Simulated(k) for k in range(4)]
    def robotPeriodic(self):
        for m in self.modules:  # no method of a module reads its sensors
            part = m.io.hardware
            m.inputs.turns = part.azimuth.get_absolute_position().value - m.offset
            m.inputs.distance = METERS * part.drive.real["controller"].getEncoder().getPosition()
"""
)
FLAT = """
class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.drive_motors, self.turn_motors = [spark(2 * k + 1) for k in range(4)], [spark(2 * k + 2) for k in range(4)]
        self.encoders = [hardware.CANcoder(20 + k) for k in range(4)]
        self.loops = [PIDController(8.0, 0, 0) for _ in range(4)]
        for loop in self.loops:
            loop.enableContinuousInput(-math.pi, math.pi)
        self.gyro, self.pad = wpilib.ADXRS450_Gyro(), wpilib.XboxController(0)
    def get_module_positions(self):
        return [
            SwerveModulePosition(METERS * d.getEncoder().getPosition(), self.angle(k))
            for k, d in enumerate(self.drive_motors)
        ]
    def angle(self, k):
        return Rotation2d.fromRotations(self.encoders[k].get_absolute_position().value - OFFSETS[k])
    def teleopPeriodic(self):
        pad = self.pad
        states = to_states(ChassisSpeeds(-2 * pad.getLeftY(), -2 * pad.getLeftX(), -4 * pad.getRightX()))
        for k, state in enumerate(states):
            state.optimize(self.angle(k))
            self.turn_motors[k].setVoltage(self.loops[k].calculate(self.angle(k).radians(), state.angle.radians()))
            self.drive_motors[k].setVoltage(2.6 * state.speed)
"""
GLOBALS = """
fl_drive, fr_drive, bl_drive, br_drive = drives = [spark(2 * k + 1) for k in range(4)]
fl_turn, fr_turn, bl_turn, br_turn = turns = [spark(2 * k + 2) for k in range(4)]
fl_coder, fr_coder, bl_coder, br_coder = coders = [hardware.CANcoder(20 + k) for k in range(4)]
loops, gyro = [PIDController(8.0, 0, 0) for _ in range(4)], wpilib.ADXRS450_Gyro()
def angle(k):
    return Rotation2d.fromRotations(coders[k].get_absolute_position().value - OFFSETS[k])
def positions():
    return [SwerveModulePosition(METERS * d.getEncoder().getPosition(), angle(k)) for k, d in enumerate(drives)]
class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.pad = wpilib.XboxController(0)
        for loop in loops:
            loop.enableContinuousInput(-math.pi, math.pi)
    def teleopPeriodic(self):
        pad = self.pad
        states = to_states(ChassisSpeeds(-2 * pad.getLeftY(), -2 * pad.getLeftX(), -4 * pad.getRightX()))
        for k, state in enumerate(states):
            state.optimize(angle(k))
            turns[k].setVoltage(loops[k].calculate(angle(k).radians(), state.angle.radians()))
            drives[k].setVoltage(2.6 * state.speed)
"""
ROTATION = """
class Module(Module):
    def get_angle(self):
        return Rotation2d.fromRotations(self.turns())
"""
DEGREES = """
class Module(Module):
    def getAngleDegrees(self):
        return 360.0 * self.turns()
"""
NAMED = ROBOT.replace(
    "self.modules = [", "self.rr, self.lf, self.rf, self.lr = (Module(k) for k in (3, 0, 1, 2))\n        #"
).replace("self.modules, to", "(self.lf, self.rf, self.lr, self.rr), to")
CHOREO = {
    "config": {
        corner: {"x": {"val": x}, "y": {"val": 0.25}} for corner, x in (("frontLeft", 0.31), ("backLeft", -0.31))
    }
}
HABITS = {
    "sensors cached by the robot's loop, five objects deep, a simulation next to it": (LAYERS, None, ()),
    "angle as Rotation2d, offset in code": (ROTATION + ROBOT, None, ()),
    "angle as a number of degrees": (DEGREES + ROBOT, None, ()),
    "offsets in code alone": (ROBOT, None, ("zeros_deg -111.6, 43.2, -158.4, 97.2 (reading minus offset)",)),
    "lf, lr, rr, rf": (ROTATION + NAMED, None, ()),
    "lists of motors in the robot": (FLAT, None, ()),
    "globals and functions of a module": (GLOBALS, None, ()),
    "no kinematics, Choreo's places": (BY_HAND + ROTATION + ROBOT, CHOREO, ()),
    "no kinematics, no places": (
        BY_HAND + ROTATION + ROBOT, None, ("correct x = [0.28, 0.28, -0.28, -0.28]",),
    ),
    "no gyro": (ROTATION + ROBOT.replace("wpilib.ADXRS450_Gyro()", "None"), None, ("no gyro",)),
}  # fmt: skip
"""Programs by habit: text after `HEAD`, Choreo file, and expected messages of the start."""


@pytest.mark.parametrize("habit", HABITS)
def test_swerve_modules_of_a_teams_own_classes_follow_their_commands(habit, tmp_path, project_of):
    text, choreo, sentences = HABITS[habit]
    source = tmp_path / "source"
    source.mkdir()
    (source / "robot.py").write_text(HEAD + (text if text.startswith(BY_HAND) else KINEMATICS + text))
    if choreo is not None:
        (source / "deploy" / "choreo").mkdir(parents=True)
        (source / "deploy" / "choreo" / "paths.chor").write_text(json.dumps(choreo))
    run = project_of(source)
    code, said = run(DRIVES, "-rP")
    assert code == 0, said
    plain = " ".join(said.split())
    for sentence in sentences:
        assert sentence in plain, said
    for quiet in ("zeros_deg", "x and y", "no gyro"):
        assert quiet not in plain or any(quiet in s or "x = [" in s for s in sentences), said
