"""The reader of the cameras and its filters alone, with NetworkTables that the test publishes."""

from dataclasses import replace
from types import SimpleNamespace

import ntcore
import pytest
from constants import FIELD_LENGTH
from subsystems.limelight import AprilTagCamera, PieceCamera, PoseEstimate, parse_botpose
from subsystems.vision import Vision, reason_to_reject, std_devs
from wpilib import Timer
from wpimath.geometry import Pose2d, Rotation2d

GOOD = PoseEstimate(Pose2d(3.0, 4.0, Rotation2d()), time=10.0, tag_count=2, distance=2.0)


def botpose(x=3.0, y=4.0, yaw=90.0, latency=25.0, tags=2, distance=2.0):
    return [x, y, 0.0, 0.0, 0.0, yaw, latency, float(tags), 0.5, distance, 1.0] + [7.0] * 7 * tags


@pytest.fixture
def tables():
    instance = ntcore.NetworkTableInstance.create()
    yield instance
    ntcore.NetworkTableInstance.destroy(instance)


def test_a_botpose_is_taken_apart():
    estimate = parse_botpose(botpose(), timestamp=5.0)
    assert estimate.pose.X() == 3.0 and estimate.pose.Y() == 4.0
    assert estimate.pose.rotation().degrees() == pytest.approx(90.0)
    assert estimate.time == pytest.approx(4.975)
    assert (estimate.tag_count, estimate.distance) == (2, 2.0)


@pytest.mark.parametrize(
    "values",
    [[], [0.0] * 6, botpose(tags=0), botpose()[:-1], [*botpose(), 0.0], botpose(x=float("nan"))],
    ids=["empty", "short", "no tags", "one too few", "one too many", "not a number"],
)
def test_what_is_no_pose_is_none(values):
    assert parse_botpose(values, timestamp=5.0) is None


@pytest.mark.parametrize(
    ("estimate", "spin", "now", "reason"),
    [
        (GOOD, 0.0, 10.05, None),
        (None, 0.0, 10.05, "no tags"),
        (GOOD, -400.0, 10.05, "spins"),
        (GOOD, 0.0, 11.0, "old"),
        (GOOD, 0.0, 9.0, "old"),
        (replace(GOOD, pose=Pose2d(-0.5, 4.0, Rotation2d())), 0.0, 10.05, "off the field"),
        (replace(GOOD, pose=Pose2d(FIELD_LENGTH + 0.5, 4.0, Rotation2d())), 0.0, 10.05, "off the field"),
        (replace(GOOD, tag_count=1, distance=6.0), 0.0, 10.05, "far"),
        (replace(GOOD, tag_count=2, distance=6.0), 0.0, 10.05, None),
    ],
)
def test_reasons(estimate, spin, now, reason):
    assert reason_to_reject(estimate, spin_dps=spin, now=now) == reason


def test_trust_falls_with_the_square_of_the_distance_and_grows_with_tags():
    near, far = std_devs(GOOD), std_devs(replace(GOOD, distance=4.0))
    assert far[0] == far[1] == pytest.approx(4.0 * near[0])
    assert std_devs(replace(GOOD, distance=4.0, tag_count=4))[0] == pytest.approx(far[0] / 2.0)
    assert std_devs(replace(GOOD, distance=0.5))[0] == 0.02
    assert near[2] > 1e6  # never the heading


def test_every_frame_is_read_once_with_its_own_time(tables):
    camera = AprilTagCamera("limelight-two", tables)
    source = tables.getDoubleArrayTopic("/limelight-two/botpose_orb_wpiblue").publish()
    for k, time in enumerate((1.0, 1.02, 1.04)):
        source.set(botpose(x=float(k), tags=k), round(1e6 * time))
    none, one, two = camera.frames()
    assert none is None
    assert (one.pose.X(), one.time) == (1.0, pytest.approx(0.995))
    assert (two.pose.X(), two.time) == (2.0, pytest.approx(1.015))
    assert camera.frames() == []


def test_the_piece_camera_goes_blind_without_a_heartbeat(tables):
    camera = PieceCamera("limelight-one", tables)
    table = tables.getTable("limelight-one")
    assert camera.target(now=1.0) is None
    right = table.getDoubleTopic("tx").publish()
    right.set(-12.5)
    seen, beat = table.getIntegerTopic("tv").publish(), table.getDoubleTopic("hb").publish()
    seen.set(1)
    time = 2.0
    beat.set(7.0, round(1e6 * time))
    assert camera.target(now=2.1).tx_deg == -12.5
    assert camera.target(now=3.0) is None
    seen.set(0)
    assert camera.target(now=2.1) is None


class FakeDrivetrain:
    """At 30 degrees, turning as told; notes what it is given."""

    def __init__(self, spin=0.0):
        reading = lambda value: lambda: SimpleNamespace(value=value)  # noqa: E731
        self.pigeon2 = SimpleNamespace(
            get_angular_velocity_z_world=reading(spin), get_pitch=reading(1.0), get_roll=reading(2.0)
        )
        self.measured = []

    def get_state(self):
        return SimpleNamespace(pose=Pose2d(3.0, 4.0, Rotation2d.fromDegrees(30)))

    def add_vision_measurement(self, pose, time, devs):
        self.measured.append((pose, time, devs))


@pytest.mark.parametrize(("spin", "accepted"), [(10.0, 1), (500.0, 0)])
def test_cameras_hear_the_heading_and_odometry_gets_what_is_fit(tables, spin, accepted):
    drivetrain = FakeDrivetrain(spin)
    vision = Vision(drivetrain, instance=tables)
    heading = tables.getDoubleArrayTopic("/limelight-five/robot_orientation_set").subscribe([])
    source = tables.getDoubleArrayTopic("/limelight-five/botpose_orb_wpiblue").publish()
    source.set(botpose(), int(1e6 * Timer.getFPGATimestamp()))
    source.set(botpose(tags=0), int(1e6 * Timer.getFPGATimestamp()))
    vision.periodic()
    assert heading.get() == pytest.approx([30.0, spin, 1.0, 0.0, 2.0, 0.0])
    assert len(drivetrain.measured) == vision.accepted["limelight-five"] == accepted
    assert vision.rejected["no tags"] == 1
    if accepted:
        pose, _, devs = drivetrain.measured[0]
        assert pose.X() == 3.0 and devs == pytest.approx((0.04, 0.04, 9999999.0))
    else:
        assert vision.rejected["spins"] == 1
