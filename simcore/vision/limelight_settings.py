"""Camera settings that robot code can change by requests. An invalid request changes nothing and returns the reason."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from simcore.vision.camera import FULL_CROP, CameraConfig, CameraMount
from simcore.world.rotation import Quaternion, Vector, from_rpy

__all__ = ["INPUTS", "NOT_MODELED", "NO_EFFECT", "CameraSettings", "limelight_mount"]

_DOWNSCALES = (0.0, 1.0, 1.5, 2.0, 3.0, 4.0)  # by index in `fiducial_downscale_set`; 0 for the pipeline's value

Values = Sequence[float]


@dataclass(slots=True)
class CameraSettings:
    """Current settings of a camera, which `apply` and `LimelightSim.move_to` change."""

    config: CameraConfig
    pipeline: int = 0
    """Number of the current pipeline."""
    priority_id: int = -1
    """Id of the tag whose angles are published if visible; -1 for the largest tag."""
    crop: tuple[float, float, float, float] = FULL_CROP
    """Crop window x0, x1, y0, y1, each within -1 to 1, as in `FULL_CROP`."""
    id_filters: tuple[int, ...] | None = None
    """Ids of the tags to use; None for the ids of the pipeline."""
    downscale: float = 0.0
    """Downscale factor [-]; 0 for the factor of the pipeline."""
    throttle: int = 0
    """Number of frames to skip after each processed frame."""
    is_driver_camera: bool = False
    """Whether the camera is in driver camera mode, without image processing."""
    imu_mode: int = 0
    """IMU mode, 0 to 4, as defined by `HeadingSource`."""
    imu_assist: float = 0.001
    """Weight of the correction in IMU modes 3 and 4, per IMU sample of 1 ms [-]."""
    mount: tuple[float, float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    """Configured camera pose on the robot: forward, right, up [m], roll, pitch (positive up), yaw [deg]."""
    version: int = field(default=0)
    """Number of changes of the settings so far."""

    @classmethod
    def of(cls, config: CameraConfig) -> CameraSettings:
        """Return the settings at power-on, with the mount from the config."""
        return cls(config, mount=limelight_mount(config.mount))

    def apply(self, topic: str, values: Values) -> str | None:
        """Apply a request from robot code to the setting of a topic.

        Args:
            topic: Name of the topic, a key of `INPUTS`.
            values: Numbers of the request; a single number is a sequence of length one.

        Returns:
            None if the request is valid, otherwise the reason for the rejection. A rejected request changes nothing.
        """
        if not all(math.isfinite(v) for v in values):
            return f"needs finite numbers, got {list(values)}"
        setting = INPUTS[topic]
        if setting.length is not None and len(values) != setting.length:
            return f"needs {setting.length} number{'s' if setting.length > 1 else ''}, got {len(values)}"
        got = f"{values[0]:g}" if setting.length == 1 else str(list(values))
        if topic == "pipeline" and values[0] not in range(len(self.config.pipelines)):
            last = len(self.config.pipelines) - 1
            known = f"0 to {last}" if last else "only 0"
            return f'no pipeline {got}; this camera has {known}; mode = ["tags", "pieces"] makes two'
        if not setting.is_valid(values):
            return f"needs {setting.needs}, got {got}"
        setattr(self, setting.name, setting.of(values))
        self.version += 1
        return None

    @property
    def believed_mount(self) -> tuple[Vector, Quaternion]:
        """Configured position [m] and attitude (camera to robot axes) of the camera on the robot."""
        ahead, right, up, roll, pitch, yaw = self.mount
        turn = from_rpy(math.radians(roll), -math.radians(pitch), math.radians(yaw))
        return (ahead, -right, up), turn


@dataclass(frozen=True, slots=True)
class _Setting:
    """Setting that robot code changes through a NetworkTables topic."""

    name: str
    """Name of the field in `CameraSettings`."""
    length: int | None
    """Required count of numbers; None for any count."""
    needs: str
    """Description of valid numbers, for messages."""
    is_valid: Callable[[Values], bool]
    """Function that returns whether finite numbers of the required count are valid."""
    of: Callable[[Values], object]
    """Function that converts valid numbers to the value of the field."""


def _is_whole(values: Values, least: float, most: float = math.inf) -> bool:
    return all(v == math.floor(v) and least <= v <= most for v in values)


def _first(values: Values) -> int:
    return int(values[0])


INPUTS = {
    "pipeline": _Setting("pipeline", 1, "a pipeline", lambda v: True, _first),
    "priorityid": _Setting("priority_id", 1, "a tag's id, or -1 for none", lambda v: _is_whole(v, -1), _first),
    "crop": _Setting(
        "crop", 4, "x0 < x1 and y0 < y1 within -1 to 1",
        lambda v: -1.0 <= v[0] < v[1] <= 1.0 and -1.0 <= v[2] < v[3] <= 1.0, tuple,
    ),
    "fiducial_id_filters_set": _Setting(
        "id_filters", None, "ids of tags", lambda v: _is_whole(v, 0), lambda v: tuple(map(int, v)) or None
    ),
    "fiducial_downscale_set": _Setting(
        "downscale", 1, f"0 (as the pipeline) or 1 to 5 for {_DOWNSCALES[1:]}",
        lambda v: _is_whole(v, 0, len(_DOWNSCALES) - 1), lambda v: _DOWNSCALES[int(v[0])],
    ),
    "throttle_set": _Setting("throttle", 1, "how many frames to skip", lambda v: _is_whole(v, 0), _first),
    "camMode": _Setting(
        "is_driver_camera", 1, "0 (vision) or 1 (driver camera)", lambda v: v[0] in (0.0, 1.0), lambda v: v[0] == 1.0
    ),
    "imumode_set": _Setting("imu_mode", 1, "a mode from 0 to 4", lambda v: _is_whole(v, 0, 4), _first),
    "imuassistalpha_set": _Setting(
        "imu_assist", 1, "a weight from 0 to 1", lambda v: 0.0 <= v[0] <= 1.0, lambda v: v[0]
    ),
    "camerapose_robotspace_set": _Setting("mount", 6, "a place and angles", lambda v: True, tuple),
}  # fmt: skip
"""Settings by topic. `robot_orientation_set` is not included, because `HeadingSource` keeps all recent orientations."""

NO_EFFECT = {
    "ledMode": "there are no lights",
    "stream": "there is no picture",
    "snapshot": "there is no picture",
    "rewind_enable_set": "nothing is recorded",
    "capture_rewind": "nothing is recorded",
    "llrobot": "a Python pipeline would read it, and there is none",
}
"""Topics of a real Limelight that have no effect on the simulated output, each with the reason for log messages."""

NOT_MODELED = ("fiducial_offset_set", "keystone_set")
"""Topics of a real Limelight that affect the camera's output but are not modeled in simulation."""


def limelight_mount(mount: CameraMount) -> tuple[float, float, float, float, float, float]:
    """Convert a mount to Limelight robot space: forward, right, up [m]; roll, pitch (positive up), yaw [deg]."""
    return mount.x, -mount.y, mount.z, mount.roll_deg, -mount.pitch_deg, mount.yaw_deg
