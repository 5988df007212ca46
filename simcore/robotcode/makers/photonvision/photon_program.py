"""Record of the photonlibpy objects that a robot program builds: cameras, camera models and camera mountings.

This module wraps the classes of photonlibpy only when the program loads photonlibpy. Wrapped classes work as before,
with two exceptions. A `PhotonCameraSim` publishes nothing if simcore publishes the results,
so that each camera has one publisher. A `VisionSystemSim` is updated with the robot's true pose, because the program's
own estimate would confirm itself.
"""

from __future__ import annotations

import functools
import gc
import logging
import math
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from simcore.robotcode.program.recorder import Arguments, Settings, after_call, record_class
from simcore.vision.camera import PHOTON_LENS, CameraMount, LimelightType, PiecePipeline, Pipeline, TagPipeline

__all__ = [
    "HOOKS",
    "FoundMount",
    "PhotonProgram",
    "SeenEstimator",
    "lens_of",
    "mounts",
    "photon_program",
    "pipeline_of",
]

_log = logging.getLogger(__name__)

_TAG = "_simcore_camera"
_SECOND = 1.0  # [s], largest plausible latency; a larger value is in milliseconds, as in photonlib's annotations


@dataclass(slots=True, eq=False)
class SeenEstimator:
    """`PhotonPoseEstimator` that the program has built, and the estimator's camera."""

    estimator: Any
    after: str | None
    """Name of the camera built last before the estimator, or None if another estimator was built in between."""
    camera: str | None = None
    """Name of the camera whose results the estimator processes; None while unknown."""

    @property
    def robot_to_camera(self) -> Any:
        """Current robot-to-camera transform of the estimator."""
        attributes = vars(self.estimator)
        return attributes.get("robotToCamera", attributes.get("_robotToCamera"))


@dataclass(slots=True)
class PhotonProgram:
    """PhotonVision objects of one robot program, in build order."""

    cameras: dict[str, Any] = field(default_factory=dict)
    """`PhotonCamera` objects by camera name."""
    estimators: list[SeenEstimator] = field(default_factory=list)
    simulated: dict[str, Any] = field(default_factory=dict)
    """`PhotonCameraSim` objects of the program's own simulation, by camera name."""
    transforms: dict[str, Any] = field(default_factory=dict)
    """Robot-to-camera transform last passed to a `VisionSystemSim`, by camera name."""
    systems: dict[str, Any] = field(default_factory=dict)
    """`VisionSystemSim` of each simulated camera, by camera name."""
    fed: set[str] = field(default_factory=set)
    """Names of the cameras whose results simcore publishes."""
    true_pose: Callable[[], Any] | None = None
    """Function that returns the robot's true pose as a `Pose3d`; None before the robot is on the field."""
    version: int = 0
    """Number of changes so far to the recorded objects, their transforms and their cameras."""
    dropped: int = 0
    """Number of frames from the program's own simulation that simcore has dropped."""
    _of_modules: tuple[list[dict[str, Any]], list[SeenEstimator]] | None = None

    def pair(self, estimator: Any, camera: str) -> None:
        """Record that an estimator has processed a result of a camera."""
        for seen in self.estimators:
            if seen.estimator is estimator and seen.camera != camera:
                seen.camera = camera
                self.version += 1

    def begin(self) -> None:
        """Drop the objects of the previous robot in this process, except module-level objects.

        Robot code is imported only once, so module-level objects belong to every robot.
        """
        things = (self.cameras, self.simulated, self.transforms, self.systems)
        if self._of_modules is None:
            self._of_modules = [dict(some) for some in things], list(self.estimators)
        for some, kept in zip(things, self._of_modules[0], strict=True):
            some.clear()
            some.update(kept)
        self.estimators[:] = self._of_modules[1]
        self.fed.clear()
        self.true_pose = None
        self.version += 1


_program = PhotonProgram()


def photon_program() -> PhotonProgram:
    """Return the PhotonVision objects of this process's robot program."""
    return _program


