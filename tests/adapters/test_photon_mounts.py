"""Mounts of PhotonVision cameras from robot code: by VisionSystemSim, by use, or by the order of construction."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

geometry = pytest.importorskip("wpimath.geometry")

from simcore.robotcode.makers.photonvision.photon_program import (  # noqa: E402  # noqa: E402
    PhotonProgram,
    SeenEstimator,
    lens_of,
    mounts,
    pipeline_of,
)
from simcore.vision.camera import PHOTON_LENS  # noqa: E402


def transform(x: float, yaw_deg: float = 0.0):
    turn = geometry.Rotation3d(0.0, math.radians(-20.0), math.radians(yaw_deg))
    return geometry.Transform3d(geometry.Translation3d(x, 0.1, 0.4), turn)


def program_of(*built: object) -> PhotonProgram:
    """Return a program that builds these in order: a camera by its name, an estimator by the x of its transform."""
    program = PhotonProgram()
    last: str | None = None
    for thing in built:
        if isinstance(thing, str):
            program.cameras[thing] = object()
            last = thing
        else:
            program.estimators.append(SeenEstimator(SimpleNamespace(robotToCamera=transform(thing)), last))
            last = None
    return program


def places(program: PhotonProgram) -> dict[str, float]:
    return {name: found.mount.x for name, found in mounts(program).items()}


@pytest.mark.parametrize(
    ("built", "expected"),
    [
        (("a", 0.1, "b", 0.2), {"a": 0.1, "b": 0.2}),
        (("a", "b", 0.1, 0.2), {"a": 0.1, "b": 0.2}),
        ((0.1, 0.2, "a", "b"), {"a": 0.1, "b": 0.2}),
        (("a", 0.1, "pieces"), {"a": 0.1}),
        (("pieces", "a", 0.1), {"a": 0.1}),
        (("a",), {}),
        ((0.1,), {}),
    ],
)
def test_estimators_belong_to_cameras_in_the_order_of_construction(built, expected):
    program = program_of(*built)
    assert places(program) == pytest.approx(expected)
    assert all(found.is_guess for found in mounts(program).values())


def test_an_estimator_belongs_to_the_camera_that_supplies_its_results():
    """By the order of construction, b would get the first estimator."""
    program = program_of("a", "b", 0.2, 0.1)
    first, second = program.estimators
    program.pair(first.estimator, "b")
    assert places(program) == pytest.approx({"a": 0.1, "b": 0.2})
    program.pair(second.estimator, "a")
    found = mounts(program)
    assert not found["a"].is_guess and "PhotonPoseEstimator" in found["a"].source
    version = program.version
    program.pair(second.estimator, "a")
    assert program.version == version


def test_the_next_robot_in_a_process_has_its_own_cameras():
    """Cameras built at the top of a module stay; cameras built by a robot end with the robot."""
    program = program_of("top", 0.1)
    program.begin()
    last = program_of("a", 0.2)
    program.cameras |= last.cameras
    program.estimators += last.estimators
    assert places(program) == pytest.approx({"top": 0.1, "a": 0.2})
    program.fed.add("a")
    program.begin()
    assert places(program) == pytest.approx({"top": 0.1}) and not program.fed


def test_a_vision_system_sim_takes_precedence_over_an_estimator():
    program = program_of("a", 0.1, "b", 0.2)
    program.transforms["a"] = transform(0.3, yaw_deg=90.0)
    found = mounts(program)
    assert (found["a"].mount.x, found["b"].mount.x) == (0.3, 0.2)
    assert found["a"].mount.pitch_deg == pytest.approx(-20.0) and found["a"].mount.yaw_deg == pytest.approx(90.0)
    assert found["a"].source == "VisionSystemSim.addCamera" and not found["a"].is_guess


def properties(**settings):
    """Return properties like `SimCameraProperties`, by default without noise, latency or a frame limit."""
    matrix = np.array([(500.0, 0.0, 320.0), (0.0, 510.0, 240.0), (0.0, 0.0, 1.0)])
    plain = {"avgErrorPx": 0.0, "errorStdDevPx": 0.0, "frameSpeed": 0.0, "avgLatency": 0.0}
    return SimpleNamespace(
        getResWidth=lambda: 640, getResHeight=lambda: 480, getIntrinsics=lambda: matrix, **{**plain, **settings}
    )


def test_the_camera_model_has_the_values_of_the_simulated_camera_properties():
    program = program_of("a")
    assert lens_of(program, "a") is PHOTON_LENS
    program.simulated["a"] = SimpleNamespace(
        prop=properties(avgErrorPx=0.3, errorStdDevPx=0.4, frameSpeed=0.05, avgLatency=0.035)
    )
    lens = lens_of(program, "a")
    assert (lens.width, lens.height) == (640, 480)
    assert lens.focal_length == pytest.approx((500.0, 510.0))
    assert lens.frame_rate == pytest.approx(20.0) and lens.pipeline_latency == 0.035
    # An error of mean 0.3 and deviation 0.4 in any direction has a mean square of 0.25, half of it along each axis.
    assert lens.corner_noise == pytest.approx(math.sqrt(0.125))


def test_perfect_camera_properties_get_default_errors():
    program = program_of("a")
    program.simulated["a"] = SimpleNamespace(prop=properties())
    lens = lens_of(program, "a")
    assert lens.corner_noise == PHOTON_LENS.corner_noise
    assert (lens.frame_rate, lens.pipeline_latency) == (PHOTON_LENS.frame_rate, PHOTON_LENS.pipeline_latency)
    program.simulated["a"].prop.avgLatency = 35.0  # in milliseconds, as photonlib's annotations say
    assert lens_of(program, "a").pipeline_latency == pytest.approx(0.035)


def test_a_camera_whose_targets_are_not_tags_detects_pieces():
    program = program_of("a", "b")
    for name, ids in (("a", (-1, -1)), ("b", (-1, 7))):
        targets = [SimpleNamespace(fiducialId=number) for number in ids]
        program.systems[name] = SimpleNamespace(getVisionTargets=lambda targets=targets: targets)
    assert pipeline_of(program, "a").kind == "pieces"
    assert pipeline_of(program, "b").kind == "tags"
    assert pipeline_of(program, "c").kind == "tags"
