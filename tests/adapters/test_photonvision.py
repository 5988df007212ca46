"""PhotonVision: photonlib's own simulation sees the same tags, and a PhotonCamera reads simcore's frames."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("photonlibpy", reason="needs photonlibpy: pip install .[photonvision]")
ntcore = pytest.importorskip("ntcore")

from photonlibpy import PhotonCamera  # noqa: E402
from photonlibpy.estimation import TargetModel  # noqa: E402
from photonlibpy.simulation import PhotonCameraSim, SimCameraProperties, VisionTargetSim  # noqa: E402
from wpimath.estimator import SwerveDrive4PoseEstimator  # noqa: E402
from wpimath.geometry import (  # noqa: E402
    Pose2d,
    Pose3d,
    Quaternion,
    Rotation2d,
    Rotation3d,
    Transform3d,
    Translation2d,
    Translation3d,
)
from wpimath.kinematics import SwerveDrive4Kinematics, SwerveModulePosition  # noqa: E402

from simcore.robotcode.makers.photonvision.photon_port import PhotonCameraPort, pipeline_result  # noqa: E402
from simcore.robotcode.networktables.limelight_table import LimelightTable  # noqa: E402
from simcore.robotcode.networktables.network_clock import NetworkClock  # noqa: E402
from simcore.vision.camera import (  # noqa: E402  # noqa: E402
    CameraBias,
    CameraConfig,
    CameraMount,
    PiecePipeline,
    TagPipeline,
    camera_pose,
    limelight_type,
    optical_rotation,
    quad_area,
)
from simcore.vision.camera_scene import CameraScene  # noqa: E402
from simcore.vision.heading import PoseHistory  # noqa: E402
from simcore.vision.limelight import LimelightSim  # noqa: E402
from simcore.vision.tag_layout import official_layout  # noqa: E402
from simcore.vision.tag_visibility import find_tags  # noqa: E402
from simcore.world.rotation import from_rpy, from_yaw  # noqa: E402

LAYOUT = official_layout("2026-welded")
CONFIG = CameraConfig(
    name="photon-test", type=limelight_type("LL4"), mount=CameraMount(x=0.2, z=0.4, pitch_deg=-15.0, yaw_deg=10.0)
)


def camera_properties(config):
    """Return the lens as photonlib's `SimCameraProperties`, from intrinsics because of the bug tested below."""
    lens = config.type
    (fx, fy), (cx, cy) = lens.focal_length, lens.principal_point
    properties = SimCameraProperties()
    matrix = np.array([(fx, 0.0, cx), (0.0, fy, cy), (0.0, 0.0, 1.0)])
    properties.setCalibrationFromIntrinsics(lens.width, lens.height, matrix, np.zeros((8, 1)))
    properties.setFPS(config.rate)
    return properties


def pose3d(pos, quat) -> Pose3d:
    x, y, z, w = quat
    return Pose3d(Translation3d(*pos), Rotation3d(Quaternion(w, x, y, z)))


@pytest.fixture(scope="module")
def theirs():
    """Return photonlib's simulated camera and all tags of the field as targets, without occlusion."""
    camera = PhotonCameraSim(PhotonCamera("photon-reference"), camera_properties(CONFIG))
    targets = []
    for row, number in enumerate(LAYOUT.id_list):
        turn = LAYOUT.rotations[row]
        tag = Pose3d(Translation3d(*LAYOUT.centers[row]), Rotation3d(np.array(turn)))
        targets.append(VisionTargetSim(tag, TargetModel.AprilTag36h11(), number))
    return camera, targets


def test_photonlibs_simulation_sees_the_same_tags_from_200_poses(theirs):
    """Neither side models occlusion here.

    Tags that only photonlib sees are explained one by one: photonlib needs an area of 100 px^2, simcore edges of 12 px
    and an angle below 75 degrees.
    """
    camera, targets = theirs
    rng = np.random.default_rng(2026)
    both = only_theirs = 0
    for _ in range(200):
        pos = tuple(rng.uniform((0.4, 0.4, 0.0), (16.1, 7.6, 0.05)).tolist())
        quat = from_rpy(*rng.uniform(-0.1, 0.1, 2).tolist(), float(rng.uniform(-math.pi, math.pi)))
        eye, turn = camera_pose(pos, quat, CONFIG.mount.position, CONFIG.mount.rotation)
        rotation = optical_rotation(turn)
        rows, corners = find_tags(LAYOUT, CONFIG.type, eye, rotation, min_side=12.0, max_angle_deg=75.0)
        ours = {LAYOUT.id_list[row]: c for row, c in zip(rows, corners, strict=True)}
        result = camera.process(0.0, pose3d(eye, turn), list(targets))
        other = {t.getFiducialId(): np.array([(c.x, c.y) for c in t.getDetectedCorners()]) for t in result.getTargets()}
        assert set(ours) <= set(other), f"from {pos}: we see {set(ours) - set(other)}, they do not"
        for number, pixels in ours.items():
            theirs_sorted = other[number]
            for corner in pixels:  # in any order
                assert np.abs(theirs_sorted - corner).max(axis=1).min() < 1e-3
            both += 1
        for number in set(other) - set(ours):
            edges = np.linalg.norm(other[number] - np.roll(other[number], 1, axis=0), axis=1)
            row = LAYOUT.id_list.index(number)
            to_eye = np.array(eye) - LAYOUT.centers[row]
            angle = math.degrees(math.acos(to_eye @ LAYOUT.normals[row] / np.linalg.norm(to_eye)))
            near = to_eye @ -rotation[2] < 0.1
            assert edges.min() < 12.0 or angle > 75.0 or near, f"tag {number} from {pos}"
            only_theirs += 1
    print(f"{both} tags seen by both, {only_theirs} by theirs only, all smaller than 12 px or beyond 75 degrees")
    assert both > 300


