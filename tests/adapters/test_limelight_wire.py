"""Table of a Limelight, as a NetworkTables client in another process reads it, and the client's requests."""

from __future__ import annotations

import itertools
import json
import math
import socket
import subprocess
import sys
import time

import numpy as np
import pytest

from simcore.robotcode.networktables.limelight_table import TOPICS
from simcore.robotcode.networktables.network_clock import NetworkClock
from simcore.vision.camera import CameraConfig, CameraMount, PiecePipeline, TagPipeline, limelight_type
from simcore.vision.camera_scene import CameraScene
from simcore.vision.heading import PoseHistory
from simcore.vision.limelight import LimelightSim
from simcore.vision.limelight_settings import CameraSettings
from simcore.vision.tag_layout import official_layout
from simcore.world.rotation import from_yaw

ntcore = pytest.importorskip("ntcore", reason="pyntcore is not installed")

from simcore.robotcode.networktables.limelight_table import LimelightTable  # noqa: E402
from simcore.robotcode.networktables.networktables_sink import start_local_server  # noqa: E402

LAYOUT = official_layout("2026-welded")
CONFIG = CameraConfig(
    name="limelight-wire",
    type=limelight_type("LL4"),
    mount=CameraMount(x=0.1, y=-0.2, z=0.5, pitch_deg=-15.0),
    pipelines=(TagPipeline(json=True), PiecePipeline(far=5.0)),
)
PLACE, YAW = (2.3, 4.2, 0.0), 0.1

CLIENT = """
import json, sys, time
import ntcore
inst = ntcore.NetworkTableInstance.create()
inst.startClient4("robot")
inst.setServer("127.0.0.1", int(sys.argv[1]))
table = inst.getTable("limelight-wire")
every = ntcore.PubSubOptions(sendAll=True, keepDuplicates=True, pollStorage=200)
topics = json.loads(sys.argv[2])
subs = {name: table.getTopic(name).genericSubscribe(kind, every) for name, kind in topics.items()}
orientation = table.getDoubleArrayTopic("robot_orientation_set").publish()
pipeline = table.getEntry("pipeline")
bad = table.getEntry("crop")
end = time.monotonic() + 20
while time.monotonic() < end and not all(s.exists() for s in subs.values()):
    time.sleep(0.02)
bad.setDoubleArray([0.0, 1.0])                       # too short
pipeline.setDouble(7.0)                              # no such pipeline
end = time.monotonic() + 10
poses = []
while time.monotonic() < end and len(poses) < 50:
    orientation.set([float(sys.argv[3]), 0, 0, 0, 0, 0])
    inst.flush()
    poses += [[v.value()[6], v.server_time()] for v in subs["botpose_orb_wpiblue"].readQueue() if v.isValid()]
    time.sleep(0.02)
def read():
    values = {name: sub.get() for name, sub in subs.items()}
    return {name: value.value() if value.isValid() else None for name, value in values.items()}
end = time.monotonic() + 10
values, calm = read(), 0
while time.monotonic() < end and calm < 10:          # a frame comes topic by topic: wait for a pause between frames
    time.sleep(0.01)
    before, values = values, read()
    calm = calm + 1 if before == values else 0
types = {t.getName(): t.getTypeString() for t in inst.getTopics("/limelight-wire/")}
pipeline.setDouble(1.0)                              # a helper writes numbers as doubles
inst.flush()
end = time.monotonic() + 5
while time.monotonic() < end and table.getIntegerTopic("getpipe").subscribe(-1).get() != 1:
    time.sleep(0.02)
after = {"getpipe": table.getEntry("getpipe").getInteger(-1), "type": table.getEntry("getpipetype").getString("")}
print(json.dumps({"values": values, "types": types, "poses": poses, "after": after}))
"""


