"""Drive to a pose, past some places on the way."""

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

from commands2 import Command
from constants import for_alliance
from phoenix6.swerve import SwerveModule, requests
from subsystems.command_swerve_drivetrain import CommandSwerveDrivetrain
from wpilib import DriverStation
from wpimath.geometry import Pose2d, Rotation2d
from wpimath.kinematics import ChassisSpeeds

ACCELERATION, BRAKING = 3.5, 2.2  # m/s^2
NEAR = 4.0  # m/s per m that are left
TURN = 3.0  # rad/s; a faster turn out of a stand makes wheels slip, and odometry with them
PASSED = 0.35  # m


class DriveTo(Command):
    """Ends at the pose; give it a timeout for where something may be in the way."""

    def __init__(
        self,
        drivetrain: CommandSwerveDrivetrain,
        blue: Pose2d | Callable[[], Pose2d],
        *,
        past: Sequence[tuple[float, float]] = (),
        speed: float = 3.5,
        tolerance: float = 0.05,
    ) -> None:
        super().__init__()
        self._drivetrain, self._speed, self._tolerance = drivetrain, speed, tolerance
        self._blue = blue if callable(blue) else lambda: blue
        self._past = [Pose2d(x, y, Rotation2d()) for x, y in past]
        self._request = requests.ApplyFieldSpeeds().with_drive_request_type(SwerveModule.DriveRequestType.VELOCITY)
        self.left = math.inf
        """Distance that is left while it drives [m]."""
        self.addRequirements(drivetrain)

    def initialize(self) -> None:
        is_red = DriverStation.getAlliance() == DriverStation.Alliance.kRed
        self._way = [for_alliance(pose, is_red) for pose in (*self._past, self._blue())]
        self._heading = self._way[-1].rotation()
        speeds = self._drivetrain.get_state().speeds
        self._pace = math.hypot(speeds.vx, speeds.vy)
        self._is_there = False

    def execute(self) -> None:
        pose = self._drivetrain.get_state().pose
        places = [pose.translation(), *(stop.translation() for stop in self._way)]
        if len(self._way) > 1 and places[0].distance(places[1]) < PASSED:
            del self._way[0], places[1]
        self.left = left = math.fsum(a.distance(b) for a, b in pairwise(places))
        turn = math.remainder((self._heading - pose.rotation()).radians(), math.tau)
        self._is_there = left < self._tolerance and abs(turn) < math.radians(1.5)
        self._pace = min(self._pace + 0.02 * ACCELERATION, self._speed, math.sqrt(2 * BRAKING * left), NEAR * left)
        ahead = places[1] - places[0]
        scale = self._pace / max(ahead.norm(), 1e-6)
        rate = min(max(6.0 * turn, -TURN), TURN)
        self._drivetrain.set_control(
            self._request.with_speeds(ChassisSpeeds(ahead.X() * scale, ahead.Y() * scale, rate))
        )

    def isFinished(self) -> bool:
        return self._is_there

    def end(self, interrupted: bool) -> None:
        self.left = math.inf
        self._drivetrain.set_control(self._request.with_speeds(ChassisSpeeds()))
