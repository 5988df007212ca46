"""Limelight table on NetworkTables: topics with their types and values, the `json` topic, and requests.

Source: LimelightHelpers 2026 and docs.limelightvision.io, "Complete NetworkTables API" (2026-08).
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from itertools import chain
from typing import Any

import numpy as np

from simcore import season
from simcore.robotcode.networktables.network_clock import NetworkClock
from simcore.typing import FloatArray
from simcore.vision.camera import OPTICAL, CameraConfig
from simcore.vision.camera_frame import Corners, Frame, PieceSighting, PoseEstimate, TagSighting
from simcore.vision.limelight import CameraRequest
from simcore.vision.limelight_settings import INPUTS

__all__ = ["TOPICS", "LimelightTable", "frame_json", "frame_values"]

_ORIENTATION = "robot_orientation_set"
_EVERY = 0.005  # [s], send period of ntcore
_MOST_HEADINGS = 100  # requests buffered between ticks; a team's odometry thread sends up to 250 per second
_KINDS = {
    "int": "integer",
    "double": "double",
    "string": "string",
    "string[]": "string_array",
    "double[]": "double_array",
}
"""Type name in ntcore's method names, by type in `TOPICS`."""

Value = float | int | str | list[float] | list[str]

PIPELINE_TYPES = {"tags": "pipe_fiducial", "pieces": "pipe_neuraldetector"}
"""Value of the topic `getpipetype` for each kind of pipeline."""

_NO_POSE = [0.0] * 6
_DEGREES = 180.0 / math.pi
_MOST_TARGETS = 3


def constant_values(config: CameraConfig) -> dict[str, Value]:
    """Return the initial values of the topics that `frame_values` omits; only `json` changes later."""
    return {
        "json": "",
        "imu_yaw_offset": 0.0,
        "tcclass": "",
        "rawbarcodes": [],
        "hw": [0.0, 0.0, 0.0, config.rate],
        "tc": [0.0, 0.0, 0.0],
        "crosshairs": [0.0, 0.0, 0.0, 0.0],
        "llpython": [],
    }


def frame_values(frame: Frame, config: CameraConfig, field_size: tuple[float, float]) -> dict[str, Value]:
    """Return the topic values that depend on a frame, without `json` (see `frame_json`).

    Args:
        frame: Frame of the camera.
        config: Configuration of the camera.
        field_size: Length and width of the field [m], for poses with an origin other than the blue corner.
    """
    tag, piece = frame.primary_tag, frame.primary_piece
    seen = tag or piece
    tx, ty, ta = (seen.tx_deg, seen.ty_deg, seen.area_percent) if seen is not None else (0.0, 0.0, 0.0)
    corners = seen.pixels if seen is not None else None
    tid = tag.id if tag is not None else -1
    tl, cl = 1e3 * frame.pipeline_latency, 1e3 * frame.capture_latency
    kind = PIPELINE_TYPES[frame.pipeline_kind]
    distance = tag.camera_distance if tag is not None else piece.distance if piece is not None else 0.0
    piece_class = piece.class_name if piece is not None else ""
    one, two = frame.megatag1, frame.megatag2
    raw: list[float] = []
    for t in frame.tags:
        raw += (
            float(t.id), t.tx_deg, t.ty_deg, t.area_percent, t.camera_distance, t.robot_distance, t.ambiguity
        )  # fmt: skip
    botpose, botpose_blue, botpose_red = _poses(frame, one, raw, field_size)
    orb, orb_blue, orb_red = _poses(frame, two, raw, field_size)
    target_in_camera, camera_in_target, target_in_robot, robot_in_target = _target_space(tag, frame)
    return {
        "tv": int(seen is not None),
        "tid": tid,
        "getpipe": frame.pipeline,
        "tx": tx,
        "ty": ty,
        "txnc": tx,
        "tync": ty,
        "ta": ta,
        "tl": tl,
        "cl": cl,
        "hb": float(frame.number),
        "tdist": distance,
        "getpipetype": kind,
        "tclass": piece_class,
        "tdclass": piece_class,
        "t2d": [
            0.0 if seen is None else 1.0, float(len(frame.tags) + len(frame.pieces)), tl, cl, tx, ty, tx, ty, ta,
            float(tid), -1.0 if piece is None else 0.0, -1.0, *_sides(corners),
        ],
        "rawfiducials": raw,
        "rawdetections": [
            number
            for p in frame.pieces
            for number in (float(p.class_id), p.tx_deg, p.ty_deg, p.area_percent, *chain.from_iterable(p.pixels))
        ],
        "rawtargets": _raw_targets(frame, config),
        "tcornxy": [] if corners is None else [*chain.from_iterable(corners)],
        "stddevs": [
            *(one.std_devs if one is not None else _NO_POSE), *(two.std_devs if two is not None else _NO_POSE)
        ],
        "camerapose_robotspace": list(frame.mount),
        "imu": _imu(frame),
        "botpose": botpose,
        "botpose_wpiblue": botpose_blue,
        "botpose_wpired": botpose_red,
        "botpose_orb": orb,
        "botpose_orb_wpiblue": orb_blue,
        "botpose_orb_wpired": orb_red,
        "targetpose_cameraspace": target_in_camera,
        "camerapose_targetspace": camera_in_target,
        "targetpose_robotspace": target_in_robot,
        "botpose_targetspace": robot_in_target,
    }  # fmt: skip


