"""The tables `[[camera]]` of `simcore.toml`: Limelights, cameras of PhotonVision, and a headset of QuestNav."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from simcore.quantities import DEGREES, FIELD_OF_VIEW, FRAME_RATE, NOISE_PIXELS, ROBOT_HEIGHT, ROBOT_PLACE, Quantity
from simcore.robot_file.toml_tables import Table
from simcore.vision.camera import (
    LIMELIGHTS,
    CameraConfig,
    CameraMount,
    LimelightType,
    PiecePipeline,
    Pipeline,
    TagPipeline,
    limelight_type,
)
from simcore.vision.photon_lens import PHOTON_LENS, vertical_fov_deg
from simcore.vision.quest_headset import QuestConfig

__all__ = ["MAKERS", "read_cameras"]

MAKERS = ("limelight", "photonvision", "questnav")
"""What `maker` can be."""
_MODES = ("tags", "pieces")
_MOST_PIPELINES = 10


def read_cameras(file: Table) -> tuple[tuple[CameraConfig, ...], QuestConfig | None]:
    """Cameras, and the headset if there is one.

    Raises:
        ConfigError: Something in a table cannot be.
    """
    cameras: list[CameraConfig] = []
    headset: QuestConfig | None = None
    for table in file.tables("camera"):
        maker = table.choice("maker", MAKERS, MAKERS[0])
        if maker != "questnav":
            cameras.append(_camera(table, maker))
        elif headset is None:
            headset = _headset(table)
        else:
            raise table.error("maker", "questnav comes twice; robot code talks to one headset")
        table.finish()
    return tuple(cameras), headset


def _camera(t: Table, maker: str) -> CameraConfig:
    name = t.text("name")
    if "/" in name:
        raise t.error("name", f"must be a NetworkTables name without '/', got {name!r}")
    if maker == "limelight":
        lens = limelight_type(t.choice("type", tuple(LIMELIGHTS)))
    else:
        t.choice("type", (PHOTON_LENS.name,), None)
        lens = PHOTON_LENS
    modes = t.choices("mode", _MODES) if "mode" in t else t.texts("mode") or _MODES[:1]
    return CameraConfig(
        name=name,
        maker="photonvision" if maker == "photonvision" else "limelight",
        type=_lens(t, lens),
        mount=_mount(t),
        pipelines=_pipelines(t, modes, maker),
    )


def _pipelines(t: Table, modes: Sequence[str], maker: str) -> tuple[Pipeline, ...]:
    """One for each mode, numbered from 0."""
    if len(modes) > _MOST_PIPELINES:
        raise t.error("mode", f"must be at most {_MOST_PIPELINES} modes, one a pipeline; got {len(modes)}")
    json = maker == "limelight" and t.flag("json", False)
    return tuple(TagPipeline(json=json) if mode == "tags" else PiecePipeline(json=json) for mode in modes)


def _rate(t: Table, default: float) -> float:
    return float(t.number("fps", FRAME_RATE, default))


def _headset(t: Table) -> QuestConfig:
    d = QuestConfig()
    return QuestConfig(mount=_mount(t), frame_rate=_rate(t, d.frame_rate))


def _mount(t: Table) -> CameraMount:
    degrees = {f"{axis}_deg": t.number(f"{axis}_deg", DEGREES, 0.0) for axis in ("roll", "pitch", "yaw")}
    return CameraMount(
        x=t.number("x", ROBOT_PLACE), y=t.number("y", ROBOT_PLACE), z=t.number("z", ROBOT_HEIGHT), **degrees
    )


def _lens(t: Table, base: LimelightType) -> LimelightType:
    """The type with what the table says in its place."""
    size = t.wholes("resolution", least=1, most=10_000)
    if size and len(size) != 2:
        raise t.error("resolution", f"must be two numbers, across and down, e.g. [1280, 720]; got {list(size)}")
    width, height = size or (base.width, base.height)
    across, down = base.horizontal_fov_deg, base.vertical_fov_deg
    if size:  # the same lens, of whose picture a part of another shape is used
        down = vertical_fov_deg(across, width, height)
    horizontal = t.number("horizontal_fov_deg", FIELD_OF_VIEW, None)
    diagonal = t.number("diagonal_fov_deg", FIELD_OF_VIEW, None)
    if horizontal is not None and diagonal is not None:
        raise t.error("diagonal_fov_deg", "says the same as horizontal_fov_deg; write one of them")
    if diagonal is not None:
        half = math.tan(math.radians(diagonal) / 2.0) * width / math.hypot(width, height)
        horizontal = math.degrees(2.0 * math.atan(half))
    if horizontal is not None:
        across, down = horizontal, vertical_fov_deg(horizontal, width, height)
    capture, pipeline = base.capture_latency, base.pipeline_latency
    latency = t.number("latency_ms", Quantity("ms", 0.0, 10_000.0), None)
    if latency is not None:  # its stages keep their shares
        factor = 1e-3 * latency / (capture + pipeline)
        capture, pipeline = factor * capture, factor * pipeline
    return replace(
        base,
        width=width,
        height=height,
        horizontal_fov_deg=across,
        vertical_fov_deg=down,
        frame_rate=_rate(t, base.frame_rate),
        capture_latency=capture,
        pipeline_latency=pipeline,
        corner_noise=t.number("noise_px", NOISE_PIXELS, base.corner_noise),
    )