@pytest.fixture(scope="module")
def told():
    """Return a client's readings of a camera in front of the blue hub, the camera, its tag frames and start time."""
    instance = ntcore.NetworkTableInstance.create()
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = int(probe.getsockname()[1])
    start_local_server(instance, port=port)
    start = ntcore._now() * 1e-6
    clock = NetworkClock(offset=start)
    table = LimelightTable(instance, CONFIG, LAYOUT.field_size, clock)
    camera = LimelightSim(CONFIG, LAYOUT, np.random.default_rng(0), ports=[table])
    history = PoseHistory()
    args = [sys.executable, "-c", CLIENT, str(port), json.dumps(TOPICS), str(math.degrees(YAW))]
    frames, count = [], itertools.count()
    with subprocess.Popen(args, stdout=subprocess.PIPE, text=True) as client:
        end = time.monotonic() + 40
        while client.poll() is None and time.monotonic() < end:
            now = ntcore._now() * 1e-6 - start
            camera.listen(now)
            history.add(now, PLACE, from_yaw(YAW))
            frames += camera.update(now, history, CameraScene())
            time.sleep(0.3 if next(count) % 20 == 0 else 0.02)
        if client.poll() is None:
            client.kill()
        assert client.stdout is not None
        got = json.loads(client.stdout.read())
    camera.close()
    instance.stopServer()
    ntcore.NetworkTableInstance.destroy(instance)
    return got, camera, [frame for frame in frames if frame.pipeline == 0], start


def test_every_topic_has_its_type_and_a_value(told):
    got, _, _, _ = told
    for name, kind in TOPICS.items():
        assert got["types"][f"/limelight-wire/{name}"] == kind, name
        assert got["values"][name] is not None, name


def test_arrays_have_the_lengths_that_limelight_helpers_require(told):
    values = told[0]["values"]
    tags = int(values["botpose"][7])
    assert tags >= 2
    lengths = {
        **{name: 11 + 7 * tags for name in TOPICS if name.startswith("botpose") and "target" not in name},
        "t2d": 17,
        "stddevs": 12,
        "imu": 10,
        "hw": 4,
        "tc": 3,
        "crosshairs": 4,
        "rawfiducials": 7 * tags,
        "rawtargets": 3 * min(3, tags),
        "tcornxy": 8,
        **dict.fromkeys(("camerapose_robotspace", "botpose_targetspace", "camerapose_targetspace"), 6),
        **dict.fromkeys(("targetpose_cameraspace", "targetpose_robotspace"), 6),
    }
    for name, length in lengths.items():
        assert len(values[name]) == length, name


def test_botpose_is_the_robots_pose_relative_to_each_origin(told):
    values = told[0]["values"]
    length, width = LAYOUT.field_size
    blue, red, center = (values[f"botpose_orb{name}"] for name in ("_wpiblue", "_wpired", ""))
    assert blue[:3] == pytest.approx(PLACE, abs=0.03)
    assert red[:2] == pytest.approx((length - PLACE[0], width - PLACE[1]), abs=0.03)
    assert center[:2] == pytest.approx((PLACE[0] - length / 2, PLACE[1] - width / 2), abs=0.03)
    assert blue[5] == pytest.approx(math.degrees(YAW), abs=1e-6)
    assert red[5] == pytest.approx(math.degrees(YAW) - 180.0, abs=1e-6)
    assert values["botpose_wpiblue"][:3] == pytest.approx(PLACE, abs=0.1)
    assert values["botpose_wpiblue"][5] == pytest.approx(math.degrees(YAW), abs=1.5)
    assert blue[6] == pytest.approx(values["tl"] + values["cl"]) == pytest.approx(20.0)


def test_timestamp_minus_latency_is_the_exposure_time(told):
    """The time is equal by the client's clock, which NetworkTables synchronizes with the server's clock."""
    got, _, frames, start = told
    taken = [start + frame.time for frame in frames]
    assert len(got["poses"]) > 40
    for latency_ms, server_stamp in got["poses"][5:]:
        at = server_stamp * 1e-6 - latency_ms / 1000.0
        assert min(abs(at - t) for t in taken) < 1e-5