def test_the_known_bug_in_photonlibs_field_of_view_still_exists():
    """PhotonLib computes atan(2 x) for 2 atan(x). If this test fails, the bug is fixed: update docs/cameras.md."""
    properties = SimCameraProperties()
    properties.setCalibrationFromFOV(1280, 800, Rotation2d.fromDegrees(90.0))
    wide = math.degrees(2.0 * math.atan(math.tan(math.radians(45.0)) * 1280 / math.hypot(1280, 800)))
    assert properties.getHorizFOV().degrees() == pytest.approx(59.5, abs=0.5)
    assert wide == pytest.approx(80.6, abs=0.1)


def test_a_photon_camera_reads_simcores_frames():
    """The test compares tags, both poses, the multi-tag pose and the time of exposure."""
    clock = NetworkClock(offset=0.0)
    quiet = CameraConfig(
        name="photon-ours",
        type=limelight_type("LL3"),
        mount=CameraMount(x=0.2, z=0.5, pitch_deg=-15.0),
    )
    port, reader = PhotonCameraPort(quiet, clock), PhotonCamera("photon-ours")
    camera = LimelightSim(quiet, LAYOUT, np.random.default_rng(0), ports=[port])
    history = PoseHistory()
    pos, quat = (2.3, 4.2, 0.0), from_yaw(0.05)
    frames = []
    for k in range(8):
        history.add(0.02 * k, pos, quat)
        frames += camera.update(0.02 * k, history, CameraScene())
    result = reader.getLatestResult()
    last = frames[-1]
    assert {t.getFiducialId() for t in result.getTargets()} == {tag.id for tag in last.tags} >= {25, 26}
    assert result.getLatencyMillis() == pytest.approx(1e3 * last.latency, abs=0.01)
    eye, turn = camera_pose(pos, quat, quiet.mount.position, quiet.mount.rotation)
    largest_first = sorted(last.tags, key=lambda tag: -tag.area_percent)
    assert result.getBestTarget().getFiducialId() == largest_first[0].id
    for target, tag in zip(result.getTargets(), largest_first, strict=True):
        assert target.getYaw() == pytest.approx(tag.tx_deg)
        assert target.getArea() == pytest.approx(tag.area_percent)
        row = LAYOUT.id_list.index(tag.id)
        at = pose3d(eye, turn).transformBy(target.getBestCameraToTarget())
        assert math.dist((at.X(), at.Y(), at.Z()), LAYOUT.centers[row]) < 0.1
    multi = result.multitagResult
    assert multi is not None and set(multi.fiducialIDsUsed) == {tag.id for tag in last.tags}
    best = Pose3d().transformBy(multi.estimatedPose.best)
    assert math.dist((best.X(), best.Y(), best.Z()), eye) < 0.05
    assert float(quad_area(last.tags[0].corners[None])[0]) > 0.0
    port.close()
    port.close()


def test_a_photon_camera_switches_pipeline_driver_mode_and_frame_rate():
    """Robot code requests another pipeline, driver mode, and 10 instead of 30 frames a second."""
    config = replace(
        CONFIG, name="photon-asked", type=limelight_type("LL3"), pipelines=(TagPipeline(), PiecePipeline())
    )
    port, reader = PhotonCameraPort(config, NetworkClock(offset=0.0)), PhotonCamera("photon-asked")
    camera = LimelightSim(config, LAYOUT, np.random.default_rng(0), ports=[port])
    history = PoseHistory()
    tick = 0

    def run(seconds):
        nonlocal tick
        results = []
        for _ in range(round(seconds / 0.02)):
            tick += 1
            camera.listen(0.02 * tick)
            history.add(0.02 * tick, (2.3, 4.2, 0.0), from_yaw(0.05))
            camera.update(0.02 * tick, history, CameraScene())
            results += reader.getAllUnreadResults()
        return results

    seen = run(1.0)
    assert len(seen) == pytest.approx(30, abs=3) and all(result.hasTargets() for result in seen)
    times = [result.getTimestampSeconds() for result in seen]
    assert np.diff(times) == pytest.approx(1.0 / 30.0, abs=2e-6)  # of exposure; stamps are whole microseconds
    assert reader.isConnected() and reader.getPipelineIndex() == 0 and not reader.getDriverMode()
    reader.setPipelineIndex(1)
    reader.setFPSLimit(10)
    run(0.2)
    few = run(1.0)
    assert len(few) == pytest.approx(10, abs=1) and not any(result.hasTargets() for result in few)
    assert (reader.getPipelineIndex(), reader.getFPSLimit()) == (1, 10)
    reader.setPipelineIndex(0)
    reader.setFPSLimit(-1)
    reader.setDriverMode(True)
    run(0.2)
    assert reader.getDriverMode() and not any(result.hasTargets() for result in run(0.3))
    reader.setDriverMode(False)
    reader.setPipelineIndex(7)  # no such pipeline
    run(0.2)
    assert reader.getPipelineIndex() == 0 and run(0.3)[-1].hasTargets()
    assert camera.bad_requests == 1
    port.close()


