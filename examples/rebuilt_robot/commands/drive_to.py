"""Drive straight to a pose."""

import math

from commands2 import Command
from constants import for_alliance
from phoenix6.swerve import SwerveModule, requests
from subsystems.command_swerve_drivetrain import CommandSwerveDrivetrain
from wpilib import DriverStation
from wpimath.geometry import Pose2d
from wpimath.kinematics import ChassisSpeeds

ACCELERATION = 4.0  # m/s^2


class DriveTo(Command):
    """Ends at the pose; give it a timeout for where something may be in the way."""

    def __init__(
        self, drivetrain: CommandSwerveDrivetrain, blue: Pose2d, *, speed: float = 3.0, tolerance: float = 0.06
    ) -> None:
        super().__init__()
        self._drivetrain, self._blue = drivetrain, blue
        self._speed, self._tolerance = speed, tolerance
        self._request = requests.ApplyFieldSpeeds().with_drive_request_type(SwerveModule.DriveRequestType.VELOCITY)
        self._goal = blue
        self._pace = 0.0
        self._is_there = False
        self.addRequirements(drivetrain)

    def initialize(self) -> None:
        self._goal = for_alliance(self._blue, DriverStation.getAlliance() == DriverStation.Alliance.kRed)
        self._pace = 0.0

    def execute(self) -> None:
        dx, dy, turn = self._error()
        way = math.hypot(dx, dy)
        self._is_there = way < self._tolerance and abs(turn) < math.radians(4.0)
        self._pace = min(self._pace + 0.02 * ACCELERATION, self._speed, math.sqrt(2.0 * 0.6 * ACCELERATION * way))
        scale = self._pace / max(way, 1e-6)
        speeds = ChassisSpeeds(dx * scale, dy * scale, min(max(5.0 * turn, -4.0), 4.0))
        self._drivetrain.set_control(self._request.with_speeds(speeds))

    def isFinished(self) -> bool:
        return self._is_there

    def end(self, interrupted: bool) -> None:
        self._drivetrain.set_control(self._request.with_speeds(ChassisSpeeds()))

    def _error(self) -> tuple[float, float, float]:
        pose = self._drivetrain.get_state().pose
        turn = math.remainder((self._goal.rotation() - pose.rotation()).radians(), math.tau)
        return self._goal.X() - pose.X(), self._goal.Y() - pose.Y(), turn