def test_poses_in_the_target_spaces_agree_with_the_geometry_of_the_scene(told):
    """In the tag's space a camera in front has negative z; in the robot's space z is forward."""
    values = told[0]["values"]
    row = LAYOUT.id_list.index(values["tid"])
    tag = LAYOUT.centers[row]  # 25 or 26, which face the blue wall
    x, y, z, pitch, yaw, roll = values["botpose_targetspace"]
    assert z == pytest.approx(-(tag[0] - PLACE[0]), abs=0.1)
    assert x == pytest.approx(-(PLACE[1] - tag[1]), abs=0.1)  # to the right as seen facing it
    assert y == pytest.approx(tag[2], abs=0.1)  # down to the carpet
    assert yaw == pytest.approx(-math.degrees(YAW), abs=4.0)  # clockwise-positive in this space
    assert (pitch, roll) == pytest.approx((0.0, 0.0), abs=4.0)
    ahead = (tag[0] - PLACE[0]) * math.cos(YAW) + (tag[1] - PLACE[1]) * math.sin(YAW)
    assert values["targetpose_robotspace"][2] == pytest.approx(ahead, abs=0.1)
    # within the noise of a frame, as a busy computer reads the two values from different frames
    assert math.hypot(*values["targetpose_cameraspace"][:3]) == pytest.approx(values["tdist"], abs=0.02)
    assert math.hypot(*values["camerapose_targetspace"][:3]) == pytest.approx(values["tdist"], abs=0.02)
    assert values["camerapose_robotspace"] == pytest.approx([0.1, 0.2, 0.5, 0.0, 15.0, 0.0])


def test_raw_fiducials_are_the_visible_tags(told):
    values = told[0]["values"]
    raw = np.array(values["rawfiducials"]).reshape(-1, 7)
    assert {25, 26} <= set(raw[:, 0].astype(int))
    for number, tx, ty, area, near, far, doubt in raw.tolist():
        tag = LAYOUT.centers[LAYOUT.id_list.index(int(number))]
        assert far == pytest.approx(math.dist(tag, PLACE), rel=0.08)  # tags farther away are 14 px wide
        assert near < far + 0.6 and area > 0.0 and 0.0 <= doubt <= 1.0
        if number == values["tid"]:
            assert (tx, ty) == (values["tx"], values["ty"])
    assert values["tv"] == 1 and values["getpipetype"] == "pipe_fiducial"
    assert values["t2d"][:2] == [1.0, len(raw)]


def test_the_json_results_equal_the_values_of_the_topics(told):
    values = told[0]["values"]
    data = json.loads(values["json"])
    assert data["v"] == 1 and data["pTYPE"] == "pipe_fiducial" and data["botpose_tagcount"] >= 2
    assert {fiducial["fID"] for fiducial in data["Fiducial"]} == set(np.array(values["rawfiducials"])[::7].astype(int))
    assert data["botpose_orb_wpiblue"] == pytest.approx(values["botpose_orb_wpiblue"][:6], abs=0.03)
    assert data["t6c_rs"] == values["camerapose_robotspace"]
    assert len(data["stdev_mt1"]) == len(data["stdev_mt2"]) == 6


def test_invalid_requests_change_nothing_and_a_valid_request_switches_the_pipeline(told):
    got, camera, _, _ = told
    assert got["after"] == {"getpipe": 1, "type": "pipe_neuraldetector"}
    assert camera.bad_requests == 2
    assert camera.settings.crop == CameraSettings.of(CONFIG).crop


# --- in the same process, as under `robotpy sim` --------------------------------------------------------------------


@pytest.fixture
def local():
    instance = ntcore.NetworkTableInstance.create()
    instance.startLocal()
    yield instance
    ntcore.NetworkTableInstance.destroy(instance)


def camera_on(instance, config):
    table = LimelightTable(instance, config, LAYOUT.field_size, NetworkClock())
    return LimelightSim(config, LAYOUT, np.random.default_rng(0), ports=[table])