def _poses(
    frame: Frame, found: PoseEstimate | None, raw: list[float], field_size: tuple[float, float]
) -> tuple[list[float], list[float], list[float]]:
    """Return the pose estimate with the origin at the field center, the blue corner and the red corner.

    Each result has 11 numbers plus 7 per tag; without an estimate, all numbers but the latency are zero.
    """
    latency = 1e3 * frame.latency
    if found is None:
        nothing = [*_NO_POSE, latency, 0.0, 0.0, 0.0, 0.0]
        return nothing, nothing, nothing
    x, y, z = found.position
    length, width = field_size
    roll, pitch, yaw = found.roll_deg, found.pitch_deg, found.yaw_deg
    rest = [
        latency, float(found.tag_count), found.tag_span, found.average_distance, found.average_area, *raw
    ]  # fmt: skip
    turned = yaw - 180.0 if yaw > 0.0 else yaw + 180.0
    return (
        [x - length / 2, y - width / 2, z, roll, pitch, yaw, *rest],
        [x, y, z, roll, pitch, yaw, *rest],
        [length - x, width - y, z, roll, pitch, turned, *rest],
    )


def _target_space(tag: TagSighting | None, frame: Frame) -> tuple[list[float], list[float], list[float], list[float]]:
    """Return four relative poses of target, camera and robot, each as x, y, z [m] and pitch, yaw, roll [deg].

    The poses are target in camera, camera in target, target in robot and robot in target; zeros without a tag. All
    three frames have camera axes: x right, y down, z forward (into the target). A robot that faces a tag therefore has
    zero angles and a negative z in target space.
    """
    if tag is None:
        return _NO_POSE, _NO_POSE, _NO_POSE, _NO_POSE
    place = np.array(tag.poses[0].translation)
    turn = np.array(tag.poses[0].rotation) * (
        1.0,
        -1.0,
        -1.0,
    )  # tag axes are right, up, out; target axes are right, down, in
    # In camera axes (right, down, forward), the robot's axes are -y, -z and x.
    robot_place = OPTICAL @ (frame.mount_axes @ place + frame.mount_position)
    robot_turn = OPTICAL @ frame.mount_axes @ turn
    return (
        _position_and_angles(place, turn),
        _position_and_angles(-place @ turn, turn.T),
        _position_and_angles(robot_place, robot_turn),
        _position_and_angles(-robot_place @ robot_turn, robot_turn.T),
    )


def _position_and_angles(place: FloatArray, turn: FloatArray) -> list[float]:
    """Return x, y, z [m] and pitch, yaw, roll [deg], for rotations in the order yaw, pitch, roll.

    Yaw is positive clockwise, seen from above.
    """
    (_, _, t02), (t10, t11, t12), (_, _, t22) = turn.tolist()
    pitch = math.asin(max(-1.0, min(1.0, -t12)))
    return [*place.tolist(), _DEGREES * pitch, _DEGREES * math.atan2(t02, t22), _DEGREES * math.atan2(t10, t11)]


def _sides(corners: Corners | None) -> list[float]:
    """Return a target's long and short side, bounding box width and height [px], and rotation [deg]; zeros for None."""
    if corners is None:
        return [0.0, 0.0, 0.0, 0.0, 0.0]
    (x0, y0), (x1, y1), (x2, y2), (x3, y3) = corners
    a = 0.5 * (math.hypot(x1 - x0, y1 - y0) + math.hypot(x2 - x3, y2 - y3))
    b = 0.5 * (math.hypot(x3 - x0, y3 - y0) + math.hypot(x2 - x1, y2 - y1))
    wide, high = max(x0, x1, x2, x3) - min(x0, x1, x2, x3), max(y0, y1, y2, y3) - min(y0, y1, y2, y3)
    return [max(a, b), min(a, b), wide, high, math.degrees(math.atan2(y0 - y1, x1 - x0))]


