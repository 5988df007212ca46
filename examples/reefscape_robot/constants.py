"""Numbers of this robot and of the field, blue origin, meters and degrees."""

from dataclasses import dataclass
from math import cos, radians, sin

from wpimath.geometry import Pose2d, Rotation2d, Translation2d

FIELD_LENGTH, FIELD_WIDTH = 17.548, 8.052
REEF_BLUE = Translation2d(4.489, 4.026)
BRANCHES = "ABCDEFGHIJKL"  # counter-clockwise from the face to the alliance wall, two a face
BRANCH_OFFSET = 0.1643  # from the middle of a face
STATION_BLUE = Pose2d(0.851, 7.397, Rotation2d.fromDegrees(-54))  # left one: its middle and the way out of it
START_BLUE = Pose2d(7.2, 5.9, Rotation2d.fromDegrees(-120))

TAG_CAMERAS = ("limelight-left", "limelight-right")

MAX_SPEED = 4.0  # m/s
MAX_TURN = 6.0  # rad/s

STANDOFF = 0.35  # m before the place where it scores: there the elevator goes up
STATION_GAP = 0.46  # m from the station to the middle of the robot


class Ids:
    """CAN ids; the drivetrain's are in the generated constants."""

    ELEVATOR = 20
    ELEVATOR_FOLLOWER = 21
    ARM = 22  # the motor and its CANcoder
    CLAW = 23  # the motor and its CANrange
    FUNNEL = 24
    CLIMBER = 25
    CLIMBER_FOLLOWER = 26


@dataclass(frozen=True)
class Level:
    """How to put a coral on a branch; measured on the practice field."""

    distance: float
    """Of the robot's middle from that of the reef."""
    height: float
    """Of the elevator."""
    arm_deg: float
    """Above the horizontal."""
    rise: float = 0.0
    """Of the elevator for each meter that is left to drive: the coral comes to a slanted branch along it."""


LEVELS = {
    4: Level(distance=1.278, height=1.813, arm_deg=-35.0),
    3: Level(distance=1.309, height=0.573, arm_deg=20.0, rise=0.7),
    2: Level(distance=1.309, height=0.173, arm_deg=20.0, rise=0.7),
}
CARRY_HEIGHT, TUCKED_DEG = 0.0, 85.0  # there the funnel hands over, and so it drives


def for_alliance(pose: Pose2d, is_red: bool) -> Pose2d:
    """A blue pose as the red alliance sees it: turned by 180 degrees about the middle of the field."""
    if not is_red:
        return pose
    turned = pose.rotation() + Rotation2d.fromDegrees(180)
    return Pose2d(FIELD_LENGTH - pose.X(), FIELD_WIDTH - pose.Y(), turned)


def branch_pose(branch: str, distance: float) -> Pose2d:
    """Where a blue robot stands in front of a branch, so far from the middle of the reef."""
    number = BRANCHES.index(branch)
    yaw = radians(180 + 60 * (number // 2))  # out of the face
    aside = BRANCH_OFFSET if number % 2 else -BRANCH_OFFSET
    x = REEF_BLUE.X() + distance * cos(yaw) - aside * sin(yaw)
    y = REEF_BLUE.Y() + distance * sin(yaw) + aside * cos(yaw)
    return Pose2d(x, y, Rotation2d(yaw).rotateBy(Rotation2d.fromDegrees(180)))


def nearest_branch(pose: Pose2d, side: str) -> str:
    """The left or right branch of the face that is nearest to a blue robot."""
    branches = BRANCHES[0 if side == "left" else 1 :: 2]
    return min(branches, key=lambda b: branch_pose(b, 1.3).translation().distance(pose.translation()))


def station_pose(gap: float) -> Pose2d:
    """Where a blue robot stands with its back to the left station, so far away."""
    return Pose2d(STATION_BLUE.translation() + Translation2d(gap, STATION_BLUE.rotation()), STATION_BLUE.rotation())
