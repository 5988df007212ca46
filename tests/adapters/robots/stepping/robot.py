"""A TimedRobot that derives its drivetrain and steps CTRE's own simulation from the robot loop."""

import importlib.util
from pathlib import Path

import wpilib
from phoenix6 import hardware, swerve
from phoenix6.swerve import requests

_spec = importlib.util.spec_from_file_location("measures", Path(__file__).with_name("measures.py"))
measures = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(measures)


class Drive(swerve.SwerveDrivetrain):
    pass


class Robot(wpilib.TimedRobot):
    own_hook = 0

    def robotInit(self) -> None:
        constants = swerve.SwerveDrivetrainConstants().with_can_bus_name("").with_pigeon2_id(9)
        self.swerve = Drive(hardware.TalonFX, hardware.TalonFX, hardware.CANcoder, constants, measures.modules())
        self.request = (
            requests.RobotCentric()
            .with_velocity_y(2.0)
            .with_drive_request_type(swerve.SwerveModule.DriveRequestType.VELOCITY)
        )

    def teleopPeriodic(self) -> None:
        self.swerve.set_control(self.request)

    def _simulationPeriodic(self) -> None:
        Robot.own_hook += 1
        self.swerve.update_sim_state(0.02, 12.0)
