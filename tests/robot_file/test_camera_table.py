"""Table `[[camera]]` of every maker: values are read, and errors name the mistake."""

import math

import pytest
from each_case import each

from simcore.errors import ConfigError
from simcore.vision.camera import PHOTON_LENS, limelight_type

PLACE = "x = 0.2\ny = -0.1\nz = 0.5\n"
LIMELIGHT = f'[[camera]]\nname = "limelight-a"\ntype = "LL3G"\n{PLACE}'
PHOTON = f'[[camera]]\nmaker = "photonvision"\nname = "front"\n{PLACE}'
QUEST = f'[[camera]]\nmaker = "questnav"\n{PLACE}'


def test_the_reader_accepts_a_camera_of_each_maker(read):
    robot = read(LIMELIGHT + PHOTON + "pitch_deg = -20\n" + QUEST + "yaw_deg = 180\nfps = 120\n")
    limelight, photon = robot.cameras
    assert (limelight.maker, limelight.type) == ("limelight", limelight_type("LL3G"))
    assert (photon.maker, photon.name) == ("photonvision", "front")
    assert photon.type.focal_length == pytest.approx(PHOTON_LENS.focal_length)
    assert (photon.mount.x, photon.mount.y, photon.mount.pitch_deg) == (0.2, -0.1, -20.0)
    assert robot.headset is not None
    assert robot.headset.frame_rate == 120.0 and robot.headset.mount.yaw_deg == 180.0


def test_a_camera_can_be_given_by_its_diagonal_field_of_view(read):
    """f = hypot(w, h) / 2 / tan(d / 2) in pixels, equal across and down."""
    text = PHOTON + "resolution = [640, 480]\ndiagonal_fov_deg = 75.0\nfps = 20\nlatency_ms = 45\nnoise_px = 0.5\n"
    (camera,) = read(text).cameras
    focal_length = math.hypot(640, 480) / 2.0 / math.tan(math.radians(37.5))
    assert camera.type.focal_length == pytest.approx((focal_length, focal_length))
    assert (camera.type.width, camera.type.height) == (640, 480)
    assert camera.rate == 20.0 and camera.type.corner_noise == 0.5
    assert camera.type.capture_latency + camera.type.pipeline_latency == pytest.approx(0.045)


def test_a_limelight_can_have_another_resolution_and_rate(read):
    """Capture and pipeline latency change by the same factor; the lens keeps its horizontal field of view."""
    (camera,) = read(LIMELIGHT + "resolution = [640, 400]\nfps = 90\nlatency_ms = 13.5\njson = true\n").cameras
    own = limelight_type("LL3G")
    assert camera.type.horizontal_fov_deg == own.horizontal_fov_deg and camera.rate == 90.0
    assert camera.type.focal_length[0] == pytest.approx(camera.type.focal_length[1])
    assert camera.type.capture_latency == pytest.approx(own.capture_latency / 2.0)
    assert camera.type.pipeline_latency == pytest.approx(own.pipeline_latency / 2.0)
    assert camera.pipelines[0].json


def test_camera_modes_are_read_as_pipelines(read):
    (camera,) = read(PHOTON + 'mode = ["pieces", "tags", "tags"]').cameras
    assert [pipeline.kind for pipeline in camera.pipelines] == ["pieces", "tags", "tags"]


@each(
    ("text", "said"),
    [
        (PHOTON.replace("photonvision", "photon"), "maker must be one of limelight, photonvision, questnav, got"),
        (PHOTON.replace("photonvision", "photon"), "Did you mean 'photonvision'?"),
        (PHOTON + "type = 'LL4'", "type must be one of OV9281, got 'LL4'"),
        (PHOTON + "resolution = [640]", "must be two numbers, across and down, e.g. [1280, 720]; got [640]"),
        (PHOTON + "resolution = [0, 480]", "resolution[0] must be a whole number from 1 to 10000"),
        (PHOTON + "diagonal_fov_deg = 180", "diagonal_fov_deg must be a number from 1 to 179 deg, got 180"),
        (PHOTON + "horizontal_fov_deg = 0", "horizontal_fov_deg must be a number from 1 to 179 deg, got 0"),
        (PHOTON + "horizontal_fov_deg = 60\ndiagonal_fov_deg = 70", "means the same as horizontal_fov_deg; write one"),
        (PHOTON + "fps = 1e300", "fps must be a number above 0 and up to 500 1/s, got 1e+300"),
        (PHOTON + "fps = 0", "fps must be a number above 0 and up to 500 1/s, got 0"),
        (PHOTON + "latency_ms = -1", "latency_ms must be a number from 0 to 10000 ms, got -1"),
        (PHOTON + "json = true", "no key 'json'"),
        (PHOTON + f"mode = {['tags'] * 11}", "mode must be at most 10 modes, one a pipeline; got 11"),
        (PHOTON + "mode = ['tags', 'note']", "mode[1] must be one of tags, pieces, got 'note'"),
        (PHOTON + PHOTON, "[[camera]] 'front': name is used twice"),
        (QUEST + "name = 'quest'", "no key 'name'"),
        (QUEST + QUEST, "maker questnav is used twice; robot code talks to one headset"),
        ("[[camera]]\nmaker = 'questnav'\nx = 0\ny = 0", "z is missing; it must be a number from 0 to 3 m"),
    ],
)
def test_the_error_names_each_mistake_in_a_camera(read, text, said):
    with pytest.raises(ConfigError) as error:
        read(text)
    assert said in str(error.value)
