"""Vision: tag cameras correct odometry, a piece camera finds fuel."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import ntcore
from commands2 import Subsystem
from constants import FIELD_LENGTH, FIELD_WIDTH, PIECE_CAMERA, TAG_CAMERAS
from phoenix6 import utils
from wpilib import SmartDashboard, Timer

from subsystems.command_swerve_drivetrain import CommandSwerveDrivetrain
from subsystems.limelight import AprilTagCamera, PieceCamera, PoseEstimate, Target

FASTEST_SPIN = 360.0  # deg/s; beyond, the heading that the camera was told is too old for its frame
OLDEST = 0.5  # s
MARGIN = 0.1  # m; so far beyond the walls an estimate may be by noise
FARTHEST_SINGLE = 5.0  # m; one tag is few pixels then
TRUST = 0.02  # m of standard deviation per m^2 of distance, for one tag
BEST = 0.02  # m
NEVER = 9999999.0  # MegaTag 2 hands back the heading it was told: nothing to learn from it


def reason_to_reject(estimate: PoseEstimate | None, *, spin_dps: float, now: float) -> str | None:
    """Why not to believe an estimate; None if it is fine.

    Args:
        estimate: None for a frame without a pose.
        spin_dps: How fast the robot turns [deg/s].
        now: FPGA time [s].
    """
    if estimate is None:
        return "no tags"
    if abs(spin_dps) > FASTEST_SPIN:
        return "spins"
    if not -0.02 <= now - estimate.time <= OLDEST:
        return "old"
    x, y = estimate.pose.X(), estimate.pose.Y()
    if not (-MARGIN <= x <= FIELD_LENGTH + MARGIN and -MARGIN <= y <= FIELD_WIDTH + MARGIN):
        return "off the field"
    if estimate.tag_count == 1 and estimate.distance > FARTHEST_SINGLE:
        return "far"
    return None


def std_devs(estimate: PoseEstimate) -> tuple[float, float, float]:
    """How far to trust it: x [m], y [m], heading [rad]. The error grows with the square of the distance."""
    sigma = max(BEST, TRUST * estimate.distance**2 / estimate.tag_count)
    return sigma, sigma, NEVER


class Vision(Subsystem):
    """Tells the cameras which way the robot looks, and odometry what they saw."""

    def __init__(
        self,
        drivetrain: CommandSwerveDrivetrain,
        *,
        tag_cameras: Sequence[str] = TAG_CAMERAS,
        piece_camera: str = PIECE_CAMERA,
        instance: ntcore.NetworkTableInstance | None = None,
    ) -> None:
        super().__init__()
        self._drivetrain = drivetrain
        self._instance = instance or ntcore.NetworkTableInstance.getDefault()
        self._cameras = [AprilTagCamera(name, self._instance) for name in tag_cameras]
        self._pieces = PieceCamera(piece_camera, self._instance)
        self.accepted: Counter[str] = Counter()
        self.rejected: Counter[str] = Counter()

    def periodic(self) -> None:
        heading = self._drivetrain.get_state().pose.rotation().degrees()
        gyro = self._drivetrain.pigeon2
        spin = gyro.get_angular_velocity_z_world().value
        pitch, roll = gyro.get_pitch().value, gyro.get_roll().value
        for camera in self._cameras:
            camera.set_orientation(heading, spin, pitch, roll)
        self._instance.flush()  # each frame wants the heading of its own moment
        now = Timer.getFPGATimestamp()
        for camera in self._cameras:
            for estimate in camera.frames():
                self._judge(camera.name, estimate, spin, now)
        SmartDashboard.putNumber("Vision accepted", self.accepted.total())
        SmartDashboard.putString("Vision rejected", ", ".join(f"{n} {why}" for why, n in self.rejected.most_common()))

    def _judge(self, name: str, estimate: PoseEstimate | None, spin: float, now: float) -> None:
        reason = reason_to_reject(estimate, spin_dps=spin, now=now)
        if estimate is None or reason is not None:
            self.rejected[str(reason)] += 1
            return
        time = utils.fpga_to_current_time(estimate.time)  # Phoenix has a clock of its own
        self._drivetrain.add_vision_measurement(estimate.pose, time, std_devs(estimate))
        self.accepted[name] += 1

    def nearest_fuel(self) -> Target | None:
        """What the camera at the intake sees."""
        return self._pieces.target(Timer.getFPGATimestamp())
