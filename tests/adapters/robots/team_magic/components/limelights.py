import ntcore
from phoenix6 import utils
from wpimath.geometry import Pose2d, Rotation2d

from components.swerve import Drivetrain

NAMES = ("limelight-left", "limelight-right")


class Limelights:
    """MegaTag2 as LimelightHelpers do it: heading out, pose in, with its latency."""

    drivetrain: Drivetrain

    def setup(self) -> None:
        inst = ntcore.NetworkTableInstance.getDefault()
        self.orientation = [inst.getDoubleArrayTopic(f"/{n}/robot_orientation_set").publish() for n in NAMES]
        self.poses = [inst.getDoubleArrayTopic(f"/{n}/botpose_orb_wpiblue").subscribe([]) for n in NAMES]
        self.seen = 0

    def execute(self) -> None:
        state = self.drivetrain.phoenix.get_state()
        for publisher, pose in zip(self.orientation, self.poses, strict=True):
            publisher.set([state.pose.rotation().degrees(), 0.0, 0.0, 0.0, 0.0, 0.0])
            for sample in pose.readQueue():
                values = sample.value
                if len(values) < 11 or values[7] < 1 or abs(state.speeds.omega) > 4.0:
                    continue
                self.seen += 1
                when = sample.time / 1e6 - values[6] / 1e3
                told = Pose2d(values[0], values[1], Rotation2d.fromDegrees(values[5]))
                self.drivetrain.phoenix.add_vision_measurement(
                    told, utils.fpga_to_current_time(when), (0.7, 0.7, 9999999.0)
                )
        ntcore.NetworkTableInstance.getDefault().flush()