def look(camera, seconds, scene=None, start=0.0):
    history = PoseHistory()
    for k in range(round(seconds / 0.02)):
        t = start + 0.02 * k
        camera.listen(t)
        history.add(t, PLACE, from_yaw(YAW))
        camera.update(t, history, scene or CameraScene())


def test_frames_continue_with_zeros_when_no_tag_is_visible(local):
    """Zeros with a tag count of 0, a growing heartbeat and a timestamp per frame show that the camera works."""
    away = CameraConfig(name="ll", type=limelight_type("LL3"), mount=CameraMount(z=0.5, pitch_deg=90.0))
    camera = camera_on(local, away)
    options = ntcore.PubSubOptions(sendAll=True, keepDuplicates=True, pollStorage=100)
    poses = local.getDoubleArrayTopic("/ll/botpose_wpiblue").subscribe([], options)
    look(camera, 1.0)
    frames = poses.readQueue()
    assert 27 <= len(frames) <= 31
    assert all(
        list(frame.value[:6]) == [0.0] * 6 and frame.value[7] == 0.0 and len(frame.value) == 11 for frame in frames
    )
    stamps = np.diff([frame.time for frame in frames]) * 1e-6
    assert stamps == pytest.approx(np.full(len(stamps), 1 / 30), abs=1e-5)
    assert local.getDoubleTopic("/ll/hb").subscribe(0.0).get() >= 27
    assert local.getIntegerTopic("/ll/tv").subscribe(-1).get() == 0
    camera.close()


def test_detected_pieces_are_published_with_the_nearest_first(local):
    config = CameraConfig(
        name="ll", type=limelight_type("LL3"), mount=CameraMount(z=0.5, pitch_deg=20.0), pipelines=(PiecePipeline(),)
    )
    camera = camera_on(local, config)
    pieces = np.array([(PLACE[0] + 2.0, PLACE[1], 0.075), (PLACE[0] + 1.2, PLACE[1] + 0.2, 0.075)])
    look(camera, 0.5, CameraScene(pieces=pieces, radii=np.full(2, 0.075), class_names=("ball",)))
    raw = np.array(local.getDoubleArrayTopic("/ll/rawdetections").subscribe([]).get()).reshape(-1, 12)
    assert len(raw) == 2
    assert raw[0, 3] > raw[1, 3]  # the nearest is first and largest
    assert local.getDoubleTopic("/ll/tx").subscribe(0.0).get() == pytest.approx(raw[0, 1])
    assert local.getStringTopic("/ll/tdclass").subscribe("").get() == "ball"
    assert local.getStringTopic("/ll/getpipetype").subscribe("").get() == "pipe_neuraldetector"
    camera.close()


@pytest.mark.parametrize("kind", ["setDouble", "setInteger"])
@pytest.mark.parametrize("is_early", [False, True])
def test_requests_may_be_doubles_or_integers_and_may_precede_the_camera(local, kind, is_early):
    """Robot code often sets a pipeline in its constructor, before the simulated camera exists."""
    camera = None if is_early else camera_on(local, CONFIG)
    getattr(local.getEntry("/limelight-wire/pipeline"), kind)(1)
    camera = camera or camera_on(local, CONFIG)
    camera.listen(0.0)
    assert camera.settings.pipeline == 1
    camera.close()


def test_invalid_requests_are_ignored_and_logged_once(local, caplog):
    camera = camera_on(local, CONFIG)
    before = CameraSettings.of(CONFIG)
    requests = local.getTable("limelight-wire")
    for _ in range(3):
        requests.getEntry("robot_orientation_set").setDoubleArray([math.nan] * 6)
        requests.getEntry("fiducial_id_filters_set").setDoubleArray([math.inf])
        requests.getEntry("throttle_set").setString("often")
        camera.listen(0.0)
    assert camera.bad_requests >= 3
    assert len(caplog.records) == 3
    assert camera.settings == before
    camera.close()
