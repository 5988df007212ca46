"""A headset measures motion relative to its start, and poses on the field after a reset to its true pose."""

import math

import numpy as np
import pytest
from each_case import each

from simcore.errors import ConfigError
from simcore.vision.camera import CameraMount, camera_pose
from simcore.vision.heading import PoseHistory
from simcore.vision.quest_headset import PoseReset, QuestConfig, QuestHeadset
from simcore.world.rotation import from_rpy, from_yaw, multiply, rotate, rpy, yaw_of

MOUNT = CameraMount(x=-0.2, y=0.15, z=0.6, pitch_deg=10.0, yaw_deg=170.0)
QUIET = {"position_noise": 0.0, "angle_noise_deg": 0.0, "position_drift": 0.0, "yaw_drift_deg": 0.0}
START = ((2.0, 3.0, 0.0), from_yaw(0.4))
END = ((5.0, 1.0, 0.1), from_rpy(0.05, -0.1, 2.0))


def headset(mount: CameraMount | None = MOUNT, **settings: float) -> QuestHeadset:
    return QuestHeadset(QuestConfig(mount=mount, **settings), np.random.default_rng(5))


def drive(quest: QuestHeadset, *poses, seconds: float = 0.1) -> None:
    """Update the headset with the robot at each pose in turn."""
    history = PoseHistory()
    start = 0.0 if quest.last is None else quest.last.time
    for place in poses:
        for k in range(1, round(seconds / 0.02) + 1):
            history.add(start + 0.02 * k, *place)
            quest.update(start + 0.02 * k, history)
        start += seconds


def on_robot(pose, mount: CameraMount = MOUNT):
    return camera_pose(*pose, mount.position, mount.rotation)


def is_same(quat, other) -> bool:
    x, y, z, w = other
    return math.dist(rpy(multiply(quat, (-x, -y, -z, w))), (0.0, 0.0, 0.0)) < 1e-9


def test_poses_before_a_reset_are_relative_to_the_start():
    """E = S^-1 H for the headset's start S and its pose H, both on the field."""
    quest = headset(**QUIET)
    drive(quest, START)
    assert quest.last is not None
    assert quest.last.position == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    drive(quest, END)
    (start, turn), (end, attitude) = on_robot(START), on_robot(END)
    x, y, z, w = turn
    back = (-x, -y, -z, w)
    assert quest.last.position == pytest.approx(rotate(back, [end[k] - start[k] for k in range(3)]))
    assert is_same(quest.last.attitude, multiply(back, attitude))


def test_poses_after_a_reset_to_the_true_pose_are_true():
    quest = headset(**QUIET)
    drive(quest, START)
    quest.reset(PoseReset(*on_robot(START)), *START)
    drive(quest, END)
    place, attitude = on_robot(END)
    assert quest.last.position == pytest.approx(place)
    assert is_same(quest.last.attitude, attitude)


def test_the_first_reset_determines_the_headset_mount():
    quest = headset(None, **QUIET)
    drive(quest, START)
    quest.reset(PoseReset(*on_robot(START)), *START)
    mount = quest.mount
    assert mount is not None
    assert (mount.x, mount.y, mount.z) == pytest.approx((MOUNT.x, MOUNT.y, MOUNT.z))
    assert (mount.roll_deg, mount.pitch_deg) == pytest.approx((0.0, 10.0), abs=1e-9)
    assert mount.yaw_deg == pytest.approx(170.0)
    drive(quest, END)
    assert quest.last.position == pytest.approx(on_robot(END)[0])


def test_an_implausible_reset_determines_no_mount():
    quest = headset(None, **QUIET)
    drive(quest, START)
    quest.reset(PoseReset((9.0, 3.0, 0.5), from_yaw(0.0)), *START)
    assert quest.mount is None and quest.resets == 1
    drive(quest, START)
    assert quest.last.position == pytest.approx((9.0, 3.0, 0.5))


def test_the_noise_has_the_size_in_the_config():
    """The standard deviation of n samples has a relative error of 1 / sqrt(2 n); the limit is four times this error."""
    quest = headset(**{**QUIET, "position_noise": 0.002, "angle_noise_deg": 0.05})
    drive(quest, START)
    quest.reset(PoseReset(*on_robot(START)), *START)
    history, n = PoseHistory(), 1500
    history.add(0.1, *START)
    frames = [frame for k in range(n) for frame in quest.update(0.11 + 0.01 * k, history)]
    assert len(frames) == pytest.approx(n, abs=2)
    assert frames[-1].number - frames[0].number == len(frames) - 1
    error = np.array([frame.position for frame in frames]) - on_robot(START)[0]
    assert error.std(axis=0) == pytest.approx([0.002] * 3, rel=4.0 / math.sqrt(2.0 * n))
    yaw = np.array([math.remainder(yaw_of(f.attitude) - yaw_of(on_robot(START)[1]), math.tau) for f in frames])
    # 10 degrees of pitch turn a part of the roll's noise into yaw: 1 / cos at most.
    assert np.degrees(yaw).std() == pytest.approx(0.05, rel=4.0 / math.sqrt(2.0 * n) + 0.02)


def test_the_drift_after_a_match_has_the_size_in_the_config():
    """Each of 100 headsets drifts for 150 s in x and y; an error of 4 / sqrt(2 * 200) of the size is allowed."""
    drifts = []
    for seed in range(100):
        config = QuestConfig(mount=MOUNT, **{**QUIET, "position_drift": 0.02}, frame_rate=1.0)
        quest = QuestHeadset(config, np.random.default_rng(seed))
        history = PoseHistory()
        history.add(0.0, *START)
        quest.reset(PoseReset(*on_robot(START)), *START)
        for k in range(1, 151):
            quest.update(float(k), history)
        assert quest.last is not None
        drifts.append(np.subtract(quest.last.position, on_robot(START)[0])[:2])
    assert np.array(drifts).std() == pytest.approx(0.02, rel=0.2)


@each("bad", [{"frame_rate": 0.0}, {"position_noise": -1.0}, {"yaw_drift_deg": math.nan}])
def test_invalid_headset_configs_are_refused(bad):
    with pytest.raises(ConfigError, match=next(iter(bad))):
        QuestConfig(**bad)
