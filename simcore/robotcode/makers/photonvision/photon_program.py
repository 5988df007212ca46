"""Objects of photonlibpy that a robot program builds: its cameras, their lenses and their mountings.

Classes of photonlibpy are wrapped when they are loaded, not before: most programs do not use them. Wrapped classes
work as before, with two exceptions: a simulated camera that simcore feeds publishes nothing itself, so that there is
one publisher, and a `VisionSystemSim` is updated with the robot's true pose instead of the program's
estimate, which would confirm itself.
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
_SECOND = 1.0  # [s]; a larger latency was meant in milliseconds, as photonlib's annotations say


@dataclass(slots=True, eq=False)
class SeenEstimator:
    """A `PhotonPoseEstimator` that the program has built."""

    estimator: Any
    after: str | None
    """Camera built last before it, if no other estimator came in between."""
    camera: str | None = None
    """Camera whose results it gets, or which it was built with; None: unknown so far."""

    @property
    def robot_to_camera(self) -> Any:
        """Present transform."""
        attributes = vars(self.estimator)
        return attributes.get("robotToCamera", attributes.get("_robotToCamera"))


@dataclass(slots=True)
class PhotonProgram:
    """Cameras of one robot program, by name and in building order."""

    cameras: dict[str, Any] = field(default_factory=dict)
    """Cameras by name (`PhotonCamera`)."""
    estimators: list[SeenEstimator] = field(default_factory=list)
    simulated: dict[str, Any] = field(default_factory=dict)
    """Simulated cameras of the program's own simulation (`PhotonCameraSim`)."""
    transforms: dict[str, Any] = field(default_factory=dict)
    """Robot to camera, as last passed to a `VisionSystemSim`."""
    systems: dict[str, Any] = field(default_factory=dict)
    """Simulation of each camera (`VisionSystemSim`)."""
    fed: set[str] = field(default_factory=set)
    """Cameras that simcore feeds."""
    true_pose: Callable[[], Any] | None = None
    """Returns the robot's pose as a `Pose3d`; None: unknown."""
    version: int = 0
    """Counter of built objects and of new facts about them."""
    dropped: int = 0
    """Number of unpublished frames of the program's own simulation."""
    _of_modules: tuple[list[dict[str, Any]], list[SeenEstimator]] | None = None

    def pair(self, estimator: Any, camera: str) -> None:
        """Record that an estimator got a result of a camera."""
        for seen in self.estimators:
            if seen.estimator is estimator and seen.camera != camera:
                seen.camera = camera
                self.version += 1

    def begin(self) -> None:
        """Forget the objects of the previous robot in this process, but not those of its modules.

        Robot code is imported once, so that objects at the top of its files belong to every robot.
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
    """Return the program of this process."""
    return _program


# --- lenses and mountings of its cameras ----------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class FoundMount:
    """Mounting of a camera."""

    mount: CameraMount
    source: str
    """Source of the mounting."""
    is_guess: bool = False
    """Whether it rests on the building order."""


def mounts(program: PhotonProgram) -> dict[str, FoundMount]:
    """Return mountings by camera, of those whose code gives one.

    A `VisionSystemSim` names its cameras. A `PhotonPoseEstimator` has a transform but no camera: it belongs to the one
    whose results it gets. Until it has got any, remaining estimators and cameras belong together in
    their order if their numbers agree; else an estimator belongs to the camera built just before it.
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
    """Return the lens of a camera by its `SimCameraProperties`, if the program has any, else `PHOTON_LENS`.

    Properties without noise, latency or frame limit, such as photonlib's defaults, get those of `PHOTON_LENS`.
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
    """Return the pipeline of a camera: pieces where its `VisionSystemSim` has targets and none of them is a tag."""
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
    """Replace the time server: no coprocessor's clock needs it, and a second program could not have its port."""
    module.TimeSyncServer.start = lambda self: None


HOOKS: dict[str, Callable[[Any], None]] = {
    "photonlibpy.timesync.timeSyncServer": _hook_time_sync,
    "photonlibpy.photonCamera": _hook_camera,
    "photonlibpy.photonPoseEstimator": _hook_estimator,
    "photonlibpy.simulation.photonCameraSim": _hook_camera_sim,
    "photonlibpy.simulation.visionSystemSim": _hook_vision_system,
}
"""Hooks to call with modules of photonlibpy once they are loaded."""


# --- built objects ------------------------------------------------------------------------------------------------


def _camera_built(camera: Any, args: Arguments, settings: Settings) -> None:
    _program.cameras[str(camera.getName())] = camera
    _program.version += 1


def _estimator_built(estimator: Any, args: Arguments, settings: Settings) -> None:
    kind = sys.modules["photonlibpy.photonCamera"].PhotonCamera  # until 2026.1 an estimator was built with its camera
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
    """Observe objects that a class builds and has built, and calls of its methods, by name."""
    record_class(cls, built)
    for name, note in called.items():
        if hasattr(cls, name):
            after_call(cls, name, note)
    for thing in _alive(cls):
        built(thing, (), {})


def _surround(cls: Any, name: str, call: Callable[..., Any]) -> None:
    """Call a function in place of a method, with the method, the object and the arguments."""
    method = getattr(cls, name, None)
    if method is not None:

        @functools.wraps(method)
        def both(self: Any, *args: Any, **settings: Any) -> Any:
            return call(method, self, *args, **settings)

        setattr(cls, name, both)


def _alive(cls: Any) -> list[Any]:
    """List objects that a program has built before its module was watched: next to imports, at the top of a file."""
    if getattr(sys.modules[cls.__module__].__spec__, "_initializing", False):
        return []  # it is being loaded right now
    # By type(): a weak reference that has died answers isinstance with an error.
    return [thing for thing in gc.get_objects() if issubclass(type(thing), cls)]


def _name_of(camera_sim: Any) -> str:
    return str(camera_sim.getCamera().getName())


def _tag_results(camera: Any, results: Any, args: Arguments, settings: Settings) -> None:
    """Tag results with their camera."""
    for result in results if isinstance(results, list) else [results]:
        setattr(result, _TAG, camera.getName())


def _pair_camera(estimator: Any, _: Any, args: Arguments, settings: Settings) -> None:
    """Record that an estimator belongs to the camera whose results it gets."""
    for argument in (*args, *settings.values()):
        camera = getattr(argument, _TAG, None)
        if camera is not None:
            _program.pair(estimator, camera)


def _place_camera(system: Any, _: Any, args: Arguments, settings: Settings) -> None:
    _camera_placed(system, *args, **settings)


def _drop_frame(method: Callable[..., Any], camera_sim: Any, *args: Any, **kwargs: Any) -> Any:
    """Drop output of the program's own simulation of a camera that simcore feeds."""
    if _name_of(camera_sim) in _program.fed:
        _program.dropped += 1
        return None
    return method(camera_sim, *args, **kwargs)


def _update_with_truth(method: Callable[..., Any], system: Any, *args: Any, **kwargs: Any) -> Any:
    if _program.true_pose is None:
        return method(system, *args, **kwargs)
    return method(system, _program.true_pose())
