"""Numbers of this robot and of the field, blue origin, meters and degrees."""

from itertools import pairwise

from wpimath.geometry import Pose2d, Rotation2d, Translation2d

FIELD_LENGTH, FIELD_WIDTH = 16.541, 8.069
HUB_BLUE = Translation2d(4.625, 4.0345)
START_BLUE = Pose2d(2.6, 5.3, Rotation2d(-0.5))
DEPOT_BLUE = Translation2d(0.343, 5.963)

TAG_CAMERAS = ("limelight-two", "limelight-five")  # front right, front left
PIECE_CAMERA = "limelight-one"  # at the back, above the intake

MAX_SPEED = 4.0  # m/s
MAX_TURN = 6.0  # rad/s

HOOD_FOR_SHOTS = 42.0  # degrees above the lower stop's horizontal: shots leave at 68 degrees
# distance from hub center to robot center [m], speed of the shooter wheels [rps]; measured on the practice field
SHOTS = ((1.2, 35.7), (1.5, 36.8), (2.0, 40.1), (2.5, 43.7), (3.0, 47.4), (3.5, 50.9), (4.0, 54.4), (5.0, 61.0))


class Ids:
    """CAN ids; the drivetrain's are in the generated constants."""

    DEPLOY = 20
    ROLLER = 21
    SPINDEXER = 22
    FEEDER = 23
    SHOOTER = 24
    SHOOTER_FOLLOWERS = (25, 26, 27)
    HOOD = 28


def shooter_rps(distance: float) -> float:
    """Wheel speed for a shot from so far away, by interpolation."""
    if distance <= SHOTS[0][0]:
        return SHOTS[0][1]
    for (d0, s0), (d1, s1) in pairwise(SHOTS):
        if distance <= d1:
            return s0 + (s1 - s0) * (distance - d0) / (d1 - d0)
    return SHOTS[-1][1]


def for_alliance(pose: Pose2d, is_red: bool) -> Pose2d:
    """A blue pose as the red alliance sees it: turned by 180 degrees about the middle of the field."""
    if not is_red:
        return pose
    turned = pose.rotation() + Rotation2d.fromDegrees(180)
    return Pose2d(FIELD_LENGTH - pose.X(), FIELD_WIDTH - pose.Y(), turned)
