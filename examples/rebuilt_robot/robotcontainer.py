"""Subsystems, controls and autos."""

import commands2
from commands.collect import Collect
from commands.drive_to import DriveTo
from commands.shoot import Shoot
from commands2.button import CommandXboxController
from constants import DEPOT_BLUE, MAX_SPEED, MAX_TURN, START_BLUE, for_alliance, shooter_rps
from generated.tuner_constants import TunerConstants
from path_autos import load_autos
from phoenix6.swerve import requests
from subsystems.indexer import Feeder, Spindexer
from subsystems.intake import Intake
from subsystems.shooter import Hood, Shooter
from subsystems.vision import Vision
from wpilib import DriverStation, SendableChooser, SmartDashboard
from wpimath.filter import SlewRateLimiter
from wpimath.geometry import Pose2d, Rotation2d


class RobotContainer:
    """Everything that the robot is made of."""

    def __init__(self) -> None:
        self.drivetrain = TunerConstants.create_drivetrain()
        self.intake = Intake()
        self.spindexer = Spindexer()
        self.feeder = Feeder()
        self.shooter = Shooter()
        self.hood = Hood()
        self.vision = Vision(self.drivetrain)
        self.is_seeded = False
        self._seeded_for: DriverStation.Alliance | None = None
        self._bind()
        self._autos = SendableChooser()
        self._autos.setDefaultOption("depot", self._depot())
        self._autos.addOption("preload", self.shoot().withTimeout(4.0))
        for name, auto in load_autos(self.drivetrain, self._named_commands()).items():
            self._autos.addOption(f"{name} (PathPlanner)", auto)
        self._autos.addOption("nothing", commands2.cmd.none())
        SmartDashboard.putData("Auto", self._autos)

    def _bind(self) -> None:
        pad = CommandXboxController(0)
        drive = requests.FieldCentric().with_deadband(0.05 * MAX_SPEED).with_rotational_deadband(0.05 * MAX_TURN)
        forward, left = SlewRateLimiter(8.0), SlewRateLimiter(8.0)
        self.drivetrain.setDefaultCommand(
            self.drivetrain.apply_request(
                lambda: (
                    drive.with_velocity_x(forward.calculate(-pad.getLeftY() * MAX_SPEED))
                    .with_velocity_y(left.calculate(-pad.getLeftX() * MAX_SPEED))
                    .with_rotational_rate(-pad.getRightX() * MAX_TURN)
                )
            )
        )
        pad.a().onTrue(self.intake.toggle())  # M
        pad.b().whileTrue(commands2.cmd.run(lambda: self.hood.move_goal(-0.4)))  # comma
        pad.x().whileTrue(commands2.cmd.run(lambda: self.hood.move_goal(0.4)))  # period
        pad.y().whileTrue(self.shoot())  # slash
        pad.leftBumper().whileTrue(Collect(self.drivetrain, self.intake, self.vision))  # N
        pad.start().onTrue(self.drivetrain.runOnce(self.drivetrain.seed_field_centric))

    def shoot(self) -> commands2.Command:
        return Shoot(self.drivetrain, self.shooter, self.hood, self.feeder, self.spindexer)

    def seed_pose(self, alliance: DriverStation.Alliance | None) -> None:
        """Before the match: tell odometry where the drive team put the robot."""
        if alliance is None or self.is_seeded or self._seeded_for == alliance:
            return
        self._seeded_for = alliance
        self.drivetrain.reset_pose(for_alliance(START_BLUE, alliance == DriverStation.Alliance.kRed))

    def autonomous_command(self) -> commands2.Command | None:
        return self._autos.getSelected()

    def _named_commands(self) -> dict[str, commands2.Command]:
        """What autos drawn in PathPlanner may ask for."""
        return {
            "shoot": self.shoot(),
            "spin up": self.shooter.runOnce(lambda: self.shooter.set_speed(shooter_rps(2.5))),
            "intake out": self.intake.runOnce(lambda: self.intake.set_out(True)),
            "intake in": self.intake.runOnce(lambda: self.intake.set_out(False)),
        }

    def _depot(self) -> commands2.Command:
        """Shoot the preload, back into the depot with the intake out, come back and shoot."""
        x, y = DEPOT_BLUE.X(), DEPOT_BLUE.Y()

        def to(px: float, py: float, yaw: float, speed: float, timeout: float) -> commands2.Command:
            return DriveTo(self.drivetrain, Pose2d(px, py, Rotation2d(yaw)), speed=speed).withTimeout(timeout)

        return commands2.cmd.sequence(
            self.shoot().withTimeout(2.8),
            self.intake.out(),
            to(x + 1.4, y, 0.0, 3.0, 2.5),
            to(x + 0.55, y, 0.0, 1.2, 1.6),
            to(x + 0.62, y + 0.25, 0.0, 0.8, 1.0),
            to(x + 0.62, y - 0.25, 0.0, 0.8, 1.2),
            to(x + 0.55, y, 0.0, 0.8, 0.8),
            to(2.4, 5.2, -0.4, 3.0, 2.5),
            self.shoot().withTimeout(6.0),
        )

    def publish(self) -> None:
        pose = self.drivetrain.get_state().pose
        SmartDashboard.putNumberArray("Odometry", [pose.X(), pose.Y(), pose.rotation().degrees()])
        SmartDashboard.putNumber("Shooter rps", self.shooter.speed_rps)
        SmartDashboard.putNumber("Hood deg", self.hood.angle_deg)