def _raw_targets(frame: Frame, config: CameraConfig) -> list[float]:
    """Return x (right) and y (up) in the image, from -1 to 1, and area [%] of the three largest targets."""
    width, height = config.type.width, config.type.height
    every: list[TagSighting | PieceSighting] = [*frame.tags, *frame.pieces]
    if len(every) > 1:
        every.sort(key=_area, reverse=True)
    raw: list[float] = []
    for seen in every[:_MOST_TARGETS]:
        (u0, v0), (u1, v1), (u2, v2), (u3, v3) = seen.pixels
        across, down = 0.5 * (u0 + u1 + u2 + u3) / width, 0.5 * (v0 + v1 + v2 + v3) / height
        raw += (across - 1.0, 1.0 - down, seen.area_percent)
    return raw


def _area(seen: TagSighting | PieceSighting) -> float:
    return seen.area_percent


def _imu(frame: Frame) -> list[float]:
    imu = frame.imu
    if imu is None:
        return [0.0] * 10
    return [
        imu.robot_yaw_deg, imu.roll_deg, imu.pitch_deg, imu.internal_yaw_deg, *imu.rates_dps, *imu.acceleration_g
    ]  # fmt: skip


_OF_PRIMARY = {
    "t6t_cs": "targetpose_cameraspace",
    "t6c_ts": "camerapose_targetspace",
    "t6t_rs": "targetpose_robotspace",
    "t6r_ts": "botpose_targetspace",
}
"""Topic with the same value, for each `json` key of the primary tag."""


def _json_target(seen: TagSighting | PieceSighting) -> dict[str, Any]:
    tx, ty = seen.tx_deg, seen.ty_deg
    return {"tx": tx, "ty": ty, "tx_nocross": tx, "ty_nocross": ty, "ta": seen.area_percent, "pts": seen.pixels}


def frame_json(frame: Frame, values: dict[str, Value], stamp: int) -> str:
    """Return the value of the `json` topic for a frame.

    Args:
        frame: Frame of the camera.
        values: Values from `frame_values` for the same frame.
        stamp: Publication time on the NetworkTables clock [us].
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
                "txp": float(tag.corners[:, 0].mean()),
                "typ": float(tag.corners[:, 1].mean()),
                **_json_target(tag),
                **{key: values[name] for key, name in _OF_PRIMARY.items() if tag is frame.primary_tag},
            }
            for tag in frame.tags
        ],
        "Detector": [
            {"class": piece.class_name, "classID": piece.class_id, **_json_target(piece)} for piece in frame.pieces
        ],
    }
    return json.dumps(data)


def _kind(name: str, value: Value) -> str:
    if isinstance(value, list):
        return "string[]" if name == "rawbarcodes" else "double[]"
    return {int: "int", float: "double", str: "string"}[type(value)]


def _empty_frame_values() -> dict[str, Value]:
    """Return the topic values for an empty frame."""
    nothing = Frame(
        number=0, time=0.0, published=0.0, capture_latency=0.0, pipeline_latency=0.0, pipeline=0, pipeline_kind="tags",
        json=False, mount=(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), mount_position=np.zeros(3), mount_axes=np.eye(3),
    )  # fmt: skip
    return frame_values(nothing, CameraConfig(), (1.0, 1.0))


FRAME_TOPICS = tuple(_empty_frame_values())
"""Topics whose values depend on the frame, in the order of `frame_values`."""

TOPICS = {
    name: _kind(name, value) for name, value in {**_empty_frame_values(), **constant_values(CameraConfig())}.items()
}
"""Type of each topic in a Limelight's table, a key of `_KINDS`."""

EVERY_FRAME = frozenset(name for name in TOPICS if name.startswith("botpose")) | {"hb", "t2d"}
"""Topics sent with every frame, even if unchanged, because readers detect a new frame by the timestamp."""


class CameraTables:
    """Factory of the Limelight tables of a match: `Match(..., network=CameraTables(instance))`.

    Args:
        instance: NetworkTables instance, owned by the caller; the default instance in a robot program.
    """

    def __init__(self, instance: season.NetworkTables) -> None:
        self._instance = instance
        self.clock = NetworkClock()
        """Clock that converts simulated time to NetworkTables time."""

    def port(self, config: CameraConfig, field_size: tuple[float, float]) -> LimelightTable:
        """Create the table of one Limelight; `field_size` is the field's length and width [m]."""
        return LimelightTable(self._instance, config, field_size, self.clock)


