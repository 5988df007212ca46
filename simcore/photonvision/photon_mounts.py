"""Where the cameras of a robot program sit and what they are, as its own code says."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from simcore.photonvision.photon_program import PhotonProgram
from simcore.vision.camera import CameraMount, LimelightType, PiecePipeline, Pipeline, TagPipeline
from simcore.vision.photon_lens import PHOTON_LENS

__all__ = ["FoundMount", "lens_of", "mounts", "pipeline_of"]

_SECOND = 1.0  # a latency of more than this [s] was meant in milliseconds, as photonlib's annotations say


@dataclass(frozen=True, slots=True)
class FoundMount:
    """Where a camera sits."""

    mount: CameraMount
    source: str
    """Who says so."""
    is_guess: bool = False
    """Whether it rests on the order in which things were built."""


def mounts(program: PhotonProgram) -> dict[str, FoundMount]:
    """Mounts by camera, of those whose code tells it.

    A `VisionSystemSim` names its cameras. A `PhotonPoseEstimator` has a transform but no camera: it belongs to the one
    whose results it is given. Until it was given any, estimators and cameras that are left over belong together in
    their order if there are as many of both; else an estimator belongs to the camera that was built just before it.
    """
    found: dict[str, FoundMount] = {}
    for name, transform in program.transforms.items():
        if transform is not None:
            found[name] = FoundMount(_mount(transform), "VisionSystemSim.addCamera")
    for seen in program.estimators:
        if seen.camera is not None and seen.camera not in found and seen.robot_to_camera is not None:
            found[seen.camera] = FoundMount(_mount(seen.robot_to_camera), "its PhotonPoseEstimator")
    tied = {seen.camera for seen in program.estimators}
    cameras = [name for name in program.cameras if name not in tied]
    loose = [seen for seen in program.estimators if seen.camera is None]
    in_order = len(cameras) == len(loose)
    for k, seen in enumerate(loose):
        camera = cameras[k] if in_order else seen.after
        if camera is not None and camera not in found and seen.robot_to_camera is not None:
            source = "the PhotonPoseEstimator built with it"
            found[camera] = FoundMount(_mount(seen.robot_to_camera), source, is_guess=True)
    return found


def lens_of(program: PhotonProgram, name: str) -> LimelightType:
    """What a camera is: as its `SimCameraProperties` say, if the program has any, else `PHOTON_LENS`.

    Properties without noise, latency or limit of frames, as photonlib's defaults are, get those of `PHOTON_LENS`.
    """
    simulated = program.simulated.get(name)
    if simulated is None:
        return PHOTON_LENS
    properties: Any = simulated.prop
    width, height = int(properties.getResWidth()), int(properties.getResHeight())
    matrix = properties.getIntrinsics()
    noise = math.sqrt((properties.avgErrorPx**2 + properties.errorStdDevPx**2) / 2.0)  # in each direction
    latency = float(properties.avgLatency)
    if latency > _SECOND:
        latency *= 1e-3
    period = float(properties.frameSpeed)
    return replace(
        PHOTON_LENS,
        name="SimCameraProperties",
        width=width,
        height=height,
        horizontal_fov_deg=_field_of_view(width, float(matrix[0, 0])),
        vertical_fov_deg=_field_of_view(height, float(matrix[1, 1])),
        frame_rate=1.0 / period if 1e-3 < period < _SECOND else PHOTON_LENS.frame_rate,
        pipeline_latency=latency if latency > 0.0 else PHOTON_LENS.pipeline_latency,
        corner_noise=noise if noise > 0.0 else PHOTON_LENS.corner_noise,
    )


def pipeline_of(program: PhotonProgram, name: str) -> Pipeline:
    """What a camera looks for: pieces where its `VisionSystemSim` has targets and none of them is a tag."""
    system = program.systems.get(name)
    targets = [] if system is None else system.getVisionTargets()
    return PiecePipeline() if targets and all(target.fiducialId < 0 for target in targets) else TagPipeline()


def _field_of_view(pixels: int, focal_length: float) -> float:
    return math.degrees(2.0 * math.atan(0.5 * pixels / focal_length))


def _mount(transform: Any) -> CameraMount:
    place, turn = transform.translation(), transform.rotation()
    return CameraMount(
        x=place.X(),
        y=place.Y(),
        z=place.Z(),
        roll_deg=math.degrees(turn.X()),
        pitch_deg=math.degrees(turn.Y()),
        yaw_deg=math.degrees(turn.Z()),
    )