# --- models and mountings of the cameras ----------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class FoundMount:
    """Mounting of a camera as found in the program, and the source of the mounting."""

    mount: CameraMount
    source: str
    """Part of the program that gives the mounting, as a phrase for messages."""
    is_guess: bool = False
    """Whether camera and mounting are matched only by build order."""


def mounts(program: PhotonProgram) -> dict[str, FoundMount]:
    """Return the known camera mountings by camera name.

    A `VisionSystemSim` names its cameras. A `PhotonPoseEstimator` has a transform but no camera, so the function
    matches the estimator to the camera whose results the estimator processes. The function matches estimators without
    results to the remaining cameras in build order if the counts agree, else to the camera built just before.
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
    """Return the model of a camera from its `SimCameraProperties`, or `PHOTON_LENS` without a simulated camera.

    Noise, latency and frame rate come from `PHOTON_LENS` if the program leaves photonlib's default of zero.
    """
    simulated = program.simulated.get(name)
    if simulated is None:
        return PHOTON_LENS
    properties: Any = simulated.prop
    width, height = int(properties.getResWidth()), int(properties.getResHeight())
    matrix = properties.getIntrinsics()
    noise = math.sqrt((properties.avgErrorPx**2 + properties.errorStdDevPx**2) / 2.0)  # per image axis
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
    """Return a piece pipeline for a camera whose `VisionSystemSim` has only non-tag targets, else a tag pipeline."""
    system = program.systems.get(name)
    targets = [] if system is None else system.getVisionTargets()
    return PiecePipeline() if targets and all(target.fiducialId < 0 for target in targets) else TagPipeline()


def _field_of_view(pixels: int, focal_length: float) -> float:
    return math.degrees(2.0 * math.atan(0.5 * pixels / focal_length))


def _mount(transform: Any) -> CameraMount:
    place, turn = transform.translation(), transform.rotation()
    return CameraMount(
        x=place.x,
        y=place.y,
        z=place.z,
        roll_deg=math.degrees(turn.x),
        pitch_deg=math.degrees(turn.y),
        yaw_deg=math.degrees(turn.z),
    )


# --- hooks for modules as they are loaded -------------------------------------------------------------------------


def _hook_camera(module: Any) -> None:
    _watch(module.PhotonCamera, _camera_built, {"getAllUnreadResults": _tag_results, "getLatestResult": _tag_results})


def _hook_estimator(module: Any) -> None:
    cls = module.PhotonPoseEstimator
    methods = [
        name for name, method in vars(cls).items() if callable(method) and name.startswith(("estimate", "update"))
    ]
    _watch(cls, _estimator_built, dict.fromkeys(methods, _pair_camera))


def _hook_camera_sim(module: Any) -> None:
    cls = module.PhotonCameraSim
    _watch(cls, _camera_simulated, {})
    for name in ("consumeNextEntryTime", "submitProcessedFrame"):
        _surround(cls, name, _drop_frame)


def _hook_vision_system(module: Any) -> None:
    cls = module.VisionSystemSim
    _watch(cls, _system_built, {"addCamera": _place_camera, "adjustCamera": _place_camera})
    for name in ("update", "resetRobotPose"):
        _surround(cls, name, _update_with_truth)


def _hook_time_sync(module: Any) -> None:
    """Disable the time server, which no simulated camera needs and whose port two programs could not share."""
    module.TimeSyncServer.start = lambda self: None


HOOKS: dict[str, Callable[[Any], None]] = {
    "photonlibpy.timesync.timeSyncServer": _hook_time_sync,
    "photonlibpy.photonCamera": _hook_camera,
    "photonlibpy.photonPoseEstimator": _hook_estimator,
    "photonlibpy.simulation.photonCameraSim": _hook_camera_sim,
    "photonlibpy.simulation.visionSystemSim": _hook_vision_system,
}
"""Hook for each photonlibpy module, to call with the loaded module."""


# --- built objects ------------------------------------------------------------------------------------------------


def _camera_built(camera: Any, args: Arguments, settings: Settings) -> None:
    _program.cameras[str(camera.getName())] = camera
    _program.version += 1


def _estimator_built(estimator: Any, args: Arguments, settings: Settings) -> None:
    kind = sys.modules["photonlibpy.photonCamera"].PhotonCamera  # an argument of the constructor until 2026.1
    given = next((str(a.getName()) for a in (*args, *settings.values()) if isinstance(a, kind)), None)
    last = next(reversed(_program.cameras), None)
    if any(seen.after == last for seen in _program.estimators):
        last = None
    _program.estimators.append(SeenEstimator(estimator, last, given))
    _program.version += 1


def _camera_simulated(camera_sim: Any, args: Arguments, settings: Settings) -> None:
    _program.simulated[_name_of(camera_sim)] = camera_sim
    _program.version += 1


def _system_built(system: Any, args: Arguments, settings: Settings) -> None:
    for camera, buffer in getattr(system, "camTrfMap", {}).items():
        _, pose = buffer.getInternalBuffer()[-1]
        _camera_placed(system, camera, pose - type(pose)())


def _camera_placed(system: Any, camera_sim: Any = None, robot_to_camera: Any = None, **given: Any) -> None:
    camera_sim = given.get("cameraSim", camera_sim)
    robot_to_camera = given.get("robotToCamera", robot_to_camera)
    name = _name_of(camera_sim)
    _program.systems[name] = system
    _program.transforms[name] = robot_to_camera
    _program.version += 1


# --- wrapping -----------------------------------------------------------------------------------------------------


def _watch(
    cls: Any,
    built: Callable[[Any, Arguments, Settings], None],
    called: Mapping[str, Callable[[Any, Any, Arguments, Settings], None]],
) -> None:
    """Call `built` for a class's existing and future objects, and `called[name]` after each call of a method."""
    record_class(cls, built)
    for name, note in called.items():
        if hasattr(cls, name):
            after_call(cls, name, note)
    for thing in _alive(cls):
        built(thing, (), {})


