"""Settings of a camera that robot code can change, checked: an invalid request changes nothing, with a reason."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from simcore.geometry.rotation import Quaternion, Vector, from_rpy
from simcore.vision.camera import FULL_CROP, CameraConfig, CameraMount

__all__ = ["INPUTS", "NOT_MODELED", "NO_EFFECT", "CameraSettings", "limelight_mount"]

_DOWNSCALES = (0.0, 1.0, 1.5, 2.0, 3.0, 4.0)  # of `fiducial_downscale_set`; 0 is that of the pipeline

Values = Sequence[float]


@dataclass(slots=True)
class CameraSettings:
    """The present state of one camera's settings. `apply` is the only way to change it."""

    config: CameraConfig
    pipeline: int = 0
    priority_id: int = -1
    """Tag whose angles are published if it is seen; -1: the largest."""
    crop: tuple[float, float, float, float] = FULL_CROP
    id_filters: tuple[int, ...] | None = None
    """Tags to use; None: those of the pipeline."""
    downscale: float = 0.0
    """0: that of the pipeline."""
    throttle: int = 0
    """Frames that are skipped after each that is worked through."""
    is_driver_camera: bool = False
    """Whether pictures go to the driver and nothing is looked for."""
    imu_mode: int = 0
    imu_assist: float = 0.001
    mount: tuple[float, float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    """Where the camera believes to sit: ahead, right, up [m], roll, pitch (up positive), yaw [deg]."""
    version: int = field(default=0)
    """Counts changes."""

    @classmethod
    def of(cls, config: CameraConfig) -> CameraSettings:
        """As the camera starts: it knows where it sits."""
        return cls(config, mount=limelight_mount(config.mount))

    def apply(self, topic: str, values: Values) -> str | None:
        """One request.

        Args:
            topic: One of `INPUTS`.
            values: Its numbers; a lone number is a sequence of one.

        Returns:
            None if it was taken, else what is wrong with it; then nothing has changed.
        """
        if not all(math.isfinite(v) for v in values):
            return f"needs finite numbers, got {list(values)}"
        length, setter = INPUTS[topic]
        if length is not None and len(values) != length:
            return f"needs {length} number{'s' if length > 1 else ''}, got {len(values)}"
        problem = setter(self, values)
        if problem is None:
            self.version += 1
        return problem

    @property
    def believed_mount(self) -> tuple[Vector, Quaternion]:
        """Place [m] and attitude (camera to robot axes) on the robot, as the camera believes."""
        ahead, right, up, roll, pitch, yaw = self.mount
        turn = from_rpy(math.radians(roll), -math.radians(pitch), math.radians(yaw))
        return (ahead, -right, up), turn

    # --- one setter a topic -------------------------------------------------------------------------------------

    def _set_pipeline(self, values: Values) -> str | None:
        n = len(self.config.pipelines)
        if not _is_whole(values[0]) or not 0 <= values[0] < n:
            known = f"0 to {n - 1}" if n > 1 else "only 0"
            return f'no pipeline {values[0]:g}; this camera has {known}; mode = ["tags", "pieces"] makes two'
        self.pipeline = int(values[0])
        return None

    def _set_priority(self, values: Values) -> str | None:
        if not _is_whole(values[0]) or values[0] < -1:
            return f"needs a tag's id, or -1 for none, got {values[0]:g}"
        self.priority_id = int(values[0])
        return None

    def _set_crop(self, values: Values) -> str | None:
        x0, x1, y0, y1 = values
        if not (-1.0 <= x0 < x1 <= 1.0 and -1.0 <= y0 < y1 <= 1.0):
            return f"needs x0 < x1 and y0 < y1 within -1 to 1, got {list(values)}"
        self.crop = (x0, x1, y0, y1)
        return None

    def _set_filters(self, values: Values) -> str | None:
        if not all(_is_whole(v) and v >= 0 for v in values):
            return f"needs ids of tags, got {list(values)}"
        self.id_filters = tuple(int(v) for v in values) or None
        return None

    def _set_downscale(self, values: Values) -> str | None:
        if not _is_whole(values[0]) or not 0 <= values[0] < len(_DOWNSCALES):
            return f"needs 0 (as the pipeline) or 1 to 5 for {_DOWNSCALES[1:]}, got {values[0]:g}"
        self.downscale = _DOWNSCALES[int(values[0])]
        return None

    def _set_throttle(self, values: Values) -> str | None:
        if not _is_whole(values[0]) or values[0] < 0:
            return f"needs how many frames to skip, got {values[0]:g}"
        self.throttle = int(values[0])
        return None

    def _set_camera_mode(self, values: Values) -> str | None:
        if values[0] not in (0.0, 1.0):
            return f"needs 0 (vision) or 1 (driver camera), got {values[0]:g}"
        self.is_driver_camera = values[0] == 1.0
        return None

    def _set_imu_mode(self, values: Values) -> str | None:
        if not _is_whole(values[0]) or not 0 <= values[0] <= 4:
            return f"needs a mode from 0 to 4, got {values[0]:g}"
        self.imu_mode = int(values[0])
        return None

    def _set_imu_assist(self, values: Values) -> str | None:
        if not 0.0 <= values[0] <= 1.0:
            return f"needs a weight from 0 to 1, got {values[0]:g}"
        self.imu_assist = values[0]
        return None

    def _set_mount(self, values: Values) -> str | None:
        self.mount = (values[0], values[1], values[2], values[3], values[4], values[5])
        return None


INPUTS: dict[str, tuple[int | None, Callable[[CameraSettings, Values], str | None]]] = {
    "pipeline": (1, CameraSettings._set_pipeline),
    "priorityid": (1, CameraSettings._set_priority),
    "crop": (4, CameraSettings._set_crop),
    "fiducial_id_filters_set": (None, CameraSettings._set_filters),
    "fiducial_downscale_set": (1, CameraSettings._set_downscale),
    "throttle_set": (1, CameraSettings._set_throttle),
    "camMode": (1, CameraSettings._set_camera_mode),
    "imumode_set": (1, CameraSettings._set_imu_mode),
    "imuassistalpha_set": (1, CameraSettings._set_imu_assist),
    "camerapose_robotspace_set": (6, CameraSettings._set_mount),
}
"""Topics that change a setting, how many numbers each needs, and what they do. `robot_orientation_set` is no setting:
the camera keeps its history."""

NO_EFFECT = {
    "ledMode": "there are no lights",
    "stream": "there is no picture",
    "snapshot": "there is no picture",
    "rewind_enable_set": "nothing is recorded",
    "capture_rewind": "nothing is recorded",
    "llrobot": "a Python pipeline would read it, and there is none",
}
"""Topics that a Limelight reads and that change nothing that robot code can read back; with the reason."""

NOT_MODELED = ("fiducial_offset_set", "keystone_set")
"""Topics that a Limelight reads and that would change what it publishes, if they were modeled."""


def limelight_mount(mount: CameraMount) -> tuple[float, float, float, float, float, float]:
    """A mount in a Limelight's robot space: ahead, right, up [m]; roll, pitch, yaw [deg], looking up is positive."""
    return mount.x, -mount.y, mount.z, mount.roll_deg, -mount.pitch_deg, mount.yaw_deg


def _is_whole(value: float) -> bool:
    return value == math.floor(value)
