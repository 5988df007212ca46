"""QuestNav table on NetworkTables: publishes a headset's poses and receives commands from robot code.

The four messages are Protocol Buffers. Source: QuestNav's protos/data.proto and commands.proto (2026), and wpimath's
geometry3d.proto. The encoding follows protobuf.dev, "Encoding": a tag with field number and wire type, then a varint,
eight bytes, or a length and bytes.
"""

from __future__ import annotations

import logging
import math
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from simcore import season
from simcore.errors import ConfigError
from simcore.robotcode.networktables.network_clock import NetworkClock
from simcore.vision.quest_headset import PoseReset, QuestFrame
from simcore.world.rotation import Quaternion, Vector

__all__ = [
    "TABLE",
    "Command",
    "QuestNavTable",
    "device_message",
    "frame_message",
    "read_command",
    "response_message",
]

_log = logging.getLogger(__name__)

TABLE = "QuestNav"
_FRAME = "proto:questnav.protos.data.ProtobufQuestNavFrameData"
_DEVICE = "proto:questnav.protos.data.ProtobufQuestNavDeviceData"
_RESPONSE = "proto:questnav.protos.commands.ProtobufQuestNavCommandResponse"
_DEVICE_PERIOD = 1.0 / 3.0  # [s], from QuestNav's protos/data.proto
_VARINT, _FIXED64, _BYTES, _FIXED32 = 0, 1, 2, 5
POSE_RESET = 1


class QuestNavTable:
    """NetworkTables table of the QuestNav app.

    Source of topics and types: QuestNav's NetworkTableConnection.cs and questnav-lib's QuestNav.java of 2026.

    Args:
        instance: NetworkTables instance, owned by the caller; the default instance in a robot program.
        clock: Clock that converts simulated time to NetworkTables time.
    """

    def __init__(self, instance: season.NetworkTables, clock: NetworkClock) -> None:
        self._clock = clock
        every = season.pub_sub_options(periodic=0.005, send_all=True, keep_duplicates=True, poll_storage=20)
        topic = instance.get_raw_topic
        self._frames = topic(f"/{TABLE}/frameData").publish(_FRAME, every)
        self._device = topic(f"/{TABLE}/deviceData").publish(_DEVICE, every)
        self._response = topic(f"/{TABLE}/response").publish(_RESPONSE, every)
        # Subscribe without a type, because libraries publish the topic as "proto:..." or as "raw".
        self._request = instance.get_topic(f"/{TABLE}/request").generic_subscribe(every)
        self._next_device = 0.0
        self._is_closed = False

    def read(self) -> list[PoseReset]:
        """Respond to every command, and return the pose resets since the last call, oldest first."""
        if self._is_closed:
            return []
        resets: list[PoseReset] = []
        for value in self._request.read_queue():
            if not value.is_valid():
                continue
            command = _command(value)
            if command.problem:
                _log.warning("QuestNav: command %d: %s; it is ignored", command.number, command.problem)
            if command.reset is not None:
                resets.append(command.reset)
            self._response.set(response_message(command.number, command.problem))
        return resets

    def publish(self, frames: Sequence[QuestFrame], battery_percent: int) -> None:
        """Publish at least one pose with the measurement time, and the headset's status three times a second."""
        for frame in frames:
            self._frames.set(frame_message(frame), self._clock.to_network(frame.time))
        last = frames[-1]
        if last.time >= self._next_device:
            self._next_device = last.time + _DEVICE_PERIOD
            self._device.set(device_message(battery_percent), self._clock.to_network(last.time))

    def close(self) -> None:
        """Unpublish the topics, but keep the instance; safe to call more than once."""
        self._is_closed = True
        for publisher in (self._frames, self._device, self._response):
            publisher.close()


def _command(value: Any) -> Command:
    if not value.is_raw():
        return Command(0, None, "needs a ProtobufQuestNavCommand in raw bytes")
    try:
        return read_command(bytes(value.get_raw()))
    except ConfigError as error:
        return Command(0, None, str(error))


@dataclass(slots=True)
class Command:
    """Decoded `ProtobufQuestNavCommand`."""

    number: int
    """Command ID, repeated in the response."""
    reset: PoseReset | None
    """Commanded pose reset; None for another kind of command or an invalid pose."""
    problem: str = ""
    """Reason why `reset` is None; empty for a valid reset."""


