"""A TimedRobot of 10 ms loops with a physics.py of its own; two Notifiers at 200 Hz, one that steps CTRE's simulation
and one that runs a profile; numbers from the unseeded `random` and numpy; the time of day in its log."""

import random
import threading
import time

import measures
import numpy
import wpilib
from phoenix6 import controls, swerve
from phoenix6.swerve import SwerveModule, requests
from wpimath.geometry import Pose2d


class Drivetrain(swerve.SwerveDrivetrain):
    def __init__(self, drive, steer, encoder, constants, arg0=None, arg1=None, arg2=None, arg3=None) -> None:
        super().__init__(drive, steer, encoder, constants, arg0, arg1, arg2, arg3)
        self.lock = threading.Lock()
        self.stepper = wpilib.Notifier(self.step)
        self.stepper.startPeriodic(0.005)

    def step(self) -> None:
        with self.lock:
            self.update_sim_state(0.005, wpilib.RobotController.getBatteryVoltage())


class Robot(wpilib.TimedRobot):
    def __init__(self) -> None:
        super().__init__(0.01)
        self.drivetrain = measures.build(Drivetrain, inverted_steer=True, coupling=3.57)
        self.pad = wpilib.XboxController(0)
        self.intake = measures.talon(40, ratio=4.0, k_v=0.5)
        self.elevator = measures.talon(41, ratio=10.0, k_p=40.0, k_g=0.3)
        self.request = requests.RobotCentric().with_drive_request_type(SwerveModule.DriveRequestType.VELOCITY)
        self.offset = float(numpy.random.normal(0.0, 0.02))  # noqa: NPY002
        self.goal = 0.0
        self.height = 0.0
        self.profile = wpilib.Notifier(self.follow)
        self.profile.startPeriodic(0.005)
        self.addPeriodic(self.log, 0.05, 0.001)

    def follow(self) -> None:
        self.height += max(-0.01, min(0.01, self.goal - self.height))
        self.elevator.set_control(controls.PositionVoltage(self.height))

    def log(self) -> None:
        wpilib.SmartDashboard.putNumber("Wall clock", time.time())
        wpilib.SmartDashboard.putNumber("Jitter", random.gauss(0.0, 1.0))

    def autonomousInit(self) -> None:
        self.drivetrain.reset_pose(Pose2d(2.0, 2.0 + self.offset, 0.0))
        self.side = random.choice((-1.0, 1.0))

    def autonomousPeriodic(self) -> None:
        wobble = random.uniform(-0.1, 0.1)
        self.drivetrain.set_control(
            self.request.with_velocity_x(0.5).with_velocity_y(self.side * 0.3 + wobble).with_rotational_rate(0.0)
        )

    def teleopPeriodic(self) -> None:
        noise = random.uniform(-0.02, 0.02) + float(numpy.random.uniform(-0.02, 0.02))  # noqa: NPY002
        self.drivetrain.set_control(
            self.request.with_velocity_x(-3.5 * self.pad.getLeftY())
            .with_velocity_y(-3.5 * self.pad.getLeftX() + noise)
            .with_rotational_rate(-3.5 * self.pad.getRightX())
        )
        self.goal = 2.0 if self.pad.getYButton() else 0.0
        self.intake.set_control(controls.VoltageOut(6.0 if self.pad.getAButton() else 0.0))

    def facts(self) -> dict:
        return {
            "intake_rps": self.intake.get_velocity().value,
            "height": self.elevator.get_position().value,
        }
