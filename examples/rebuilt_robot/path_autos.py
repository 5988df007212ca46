"""Autos drawn in PathPlanner, from deploy/pathplanner. The library is optional: without it the others still run."""

from __future__ import annotations

from collections.abc import Mapping

from commands2 import Command
from phoenix6.swerve import SwerveModule, requests
from subsystems.command_swerve_drivetrain import CommandSwerveDrivetrain
from wpilib import DriverStation, reportWarning

try:
    from pathplannerlib.auto import AutoBuilder, NamedCommands, PathPlannerAuto
    from pathplannerlib.config import PIDConstants, RobotConfig
    from pathplannerlib.controller import PPHolonomicDriveController
    from pathplannerlib.util import DriveFeedforwards
except ImportError as error:
    MISSING: ImportError | None = error
else:
    MISSING = None

AUTOS = ("neutral",)


def load_autos(drivetrain: CommandSwerveDrivetrain, named: Mapping[str, Command]) -> dict[str, Command]:
    """The drawn autos by name; none, and a warning, where the library is missing."""
    if MISSING is not None:
        reportWarning(
            f"no PathPlanner autos ({', '.join(AUTOS)}): {MISSING}. In simulation: pip install robotpy-pathplannerlib; "
            "for the robot: robotpy sync, then robotpy deploy. All other autos are there.",
            False,
        )
        return {}
    _configure(drivetrain)
    for name, command in named.items():
        NamedCommands.registerCommand(name, command)
    return {name: PathPlannerAuto(name) for name in AUTOS}


def _configure(drivetrain: CommandSwerveDrivetrain) -> None:
    request = requests.ApplyRobotSpeeds().with_drive_request_type(SwerveModule.DriveRequestType.VELOCITY)

    def drive(speeds, feedforwards: DriveFeedforwards) -> None:
        drivetrain.set_control(
            request.with_speeds(speeds)
            .with_wheel_force_feedforwards_x(feedforwards.robotRelativeForcesXNewtons)
            .with_wheel_force_feedforwards_y(feedforwards.robotRelativeForcesYNewtons)
        )

    AutoBuilder.configure(
        lambda: drivetrain.get_state().pose,
        drivetrain.reset_pose,
        lambda: drivetrain.get_state().speeds,
        drive,
        PPHolonomicDriveController(PIDConstants(5.0), PIDConstants(5.0)),
        RobotConfig.fromGUISettings(),
        lambda: DriverStation.getAlliance() == DriverStation.Alliance.kRed,  # drawn as the blue alliance sees it
        drivetrain,
    )