def _surround(cls: Any, name: str, call: Callable[..., Any]) -> None:
    """Replace a method with `call`, which receives the original method, the object and the arguments."""
    method = getattr(cls, name, None)
    if method is not None:

        @functools.wraps(method)
        def both(self: Any, *args: Any, **settings: Any) -> Any:
            return call(method, self, *args, **settings)

        setattr(cls, name, both)


def _alive(cls: Any) -> list[Any]:
    """List the objects of a class that the program built before the class was watched."""
    if getattr(sys.modules[cls.__module__].__spec__, "_initializing", False):
        return []  # the module is being loaded right now
    # Use type(): isinstance raises for a dead weak proxy.
    return [thing for thing in gc.get_objects() if issubclass(type(thing), cls)]


def _name_of(camera_sim: Any) -> str:
    return str(camera_sim.getCamera().getName())


def _tag_results(camera: Any, results: Any, args: Arguments, settings: Settings) -> None:
    """Store the camera's name in an attribute of each result."""
    for result in results if isinstance(results, list) else [results]:
        setattr(result, _TAG, camera.getName())


def _pair_camera(estimator: Any, _: Any, args: Arguments, settings: Settings) -> None:
    """Match an estimator to the camera whose results the estimator processes."""
    for argument in (*args, *settings.values()):
        camera = getattr(argument, _TAG, None)
        if camera is not None:
            _program.pair(estimator, camera)


def _place_camera(system: Any, _: Any, args: Arguments, settings: Settings) -> None:
    _camera_placed(system, *args, **settings)


def _drop_frame(method: Callable[..., Any], camera_sim: Any, *args: Any, **kwargs: Any) -> Any:
    """Drop a frame of the program's own simulation if simcore publishes the camera's results."""
    if _name_of(camera_sim) in _program.fed:
        _program.dropped += 1
        return None
    return method(camera_sim, *args, **kwargs)


def _update_with_truth(method: Callable[..., Any], system: Any, *args: Any, **kwargs: Any) -> Any:
    if _program.true_pose is None:
        return method(system, *args, **kwargs)
    return method(system, _program.true_pose())