def test_frames_of_a_robot_at_rest_are_distinct_and_an_estimator_converges():
    """Without noise all frames are equal, and NetworkTables drops equal values by default."""
    quiet = CameraConfig(
        name="photon-still",
        type=replace(limelight_type("LL3"), corner_noise=0.0),
        mount=CameraMount(x=0.2, z=0.5, pitch_deg=-15.0),
        bias=CameraBias.none(),
    )
    instance, clock, pos, quat = ntcore.NetworkTableInstance.getDefault(), NetworkClock(offset=0.0), (2.3, 4.2), 0.05
    port, table = PhotonCameraPort(quiet, clock), LimelightTable(instance, quiet, LAYOUT.field_size, clock)
    camera = LimelightSim(quiet, LAYOUT, np.random.default_rng(0), ports=[port, table])
    every = ntcore.PubSubOptions(sendAll=True, keepDuplicates=True, pollStorage=50)
    poses = instance.getTable(quiet.name).getDoubleArrayTopic("botpose_wpiblue").subscribe([], every)
    beats = instance.getTable(quiet.name).getDoubleTopic("hb").subscribe(0.0, every)
    reader, history, frames, results, limelight, hearts = PhotonCamera(quiet.name), PoseHistory(), 0, [], [], []
    for tick in range(100):
        history.add(0.02 * tick, (*pos, 0.0), from_yaw(quat))
        frames += len(camera.update(0.02 * tick, history, CameraScene()))
        results += reader.getAllUnreadResults()
        limelight += poses.readQueue()
        hearts += beats.readQueue()
    assert frames == pytest.approx(60, abs=3)
    stamps = [result.getTimestampSeconds() for result in results]
    beaten = [beat.value for beat in hearts]
    for told in (stamps, [pose.time for pose in limelight], beaten):
        assert len(told) == frames and (np.diff(told) > 0.0).all()
    assert reader.isConnected()
    still = [SwerveModulePosition()] * 4
    places = [Translation2d(x, y) for x in (0.3, -0.3) for y in (0.3, -0.3)]
    eye = Transform3d(Translation3d(0.2, 0.0, 0.5), Rotation3d(0.0, math.radians(-15.0), 0.0))
    for name in ("photon", "limelight"):
        start = Pose2d(pos[0] + 0.4, pos[1] - 0.3, quat)
        estimator = SwerveDrive4PoseEstimator(SwerveDrive4Kinematics(*places), Rotation2d(quat), still, start)
        for result, pose in zip(results, limelight, strict=True):
            estimator.updateWithTime(result.getTimestampSeconds(), Rotation2d(quat), still)
            x, y, _, _, _, yaw, *_ = pose.value
            seen = Pose2d(x, y, Rotation2d.fromDegrees(yaw))
            if name == "photon":
                seen = (
                    Pose3d().transformBy(result.multitagResult.estimatedPose.best).transformBy(eye.inverse()).toPose2d()
                )
            estimator.addVisionMeasurement(seen, result.getTimestampSeconds())
        found = estimator.getEstimatedPosition()
        assert math.dist((found.X(), found.Y()), pos) < 0.01, name
    for one in (port, table, poses, beats):
        one.close()


def test_pieces_are_published_as_object_detections():
    config = CameraConfig(
        name="photon-pieces",
        type=limelight_type("LL3"),
        mount=CameraMount(z=0.5, pitch_deg=20.0),
        pipelines=(PiecePipeline(),),
    )
    camera = LimelightSim(config, LAYOUT, np.random.default_rng(0))
    history = PoseHistory()
    scene = CameraScene(pieces=np.array([(6.5, 5.0, 0.075), (6.8, 4.5, 0.075)]), radii=np.full(2, 0.075))
    frames = []
    for k in range(8):
        history.add(0.02 * k, (5.0, 5.0, 0.0), from_yaw(0.0))
        frames += camera.update(0.02 * k, history, scene)
    targets = pipeline_result(frames[-1], 1_000_000).getTargets()
    assert [t.objDetectId for t in targets] == [0, 0]
    assert all(0.0 < t.objDetectConf <= 1.0 and t.getFiducialId() == -1 for t in targets)
    assert targets[0].getBestCameraToTarget() == Transform3d()
