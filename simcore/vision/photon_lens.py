"""Lenses of PhotonVision's coprocessors: a default one, and one by resolution and field of view."""

from __future__ import annotations

import math

from simcore.errors import ConfigError
from simcore.vision.camera import LimelightType

__all__ = ["PHOTON_LENS", "vertical_fov_deg"]

PHOTON_LENS = LimelightType(
    name="OV9281",
    width=1280,
    height=720,
    # Focal lengths and noise: SimCameraProperties.OV9281_1280_720 of photonlibpy 2026.3, 940.7 x 940.0 px and 0.25 px.
    horizontal_fov_deg=68.5,
    vertical_fov_deg=41.9,
    # Rate and latency: estimates for an Orange Pi 5, +-50 %; photonlibpy's 15 frames/s and 60 ms are a Raspberry Pi's.
    frame_rate=30.0,
    capture_latency=0.0,
    pipeline_latency=0.030,
)
"""What a PhotonVision camera has if nobody says otherwise; it tells one latency, from exposure to publishing."""


def vertical_fov_deg(horizontal_deg: float, width: int, height: int) -> float:
    """Field of view up and down of a lens with square pixels [deg].

    Args:
        horizontal_deg: Field of view across [deg].
        width: Of the picture [px].
        height: Of the picture [px].

    Raises:
        ConfigError: No such lens.

    >>> round(vertical_fov_deg(90.0, 1280, 720), 1)
    58.7
    """
    if not (0.0 < horizontal_deg < 180.0 and width > 0 and height > 0):
        raise ConfigError(
            f"a lens needs a field of view between 0 and 180 degrees and a picture, got {horizontal_deg} and "
            f"{width} x {height}"
        )
    return math.degrees(2.0 * math.atan(math.tan(math.radians(horizontal_deg) / 2.0) * height / width))
