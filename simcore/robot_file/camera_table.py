"""Table `[[camera]]` of `simcore.toml`: Limelights, PhotonVision cameras and a QuestNav headset."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from simcore.quantities import DEGREES, FIELD_OF_VIEW, FRAME_RATE, NOISE_PIXELS, ROBOT_HEIGHT, ROBOT_PLACE, Quantity
from simcore.robot_file.key_tables import Key, KeyTable, Several, Table
from simcore.vision.camera import (
    LIMELIGHTS,
    PHOTON_LENS,
    CameraConfig,
    CameraMount,
    LimelightType,
    PiecePipeline,
    TagPipeline,
    limelight_type,
    vertical_fov_deg,
)
from simcore.vision.quest_headset import QuestConfig

__all__ = ["CAMERAS", "MAKERS", "read_cameras"]

MAKERS = ("limelight", "photonvision", "questnav")
"""Valid values of the key `maker`."""
_MOST_PIPELINES = 10
_MOUNT = (
    Key("x", ROBOT_PLACE, about="x coordinate of the lens, forward of the robot's center [m]", example=0.3),
    Key("y", ROBOT_PLACE, 0.0, "y coordinate of the lens, left of the robot's center [m]"),
    Key("z", ROBOT_HEIGHT, about="height of the lens above the floor [m]", example=0.4),
    Key("roll_deg", DEGREES, 0.0, "roll of the camera [deg]"),
    Key("pitch_deg", DEGREES, 0.0, "pitch of the camera [deg]; negative for a camera that points up", -20.0),
    Key("yaw_deg", DEGREES, 0.0, "direction of view, counter-clockwise [deg]: 0 front, 90 left, 180 back"),
)
_MAKER = Key("maker", MAKERS, MAKERS[0], "vision system of the camera or headset")
_FPS = Key("fps", FRAME_RATE, None, "processed frames per second [1/s]; left out: that of the type", 30.0, "frame_rate")
_LENS = (
    Key("resolution", Several(Quantity("", 1, 10_000, is_whole=True), or_one=False), (), "width and height of the "
        "picture [px]; left out: those of the type", [1280, 720]),
    Key("horizontal_fov_deg", FIELD_OF_VIEW, None, "horizontal field of view [deg]; left out: from diagonal_fov_deg, "
        "else that of the type"),
    Key("diagonal_fov_deg", FIELD_OF_VIEW, None, "diagonal field of view [deg], instead of horizontal_fov_deg", 76.0),
    _FPS,
    Key("latency_ms", Quantity("ms", 0.0, 10_000.0), None, "time from the exposure until robot code can read the "
        "result [ms]; left out: that of the type", 30.0),
    Key("noise_px", NOISE_PIXELS, None, "standard deviation of a tag corner in each direction [px]; left out: that of "
        "the type", 0.085),
    Key("mode", Several(("tags", "pieces")), ("tags",), 'target of each pipeline: ["tags", "pieces"] sets pipelines 0 '
        'and 1'),
)  # fmt: skip
_TYPES = tuple(LIMELIGHTS)
CAMERAS = {table.head: table for table in (
    KeyTable("limelight", "a Limelight camera", (
        _MAKER,
        Key("name", str, about="name of the camera's NetworkTables table", example="limelight"),
        Key("type", _TYPES, about=f"model: {', '.join(_TYPES[:-1])} or {_TYPES[-1]}", example="LL4"),
        *_MOUNT,
        *_LENS,
        Key("json", bool, False, "whether the camera also publishes each frame as JSON"),
    )),
    KeyTable("photonvision", "a PhotonVision camera; needs no table if robot code gives the camera's pose", (
        _MAKER,
        Key("name", str, about='name in robot code, as in PhotonCamera("front")', example="front"),
        Key("type", (PHOTON_LENS.name,), None, f"model of the image sensor; left out: {PHOTON_LENS.name}",
            PHOTON_LENS.name),
        *_MOUNT,
        *_LENS,
    )),
    KeyTable("questnav", "a QuestNav headset; needs no table if robot code sets the headset's pose at the start", (
        _MAKER, *_MOUNT, replace(_FPS, default=QuestConfig().frame_rate, about="poses per second [1/s]", example=None),
    )),
)}  # fmt: skip


def read_cameras(file: Table) -> tuple[tuple[CameraConfig, ...], QuestConfig | None]:
    """Return the cameras and the QuestNav headset that a file describes; None for a missing headset.

    Raises:
        ConfigError: A value in a table is invalid, or two tables describe a QuestNav headset.
    """
    cameras: list[CameraConfig] = []
    headset: QuestConfig | None = None
    for table in file.tables("camera"):
        maker = _MAKER.read(table, {})
        v = CAMERAS[maker].read(table)
        table.finish()
        mount = CameraMount(**{key.name: v[key.target] for key in _MOUNT})
        if maker != "questnav":
            cameras.append(_camera(table, v, mount))
        elif headset is None:
            headset = QuestConfig(mount=mount, frame_rate=v["frame_rate"])
        else:
            raise table.error("maker", "questnav is used twice; robot code talks to one headset")
    return tuple(cameras), headset


def _camera(t: Table, v: dict[str, Any], mount: CameraMount) -> CameraConfig:
    if "/" in v["name"]:
        raise t.error("name", f"must be a NetworkTables name without '/', got {v['name']!r}")
    modes: Sequence[str] = v["mode"]
    if len(modes) > _MOST_PIPELINES:
        raise t.error("mode", f"must be at most {_MOST_PIPELINES} modes, one a pipeline; got {len(modes)}")
    json = v.get("json", False)
    return CameraConfig(
        name=v["name"],
        maker="photonvision" if v["maker"] == "photonvision" else "limelight",
        type=_lens(t, v, PHOTON_LENS if v["maker"] == "photonvision" else limelight_type(v["type"])),
        mount=mount,
        pipelines=tuple(TagPipeline(json=json) if mode == "tags" else PiecePipeline(json=json) for mode in modes),
    )


def _lens(t: Table, v: dict[str, Any], base: LimelightType) -> LimelightType:
    """Return a copy of a camera type with the resolution, field of view, frame rate, latency and noise of the table."""
    size = v["resolution"]
    if size and len(size) != 2:
        raise t.error("resolution", f"must be two numbers, across and down, e.g. [1280, 720]; got {list(size)}")
    width, height = size or (base.width, base.height)
    across, down = base.horizontal_fov_deg, base.vertical_fov_deg
    if size:  # the lens stays, and the picture is cropped to another aspect ratio
        down = vertical_fov_deg(across, width, height)
    horizontal, diagonal = v["horizontal_fov_deg"], v["diagonal_fov_deg"]
    if horizontal is not None and diagonal is not None:
        raise t.error("diagonal_fov_deg", "means the same as horizontal_fov_deg; write one of them")
    if diagonal is not None:
        half = math.tan(math.radians(diagonal) / 2.0) * width / math.hypot(width, height)
        horizontal = math.degrees(2.0 * math.atan(half))
    if horizontal is not None:
        across, down = horizontal, vertical_fov_deg(horizontal, width, height)
    capture, pipeline = base.capture_latency, base.pipeline_latency
    if v["latency_ms"] is not None:  # both latencies change by the same factor
        factor = 1e-3 * v["latency_ms"] / (capture + pipeline)
        capture, pipeline = factor * capture, factor * pipeline
    return replace(
        base,
        width=width,
        height=height,
        horizontal_fov_deg=across,
        vertical_fov_deg=down,
        frame_rate=base.frame_rate if v["frame_rate"] is None else v["frame_rate"],
        capture_latency=capture,
        pipeline_latency=pipeline,
        corner_noise=base.corner_noise if v["noise_px"] is None else v["noise_px"],
    )
