"""REV's MAXSwerve modules with a navX, a pose estimator corrected by PhotonVision, and PathPlanner autos."""

import commands2
import wpilib
from commands2 import cmd
from drive import Drive
from mechanisms import Feeder, Intake, Shooter
from pathplannerlib.auto import AutoBuilder, NamedCommands, PathPlannerAuto


class RobotContainer:
    def __init__(self) -> None:
        self.drive = Drive()
        self.intake, self.feeder, self.shooter = Intake(), Feeder(), Shooter()
        shoot = self.shooter.spin().alongWith(cmd.waitUntil(self.shooter.is_ready).andThen(self.feeder.feed()))
        NamedCommands.registerCommand("take in", cmd.runOnce(lambda: self.intake.turn(0.7), self.intake))
        NamedCommands.registerCommand("stow", cmd.runOnce(lambda: self.intake.turn(0.0), self.intake))
        NamedCommands.registerCommand("shoot", shoot)
        NamedCommands.registerCommand("stop", cmd.runOnce(self.shooter.stop, self.shooter))
        self.chooser = AutoBuilder.buildAutoChooser("depot")
        wpilib.SmartDashboard.putData("Auto", self.chooser)


class Robot(commands2.TimedCommandRobot):
    def robotInit(self) -> None:
        self.container = RobotContainer()
        self.auto: PathPlannerAuto | None = None

    def _simulationPeriodic(self) -> None:
        self.container.drive.vision.simulate(self.container.drive.get_pose())

    def autonomousInit(self) -> None:
        self.auto = self.container.chooser.getSelected()
        self.auto.schedule()

    def teleopInit(self) -> None:
        if self.auto is not None:
            self.auto.cancel()