class LimelightTable:
    """NetworkTables table of one Limelight, under the camera's name.

    Args:
        instance: NetworkTables instance, owned by the caller; the default instance in a robot program.
        config: Configuration of the camera.
        field_size: Length and width of the field [m], for poses with an origin other than the blue corner.
        clock: Clock that converts simulated time to NetworkTables time.
    """

    def __init__(
        self,
        instance: season.NetworkTables,
        config: CameraConfig,
        field_size: tuple[float, float],
        clock: NetworkClock,
    ) -> None:
        self._config = config
        self._field_size = field_size
        self._clock = clock
        table = f"/{config.name}"
        plain = season.pub_sub_options(periodic=_EVERY)
        repeat = season.pub_sub_options(periodic=_EVERY, send_all=True, keep_duplicates=True)
        self._publishers: dict[str, Any] = {}
        for name, kind in TOPICS.items():
            options = repeat if name in EVERY_FRAME else plain
            self._publishers[name] = getattr(instance, f"get_{_KINDS[kind]}_topic")(f"{table}/{name}").publish(options)
        for name, value in constant_values(config).items():
            self._publishers[name].set(value, clock.to_network(0.0))
        listen = season.pub_sub_options(
            periodic=_EVERY, send_all=True, keep_duplicates=True, poll_storage=_MOST_HEADINGS
        )
        self._inputs = {
            name: instance.get_topic(f"{table}/{name}").generic_subscribe(listen) for name in (*INPUTS, _ORIENTATION)
        }
        # One poller for all rarely written topics: polling nine subscribers takes 9 us. The heading arrives every tick
        # and has its own subscriber, since unpacking an event takes twice as long as unpacking a value.
        self._poller = season.ntcore.NetworkTableListenerPoller(instance)
        flags = season.ntcore.EventFlags
        now = flags.VALUE_ALL | flags.IMMEDIATE
        self._topics = {self._poller.add_listener(self._inputs[name], now): name for name in INPUTS}
        self._prefix = f"{table}/"
        published = flags.PUBLISH | flags.IMMEDIATE
        self._others = self._poller.add_listener([self._prefix], published)
        self._last: list[Value | None] = [None] * len(FRAME_TOPICS)
        self._setters: list[Callable[[Any, int], None]] = [self._publishers[name].set for name in FRAME_TOPICS]
        self._is_repeated = [name in EVERY_FRAME for name in FRAME_TOPICS]

    def read(self) -> list[CameraRequest]:
        """Return the requests since the last call: headings, then settings, both in arrival order.

        The list has one request without numbers for each topic that `LimelightSim` ignores, and is empty after `close`.
        """
        orientation = self._inputs.get(_ORIENTATION)
        if orientation is None:
            return []
        # An invalid value, such as the first value of a topic, is not a request.
        requests = [self._request(_ORIENTATION, value) for value in orientation.read_queue() if value.is_valid()]
        for event in self._poller.read_queue():
            if event.listener == self._others:
                topic = event.data.name.removeprefix(self._prefix)
                if topic not in TOPICS and topic not in self._inputs:
                    requests.append(CameraRequest(topic, None))
            else:
                requests.append(self._request(self._topics[event.listener], event.data.value))
        return requests

    def _request(self, topic: str, value: Any) -> CameraRequest:
        return CameraRequest(topic, _numbers(value), self._clock.to_simulated(value.time()))

    def publish(self, frame: Frame) -> None:
        """Publish a frame's changed values and the `EVERY_FRAME` topics, stamped with the frame's publication time."""
        stamp = self._clock.to_network(frame.published)
        values = frame_values(frame, self._config, self._field_size)
        last, self._last = self._last, [*values.values()]
        for value, before, is_repeated, set_value in zip(
            self._last, last, self._is_repeated, self._setters, strict=True
        ):
            if value != before or is_repeated:  # comparing is cheaper than sending a value that ntcore drops
                set_value(value, stamp)
        if frame.json:
            self._publishers["json"].set(frame_json(frame, values, stamp), stamp)

    def close(self) -> None:
        """Unpublish the topics, but keep the instance; safe to call more than once."""
        for publisher in self._publishers.values():
            publisher.close()
        self._poller.close()
        self._inputs.clear()  # a GenericSubscriber has no close(); dropping the last reference unsubscribes


def _numbers(value: Any) -> tuple[float, ...] | None:
    """Return the numbers in a value written by robot code, or None for a type without numbers."""
    if value.is_double_array():  # the most frequent case, for the heading
        return tuple(value.value())
    if value.is_double() or value.is_integer() or value.is_float():
        return (float(value.value()),)
    if value.is_integer_array() or value.is_float_array():
        return tuple(float(v) for v in value.value())
    return None
