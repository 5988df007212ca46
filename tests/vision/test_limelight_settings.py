"""Requests of robot code: valid requests take effect, invalid requests change nothing."""

import math

import numpy as np
import pytest
from each_case import each

from simcore.vision.camera import CameraConfig, CameraMount, TagPipeline
from simcore.vision.limelight import CameraRequest, LimelightSim
from simcore.vision.limelight_settings import INPUTS, NO_EFFECT, NOT_MODELED, CameraSettings
from simcore.vision.tag_layout import official_layout
from simcore.world.rotation import rotate

CONFIG = CameraConfig(
    mount=CameraMount(x=0.3, y=0.2, z=0.5, pitch_deg=-20.0, yaw_deg=30.0), pipelines=(TagPipeline(),) * 3
)

GOOD = {
    "pipeline": ((2.0,), "pipeline", 2),
    "priorityid": ((26.0,), "priority_id", 26),
    "crop": ((-0.5, 0.5, -1.0, 1.0), "crop", (-0.5, 0.5, -1.0, 1.0)),
    "fiducial_id_filters_set": ((26.0, 25.0), "id_filters", (26, 25)),
    "fiducial_downscale_set": ((2.0,), "downscale", 1.5),
    "throttle_set": ((100.0,), "throttle", 100),
    "camMode": ((1.0,), "is_driver_camera", True),
    "imumode_set": ((4.0,), "imu_mode", 4),
    "imuassistalpha_set": ((0.01,), "imu_assist", 0.01),
    "camerapose_robotspace_set": ((0.1, 0.2, 0.3, 1.0, 2.0, 3.0), "mount", (0.1, 0.2, 0.3, 1.0, 2.0, 3.0)),
}

BAD = [
    ("pipeline", (3.0,)),
    ("pipeline", (-1.0,)),
    ("pipeline", (0.5,)),
    ("pipeline", (math.nan,)),
    ("pipeline", ()),
    ("pipeline", (0.0, 1.0)),
    ("priorityid", (-2.0,)),
    ("crop", (0.0, 1.0)),
    ("crop", (0.5, -0.5, -1.0, 1.0)),
    ("crop", (-1.0, 1.5, -1.0, 1.0)),
    ("crop", (-1.0, math.inf, -1.0, 1.0)),
    ("fiducial_id_filters_set", (1.5,)),
    ("fiducial_downscale_set", (6.0,)),
    ("throttle_set", (-1.0,)),
    ("camMode", (2.0,)),
    ("imumode_set", (5.0,)),
    ("imuassistalpha_set", (1.1,)),
    ("camerapose_robotspace_set", (0.0, 0.0, 0.0)),
    ("camerapose_robotspace_set", (0.0, 0.0, 0.0, 0.0, 0.0, math.nan)),
]


def test_every_input_has_a_valid_request():
    assert set(GOOD) == set(INPUTS)


@each("topic", sorted(GOOD))
def test_a_valid_request_changes_its_setting(topic):
    values, name, expected = GOOD[topic]
    settings = CameraSettings.of(CONFIG)
    assert settings.apply(topic, values) is None
    assert getattr(settings, name) == expected


def test_an_empty_filter_request_restores_the_filters_of_the_pipeline():
    settings = CameraSettings.of(CONFIG)
    settings.apply("fiducial_id_filters_set", (26.0,))
    assert settings.apply("fiducial_id_filters_set", ()) is None
    assert settings.id_filters is None


def test_a_camera_starts_with_its_true_mount():
    """Forward, right, up and pitch up in the Limelight's terms are x, -y, z and -pitch in WPILib's."""
    settings = CameraSettings.of(CONFIG)
    assert settings.mount == (0.3, -0.2, 0.5, 0.0, 20.0, 30.0)
    position, rotation = settings.believed_mount
    assert position == pytest.approx(CONFIG.mount.position)
    assert rotation == pytest.approx(CONFIG.mount.rotation)
    assert rotate(rotation, (1.0, 0.0, 0.0))[2] == pytest.approx(math.sin(math.radians(20.0)))  # it looks up


@pytest.mark.parametrize(
    ("topic", "values"),
    [*BAD, ("robot_orientation_set", (1.0,)), ("robot_orientation_set", (math.nan,) * 6), ("crop", None)],
)
def test_an_invalid_request_is_logged_once(topic, values, caplog):
    camera = LimelightSim(CONFIG, official_layout("2026-welded"), np.random.default_rng(0))
    for k in range(5):
        camera.request(CameraRequest(topic, values), 0.02 * k)
    assert camera.bad_requests == 5
    assert len(caplog.records) == 1
    assert topic in caplog.text and "limelight" in caplog.text
    assert camera.settings == CameraSettings.of(CONFIG)
    assert camera.heading.attitude(0.0) == pytest.approx(np.eye(3))


@pytest.mark.parametrize("topic", [*NO_EFFECT, *NOT_MODELED, "priorityId", "x"])
def test_a_topic_without_effect_is_logged_once(topic, caplog):
    caplog.set_level("INFO")
    camera = LimelightSim(CONFIG, official_layout("2026-welded"), np.random.default_rng(0))
    for k in range(5):
        camera.request(CameraRequest(topic, None), 0.02 * k)
    assert len(caplog.records) == 1 and topic in caplog.text
    assert ("Did you mean 'priorityid'?" in caplog.text) == (topic == "priorityId")
    assert camera.bad_requests == 0 and camera.settings == CameraSettings.of(CONFIG)