def frame_message(frame: QuestFrame, *, tracking: bool = True) -> bytes:
    """Encode a `ProtobufQuestNavFrameData`: frame_count 1, timestamp 2, pose3d 3, isTracking 4."""
    (x, y, z), (qx, qy, qz, qw) = frame.position, frame.attitude
    place = _double(1, x) + _double(2, y) + _double(3, z)
    quaternion = _double(1, qw) + _double(2, qx) + _double(3, qy) + _double(4, qz)
    pose = _bytes(1, place) + _bytes(2, _bytes(1, quaternion))
    return _whole(1, frame.number) + _double(2, frame.time) + _bytes(3, pose) + _whole(4, int(tracking))


def device_message(battery_percent: int, *, tracking: bool = True, lost: int = 0) -> bytes:
    """Encode a `ProtobufQuestNavDeviceData`: tracking_lost_counter 1, currently_tracking 2, battery_percent 3.

    Libraries that do not define field 2 skip the field, as Protocol Buffers readers do with unknown fields.
    """
    return _whole(1, lost) + _whole(2, int(tracking)) + _whole(3, battery_percent)


def response_message(number: int, problem: str = "") -> bytes:
    """Encode a `ProtobufQuestNavCommandResponse`: command_id 1, success 2, error_message 3."""
    text = _bytes(3, problem.encode()) if problem else b""
    return _whole(1, number) + _whole(2, int(not problem)) + text


def read_command(data: bytes) -> Command:
    """Decode a `ProtobufQuestNavCommand`: type 1, command_id 2, pose_reset_payload 10.

    Raises:
        ConfigError: The data are truncated or not Protocol Buffers.
    """
    kind = number = 0
    pose: bytes | None = None
    for field, value in _fields(data):
        if field == 1 and isinstance(value, int):
            kind = value
        elif field == 2 and isinstance(value, int):
            number = value
        elif field == 10 and isinstance(value, bytes):
            pose = _part(value, 1) or b""
    if kind != POSE_RESET or pose is None:
        return Command(number, None, f"unknown command type {kind}" if kind != POSE_RESET else "no pose in the command")
    place: Vector = _numbers(_part(pose, 1) or b"", 3)  # type: ignore[assignment]
    qw, qx, qy, qz = _numbers(_part(_part(pose, 2) or b"", 1) or b"", 4)
    norm = math.sqrt(qw * qw + qx * qx + qy * qy + qz * qz)
    if not (all(map(math.isfinite, place)) and math.isfinite(norm) and norm > 0.0):
        return Command(number, None, "the pose is not finite, or has no attitude")
    turn: Quaternion = (qx / norm, qy / norm, qz / norm, qw / norm)
    return Command(number, PoseReset(place, turn))


# --- encoding -----------------------------------------------------------------------------------------------------


def _varint(value: int) -> bytes:
    value &= (1 << 64) - 1
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


def _whole(field: int, value: int) -> bytes:
    return _varint(field << 3 | _VARINT) + _varint(value)


def _double(field: int, value: float) -> bytes:
    return _varint(field << 3 | _FIXED64) + struct.pack("<d", value)


def _bytes(field: int, value: bytes) -> bytes:
    return _varint(field << 3 | _BYTES) + _varint(len(value)) + value


def _fields(data: bytes) -> Iterator[tuple[int, int | float | bytes]]:
    """Yield number and value of each field in a message.

    Raises:
        ConfigError: The message is truncated or not Protocol Buffers.
    """
    at = 0

    def varint() -> int:
        nonlocal at
        value = shift = 0
        while True:
            if at >= len(data) or shift > 63:
                raise ConfigError(f"a QuestNav message is cut short or invalid: {data[:40]!r}")
            byte = data[at]
            at += 1
            value |= (byte & 0x7F) << shift
            if byte < 0x80:
                return value
            shift += 7

    while at < len(data):
        tag = varint()
        field, kind = tag >> 3, tag & 7
        if kind == _VARINT:
            yield field, varint()
            continue
        length = {_FIXED64: 8, _FIXED32: 4}.get(kind, -1) if kind != _BYTES else varint()
        if length < 0 or at + length > len(data):
            raise ConfigError(f"a QuestNav message is cut short or invalid: {data[:40]!r}")
        part = data[at : at + length]
        at += length
        yield field, part if kind == _BYTES else struct.unpack("<d" if kind == _FIXED64 else "<f", part)[0]


def _part(data: bytes, field: int) -> bytes | None:
    """Return the last sub-message with a field number, or None without such a sub-message."""
    found: bytes | None = None
    for number, value in _fields(data):
        if number == field and isinstance(value, bytes):
            found = value
    return found


def _numbers(data: bytes, count: int) -> tuple[float, ...]:
    """Return the doubles in fields 1 to `count`, with 0 for fields that the encoding omits."""
    values = [0.0] * count
    for number, value in _fields(data):
        if 1 <= number <= count and isinstance(value, float):
            values[number - 1] = value
    return tuple(values)
