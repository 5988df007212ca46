"""The `json` topic: one frame as the text that a Limelight publishes when its pipeline is told to."""

from __future__ import annotations

import json
from typing import Any

from simcore.vision.frames import Frame
from simcore.vision.wire import PIPELINE_TYPES, Value

__all__ = ["frame_json"]


def frame_json(frame: Frame, values: dict[str, Value], stamp: int) -> str:
    """The whole frame.

    Args:
        frame: What was seen.
        values: From `frame_values`, so that both always agree.
        stamp: When it is published, in NetworkTables' time [us].
    """

    def numbers(name: str) -> list[float]:
        value = values[name]
        assert isinstance(value, list)
        return [float(v) for v in value]

    data: dict[str, Any] = {
        "v": values["tv"],
        "pID": frame.pipeline,
        "pTYPE": PIPELINE_TYPES[frame.pipeline_kind],
        "tl": values["tl"],
        "cl": values["cl"],
        "ts": 1e3 * frame.published,
        "ts_us": round(1e6 * frame.published),
        "ts_nt": stamp,
        "fidx": frame.number,
        **{name: values[name] for name in ("tx", "ty", "txnc", "tync", "ta")},
        **{name: numbers(name)[:6] for name in ("botpose", "botpose_wpiblue", "botpose_wpired")},
        **{name: numbers(name)[:6] for name in ("botpose_orb", "botpose_orb_wpiblue", "botpose_orb_wpired")},
        **dict(
            zip(
                ("botpose_tagcount", "botpose_span", "botpose_avgdist", "botpose_avgarea"),
                numbers("botpose")[7:11],
                strict=True,
            )
        ),
        "stdev_mt1": numbers("stddevs")[:6],
        "stdev_mt2": numbers("stddevs")[6:],
        "t6c_rs": numbers("camerapose_robotspace"),
        "imu": {"data": numbers("imu"), "yaw": numbers("imu")[3]},
        "Retro": [],
        "Classifier": [],
        "Barcode": [],
        "Fiducial": [
            {
                "fID": tag.id,
                "fam": "36h11C",
                "tx": tag.tx_deg,
                "ty": tag.ty_deg,
                "tx_nocross": tag.tx_deg,
                "ty_nocross": tag.ty_deg,
                "txp": float(tag.corners[:, 0].mean()),
                "typ": float(tag.corners[:, 1].mean()),
                "ta": tag.area_percent,
                "pts": tag.pixels,
                **(
                    {
                        "t6t_cs": values["targetpose_cameraspace"],
                        "t6c_ts": values["camerapose_targetspace"],
                        "t6t_rs": values["targetpose_robotspace"],
                        "t6r_ts": values["botpose_targetspace"],
                    }
                    if tag is frame.primary_tag
                    else {}
                ),
            }
            for tag in frame.tags
        ],
        "Detector": [
            {
                "class": piece.class_name,
                "classID": piece.class_id,
                "tx": piece.tx_deg,
                "ty": piece.ty_deg,
                "tx_nocross": piece.tx_deg,
                "ty_nocross": piece.ty_deg,
                "ta": piece.area_percent,
                "pts": piece.pixels,
            }
            for piece in frame.pieces
        ],
    }
    return json.dumps(data)
