"""QuestNav's Python library reads the simulated headset and commands it; needs robotpy-questnav and protobuf."""

from __future__ import annotations

import importlib.metadata
import math
import sys

import numpy as np
import pytest

ntcore = pytest.importorskip("ntcore", reason="pyntcore is not installed")
pytest.importorskip("wpimath.geometry")

from simcore.robotcode.networktables.network_clock import NetworkClock  # noqa: E402
from simcore.robotcode.networktables.questnav_table import (  # noqa: E402
    QuestNavTable,
    device_message,
    frame_message,
    read_command,
    response_message,
)
from simcore.vision.camera import CameraMount, camera_pose  # noqa: E402
from simcore.vision.heading import PoseHistory  # noqa: E402
from simcore.vision.quest_headset import PoseReset, QuestConfig, QuestFrame, QuestHeadset  # noqa: E402
from simcore.world.rotation import from_rpy  # noqa: E402

MOUNT = CameraMount(x=-0.2, y=0.1, z=0.6, yaw_deg=180.0)
QUIET = {"position_noise": 0.0, "angle_noise_deg": 0.0, "position_drift": 0.0, "yaw_drift_deg": 0.0}
START = ((2.0, 3.0, 0.0), from_rpy(0.0, 0.0, 0.4))
END = ((5.0, 1.0, 0.1), from_rpy(0.05, -0.1, 2.0))


@pytest.fixture(scope="module")
def questnav():
    """Return the module `questnav` from the folder of its distribution, which cannot be imported by name."""
    pytest.importorskip("google.protobuf", reason="needs protobuf: pip install robotpy-questnav protobuf")
    try:
        files = importlib.metadata.files("robotpy-questnav") or []
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("needs robotpy-questnav: pip install robotpy-questnav==2026.0.1a0")
    folder = next(file.locate() for file in files if file.name == "questnav.py").parent
    sys.path[:0] = [str(folder), str(folder / "generated")]  # as in a project that copies the modules
    try:
        import questnav
    finally:
        del sys.path[:2]
    return questnav


def test_questnavs_classes_read_and_write_the_same_bytes(questnav):
    frames, commands = questnav.data_pb2, questnav.commands_pb2
    rng = np.random.default_rng(7)
    for _ in range(50):
        number = int(rng.integers(0, 2**31))
        time, *place = (float(v) for v in rng.normal(scale=10.0, size=4))
        turn = from_rpy(*rng.uniform(-3.0, 3.0, 3).tolist())
        data = frame_message(QuestFrame(number, time, tuple(place), turn))
        read = frames.ProtobufQuestNavFrameData.FromString(data)
        assert read.frame_count == number and read.timestamp == time and read.isTracking
        assert [getattr(read.pose3d.translation, axis) for axis in "xyz"] == place
        assert tuple(getattr(read.pose3d.rotation.q, axis) for axis in "xyzw") == turn
        assert read.SerializeToString() == data

        command = commands.ProtobufQuestNavCommand(type=commands.POSE_RESET, command_id=number)
        target = command.pose_reset_payload.target_pose
        for axis, value in zip("xyz", place, strict=True):
            setattr(target.translation, axis, value)
        for axis, value in zip("xyzw", turn, strict=True):
            setattr(target.rotation.q, axis, value)
        taken = read_command(command.SerializeToString())
        assert taken.number == number and taken.reset is not None
        assert taken.reset.position == tuple(place) and taken.reset.attitude == pytest.approx(turn)
    device = frames.ProtobufQuestNavDeviceData.FromString(device_message(87, lost=2))
    assert (device.battery_percent, device.tracking_lost_counter) == (87, 2)
    response = commands.ProtobufQuestNavCommandResponse.FromString(response_message(9, "no"))
    assert (response.command_id, response.success, response.error_message) == (9, False, "no")


def test_questnavs_library_reads_every_frame_of_the_headset_and_resets_its_pose(questnav):
    """The library uses the default NetworkTables instance."""
    instance = ntcore.NetworkTableInstance.getDefault()
    theirs = questnav.QuestNav()
    clock = NetworkClock(offset=0.0)
    table = QuestNavTable(instance, clock)
    headset = QuestHeadset(QuestConfig(mount=MOUNT, **QUIET), np.random.default_rng(1), ports=[table])
    history = PoseHistory()
    history.add(0.02, *START)
    headset.listen(0.02, history)
    headset.update(0.02, history)
    (x, y, z), (qx, qy, qz, qw) = camera_pose(*START, MOUNT.position, MOUNT.rotation)
    geometry = sys.modules["wpimath.geometry"]
    told = geometry.Pose3d(geometry.Translation3d(x, y, z), geometry.Rotation3d(geometry.Quaternion(qw, qx, qy, qz)))
    theirs.set_pose(told)
    headset.listen(0.03, history)
    assert headset.resets == 1
    for k in range(2, 52):
        history.add(0.02 * k, *END)
        headset.update(0.02 * k, history)
        theirs.command_periodic()
    frames = theirs.get_all_unread_pose_frames()
    assert len(frames) == pytest.approx(100, abs=3)  # no frame is lost in 1 s
    place, _ = camera_pose(*END, MOUNT.position, MOUNT.rotation)
    last = frames[-1].quest_pose_3d
    assert math.dist((last.X(), last.Y(), last.Z()), place) < 1e-6
    assert theirs.get_battery_percent() == 100
    assert theirs.get_frame_count() == frames[-1].frame_count == headset.last.number
    assert theirs.is_connected()
    table.close()
    table.close()
    assert table.read() == []


@pytest.mark.parametrize("kind", ["raw", "proto:questnav.protos.commands.ProtobufQuestNavCommand"])
def test_a_command_is_answered_for_every_topic_type(kind, caplog):
    """Libraries publish raw bytes or protobuf. An unknown command and invalid bytes are answered with an error."""
    instance = ntcore.NetworkTableInstance.create()
    try:
        instance.startLocal()
        table = QuestNavTable(instance, NetworkClock(offset=0.0))
        response = instance.getRawTopic("/QuestNav/response").subscribe("", b"")
        request = instance.getRawTopic("/QuestNav/request").publish(kind)
        request.set(bytes.fromhex("08051007"))
        assert table.read() == []
        assert response.get() == response_message(7, "unknown command type 5")
        request.set(b"\xff\xff")
        assert table.read() == [] and b"cut short or invalid" in response.get()
        request.set(
            bytes.fromhex(
                "08011007522c0a2a0a1209000000000000084011000000000000f83f12140a1209333333333333e33f219a9999999999e93f"
            )
        )
        (reset,) = table.read()
        assert isinstance(reset, PoseReset) and reset.position == (3.0, 1.5, 0.0)
        assert response.get() == response_message(7)
        assert caplog.text.count("it is ignored") == 2
    finally:
        ntcore.NetworkTableInstance.destroy(instance)
