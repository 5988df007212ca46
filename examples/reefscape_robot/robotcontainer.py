"""Subsystems, controls and autos."""

import commands2
from commands.coral import CoralCommands
from commands2.button import CommandXboxController
from constants import MAX_SPEED, MAX_TURN, START_BLUE, for_alliance, nearest_branch
from generated.tuner_constants import TunerConstants
from phoenix6.swerve import requests
from subsystems.arm import Arm
from subsystems.claw import Claw, Funnel
from subsystems.climber import Climber
from subsystems.elevator import Elevator
from subsystems.vision import Vision
from wpilib import DriverStation, SendableChooser, SmartDashboard

ROUND_THE_REEF = (4.6, 5.9)
PAST_THE_MARK = (2.3, 6.7)  # so that the coral and algae in front of the station stay there


class RobotContainer:
    """Everything that the robot is made of."""

    def __init__(self) -> None:
        self.drivetrain = TunerConstants.create_drivetrain()
        self.elevator = Elevator()
        self.arm = Arm()
        self.claw = Claw()
        self.funnel = Funnel()
        self.climber = Climber()
        self.vision = Vision(self.drivetrain)
        self.coral = CoralCommands(self.drivetrain, self.elevator, self.arm, self.claw, self.funnel)
        self.level = 4
        self._bind()
        self._autos = SendableChooser()
        self._autos.setDefaultOption("two coral", self._two_coral())
        self._autos.addOption("nothing", commands2.cmd.none())
        SmartDashboard.putData("Auto", self._autos)

    def _bind(self) -> None:
        pad = CommandXboxController(0)
        drive = requests.FieldCentric().with_deadband(0.05 * MAX_SPEED).with_rotational_deadband(0.05 * MAX_TURN)
        self.drivetrain.setDefaultCommand(
            self.drivetrain.apply_request(
                lambda: (
                    drive.with_velocity_x(-pad.getLeftY() * MAX_SPEED)
                    .with_velocity_y(-pad.getLeftX() * MAX_SPEED)
                    .with_rotational_rate(-pad.getRightX() * MAX_TURN)
                )
            )
        )
        pad.a().toggleOnTrue(self.coral.take())  # M
        pad.b().onTrue(self.coral.let_go())  # comma
        pad.x().whileTrue(self._score_on("left"))  # period
        pad.y().whileTrue(self._score_on("right"))  # slash
        pad.leftBumper().onTrue(commands2.cmd.runOnce(self._next_level))  # N
        pad.povUp().whileTrue(self.climber.run(lambda: self.climber.pull(10.0)))  # arrow up
        pad.povDown().whileTrue(self.climber.run(lambda: self.climber.pull(-12.0)))  # arrow down
        pad.start().onTrue(self.drivetrain.runOnce(self.drivetrain.seed_field_centric))

    def _score_on(self, side: str) -> commands2.Command:
        """On the left or right branch of the nearest face, as seen from there; stop it and the arm is tucked in."""
        chosen = ""

        def choose() -> None:
            nonlocal chosen
            chosen = nearest_branch(for_alliance(self.drivetrain.get_state().pose, is_red()), side)

        score = commands2.cmd.runOnce(choose).andThen(self.coral.score(lambda: chosen, lambda: self.level))
        return score.finallyDo(lambda interrupted: self.coral.tuck().schedule() if interrupted else None)

    def _next_level(self) -> None:
        self.level = self.level - 1 if self.level > 2 else 4

    def seed_pose(self) -> None:
        """Odometry begins where the drive team puts the robot."""
        self.drivetrain.reset_pose(for_alliance(START_BLUE, is_red()))

    def autonomous_command(self) -> commands2.Command | None:
        return self._autos.getSelected()

    def _two_coral(self) -> commands2.Command:
        """The preload on J, one from the left station on L, both on level 4."""
        return commands2.cmd.sequence(
            self.coral.take(),  # the preload is in the funnel
            self.coral.score(lambda: "J", lambda: 4),
            self.coral.fetch(past=(ROUND_THE_REEF,)),
            self.coral.score(lambda: "L", lambda: 4, past=(PAST_THE_MARK,)),
        )

    def publish(self) -> None:
        """What drivers and tests look at."""
        pose = self.drivetrain.get_state().pose
        SmartDashboard.putNumberArray("Odometry", [pose.X(), pose.Y(), pose.rotation().degrees()])
        SmartDashboard.putNumber("Level", self.level)
        SmartDashboard.putNumber("Elevator m", self.elevator.height)
        SmartDashboard.putNumber("Arm deg", self.arm.angle_deg)
        SmartDashboard.putBoolean("Coral", self.claw.has_coral)


def is_red() -> bool:
    """Whether the driver station says so."""
    return DriverStation.getAlliance() == DriverStation.Alliance.kRed
