"""Settings of a camera that robot code can change; an invalid request changes nothing and gives a reason."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from simcore.vision.camera import FULL_CROP, CameraConfig, CameraMount
from simcore.world.rotation import Quaternion, Vector, from_rpy

__all__ = ["INPUTS", "NOT_MODELED", "NO_EFFECT", "CameraSettings", "limelight_mount"]

_DOWNSCALES = (0.0, 1.0, 1.5, 2.0, 3.0, 4.0)  # by index in `fiducial_downscale_set`; 0 is the pipeline's own value

Values = Sequence[float]


@dataclass(slots=True)
class CameraSettings:
    """Present settings of one camera. `apply` is the only way to change them."""

    config: CameraConfig
    pipeline: int = 0
    priority_id: int = -1
    """Id of the tag whose angles are published if it is seen; -1: the largest."""
    crop: tuple[float, float, float, float] = FULL_CROP
    id_filters: tuple[int, ...] | None = None
    """Tags to use; None: those of the pipeline."""
    downscale: float = 0.0
    """Downscale factor; 0: that of the pipeline."""
    throttle: int = 0
    """Frames that are skipped after each processed one."""
    is_driver_camera: bool = False
    """Whether pictures go to the driver and are not processed."""
    imu_mode: int = 0
    imu_assist: float = 0.001
    mount: tuple[float, float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    """Configured camera pose on the robot: ahead, right, up [m], roll, pitch (up positive), yaw [deg]."""
    version: int = field(default=0)
    """Number of changes so far."""

    @classmethod
    def of(cls, config: CameraConfig) -> CameraSettings:
        """Return the settings at power-on: the camera knows its mount."""
        return cls(config, mount=limelight_mount(config.mount))

    def apply(self, topic: str, values: Values) -> str | None:
        """Apply one request.

        Args:
            topic: Name of the topic, one of `INPUTS`.
            values: Numbers of the request; a lone number is a sequence of one.

        Returns:
            None if it was accepted, else the reason for refusing it; then nothing has changed.
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
    """Setting behind one topic."""

    name: str
    """Name of the field of `CameraSettings`."""
    length: int | None
    """Count of numbers that it needs; None: any."""
    needs: str
    """Description of valid numbers."""
    is_valid: Callable[[Values], bool]
    of: Callable[[Values], object]
    """Conversion of valid numbers to the field's value."""


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
"""Topics that change a setting. `robot_orientation_set` is not here: the camera keeps its history."""

NO_EFFECT = {
    "ledMode": "there are no lights",
    "stream": "there is no picture",
    "snapshot": "there is no picture",
    "rewind_enable_set": "nothing is recorded",
    "capture_rewind": "nothing is recorded",
    "llrobot": "a Python pipeline would read it, and there is none",
}
"""Topics that a Limelight reads and that change nothing that robot code can read back, with the reason."""

NOT_MODELED = ("fiducial_offset_set", "keystone_set")
"""Topics that a Limelight reads and that would change its output if they were modeled."""


def limelight_mount(mount: CameraMount) -> tuple[float, float, float, float, float, float]:
    """Convert a mount to Limelight robot space: ahead, right, up [m]; roll, pitch (up positive), yaw [deg]."""
    return mount.x, -mount.y, mount.z, mount.roll_deg, -mount.pitch_deg, mount.yaw_deg
