"""Vision: two Limelights tell odometry where the robot stands (MegaTag 2), so that it scores on the branch."""

import math

import ntcore
from commands2 import Subsystem
from constants import TAG_CAMERAS
from phoenix6 import utils
from wpilib import SmartDashboard
from wpimath.geometry import Pose2d, Rotation2d

from subsystems.command_swerve_drivetrain import CommandSwerveDrivetrain

FASTEST_SPIN = 180.0  # deg/s; beyond, the heading that the camera was told is too old for its frame
FARTHEST = 4.0  # m; a tag is few pixels then
BEST, TRUST = 0.01, 0.015  # m of standard deviation: at least, and per m^2 of distance to one tag
NEVER = 9999999.0  # MegaTag 2 hands back the heading it was told: nothing to learn from it
TAGS, DISTANCE, HEAD = 7, 9, 11  # places in botpose; what comes after its head is 7 numbers a tag


class Vision(Subsystem):
    """Tells the cameras which way the robot looks, and odometry what they saw."""

    def __init__(self, drivetrain: CommandSwerveDrivetrain) -> None:
        super().__init__()
        self._drivetrain = drivetrain
        self._instance = ntcore.NetworkTableInstance.getDefault()
        every = ntcore.PubSubOptions(periodic=0.01, sendAll=True, keepDuplicates=True, pollStorage=20)
        tables = [self._instance.getTable(name) for name in TAG_CAMERAS]
        self._poses = [t.getDoubleArrayTopic("botpose_orb_wpiblue").subscribe([], every) for t in tables]
        self._headings = [t.getDoubleArrayTopic("robot_orientation_set").publish() for t in tables]
        self.accepted = 0

    def periodic(self) -> None:
        heading = self._drivetrain.get_state().pose.rotation().degrees()
        spin = self._drivetrain.pigeon2.get_angular_velocity_z_world().value
        for publisher in self._headings:
            publisher.set([heading, spin, 0.0, 0.0, 0.0, 0.0])
        self._instance.flush()  # each frame wants the heading of its own moment
        for subscriber in self._poses:
            for frame in subscriber.readQueue():
                if abs(spin) < FASTEST_SPIN:
                    self._add(frame.value, frame.time * 1e-6)
        SmartDashboard.putNumber("Vision accepted", self.accepted)

    def _add(self, botpose: list[float], time: float) -> None:
        """Hand on what a frame says that came at a time [s]: x, y, z [m], roll, pitch, yaw [deg], latency [ms] ..."""
        if len(botpose) < HEAD or not all(map(math.isfinite, botpose)):
            return
        tags, distance = botpose[TAGS], botpose[DISTANCE]
        if tags < 1 or distance > FARTHEST:
            return
        sigma = max(BEST, TRUST * distance**2 / tags)
        pose = Pose2d(botpose[0], botpose[1], Rotation2d.fromDegrees(botpose[5]))
        taken = utils.fpga_to_current_time(time - botpose[6] / 1000)  # Phoenix has a clock of its own
        self._drivetrain.add_vision_measurement(pose, taken, (sigma, sigma, NEVER))
        self.accepted += 1
