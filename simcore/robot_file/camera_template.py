"""The part of a new `simcore.toml` about cameras: what a table can say, and those that the program has."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["FoundCamera", "cameras_text"]


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundCamera:
    """A camera, or a headset, that a robot program builds or asks for."""

    maker: str
    """As in the file: `limelight`, `photonvision` or `questnav`."""
    name: str = ""
    """Of its table, or as its `PhotonCamera` has it."""
    place: tuple[float, ...] = ()
    """x, y, z [m], roll, pitch, yaw [deg], where the program says where it sits; else empty."""
    source: str = ""
    """Who says so."""


_ALL = """\
# Cameras: one [[camera]] each. One of PhotonVision needs none if robot code says where it sits (VisionSystemSim,
# PhotonPoseEstimator), and a headset of QuestNav none if robot code tells it at the start where it is.

# [[camera]]
# maker = "limelight"           # or photonvision, questnav
# name = "limelight"            # of its NetworkTables table
# type = "LL4"                  # LL3, LL3A, LL3G or LL4
# mode = "tags"                 # or "pieces"; ["tags", "pieces"] are pipelines 0 and 1
# json = false                  # whether each frame is also told as JSON
# x = 0.30
# y = 0.0
# z = 0.40
# pitch_deg = -20.0             # below zero looks up
# yaw_deg = 0.0                 # 180 looks back
# roll_deg = 0.0

# [[camera]]
# maker = "photonvision"
# name = "front"                # as in PhotonCamera("front")
# resolution = [1280, 720]
# diagonal_fov_deg = 76.0       # or horizontal_fov_deg
# fps = 30
# latency_ms = 30               # from exposure until robot code can read it
# noise_px = 0.25               # of a tag's corners
# x = 0.30
# y = 0.0
# z = 0.40
# pitch_deg = -20.0
# yaw_deg = 0.0

# [[camera]]
# maker = "questnav"
# x = -0.20
# y = 0.0
# z = 0.60
# yaw_deg = 180.0
"""

_FOUND = """\

# Your program has these cameras. Take the # off those that it does not place itself, and say where they sit.
"""


def cameras_text(cameras: Sequence[FoundCamera]) -> str:
    """The text, all of it in comments."""
    return _ALL + (_FOUND + "".join(_table(camera) for camera in cameras) if cameras else "")


def _table(camera: FoundCamera) -> str:
    lines = ["", "[[camera]]", f'maker = "{camera.maker}"']
    if camera.source:
        lines[1] += f"                      # placed already: {camera.source} says so, so it needs no table"
    if camera.name:
        lines.append(f'name = "{camera.name}"')
    if camera.maker == "limelight":
        lines.append('type = "LL4"                    # not known: LL3, LL3A, LL3G or LL4')
    x, y, z, roll, pitch, yaw = camera.place or (0.3, 0.0, 0.4, 0.0, -20.0, 0.0)
    lines.append(f"x = {x:.3g}" + ("" if camera.place else "                         # not known, nor the next lines"))
    lines += [f"y = {y:.3g}", f"z = {z:.3g}"]
    lines += [f"roll_deg = {roll:.4g}"] if roll else []
    lines += [f"pitch_deg = {pitch:.4g}", f"yaw_deg = {yaw:.4g}"]
    return "".join(f"# {line}".rstrip() + "\n" for line in lines)
