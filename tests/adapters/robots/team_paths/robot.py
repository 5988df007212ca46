"""A command-based robot that reads its deploy folder: PathPlanner's settings, paths and autos, and a file of its own;
autos reset odometry to the drawn pose, turned for red. A feeder of three motors, and wheels that coast."""

import json
from pathlib import Path

import commands2
import wpilib
from commands2 import cmd
from commands2.button import CommandXboxController
from pathplannerlib.auto import AutoBuilder, NamedCommands, PathPlannerAuto
from phoenix6.swerve import requests
from subsystems.mechanisms import Feeder, Intake, Wheels
from subsystems.swerve import Swerve

TUNING = json.loads((Path(wpilib.getDeployDirectory()) / "tuning.json").read_text())


class RobotContainer:
    def __init__(self) -> None:
        self.pad = CommandXboxController(0)
        self.swerve = Swerve()
        self.intake = Intake(TUNING["intake_volts"])
        self.feeder = Feeder()
        self.wheels = Wheels(**TUNING["shot"])
        drive = requests.FieldCentric().with_deadband(0.2).with_rotational_deadband(0.2)
        self.swerve.setDefaultCommand(
            self.swerve.run(
                lambda: self.swerve.set_control(
                    drive.with_velocity_x(-4.0 * self.pad.getLeftY())
                    .with_velocity_y(-4.0 * self.pad.getLeftX())
                    .with_rotational_rate(-4.0 * self.pad.getRightX())
                )
            )
        )
        self.pad.a().whileTrue(self.intake.take_in())
        self.pad.x().whileTrue(self.shoot())
        NamedCommands.registerCommand("take in", cmd.runOnce(self.intake.start, self.intake))
        NamedCommands.registerCommand("stow", cmd.runOnce(self.intake.stop, self.intake))
        NamedCommands.registerCommand("shoot", self.shoot())
        NamedCommands.registerCommand("stop", cmd.runOnce(self.wheels.stop, self.wheels))
        self.chooser = AutoBuilder.buildAutoChooser("depot")
        wpilib.SmartDashboard.putData("Auto", self.chooser)

    def shoot(self) -> commands2.Command:
        feed = cmd.waitUntil(self.wheels.is_ready).andThen(self.feeder.feed())
        return self.wheels.spin().alongWith(feed)


class Robot(commands2.TimedCommandRobot):
    def robotInit(self) -> None:
        wpilib.DataLogManager.start()
        wpilib.DriverStation.startDataLog(wpilib.DataLogManager.getLog())
        self.container = RobotContainer()
        self.auto: PathPlannerAuto | None = None

    def robotPeriodic(self) -> None:
        super().robotPeriodic()
        pose = self.container.swerve.get_state().pose
        wpilib.SmartDashboard.putNumberArray("pose", [pose.X(), pose.Y(), pose.rotation().degrees()])

    def autonomousInit(self) -> None:
        self.auto = self.container.chooser.getSelected()
        self.auto.schedule()

    def teleopInit(self) -> None:
        if self.auto is not None:
            self.auto.cancel()

    def facts(self) -> dict:
        parts = self.container
        motors = {"wheels": parts.wheels.leader, "feeder": parts.feeder.kicker, "roller": parts.intake.roller}
        return {name: motor.get_velocity().value for name, motor in motors.items()}
