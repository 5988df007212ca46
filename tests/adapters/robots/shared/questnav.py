"""QuestNav's topics without its library: protocol buffers by hand, as in teams that copy the class."""

import struct
from dataclasses import dataclass

import ntcore
import wpilib
from wpimath.geometry import Pose3d, Quaternion, Rotation3d, Translation3d


@dataclass
class Frame:
    number: int
    pose: Pose3d
    time: float
    is_tracking: bool


def fields(data: bytes) -> dict[int, object]:
    found: dict[int, object] = {}
    at = 0

    def varint() -> int:
        nonlocal at
        value = shift = 0
        while True:
            byte = data[at]
            at += 1
            value |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return value

    while at < len(data):
        key = varint()
        number, kind = key >> 3, key & 7
        if kind == 0:
            found[number] = varint()
        elif kind == 1:
            found[number] = struct.unpack_from("<d", data, at)[0]
            at += 8
        else:
            size = varint()
            found[number] = data[at : at + size]
            at += size
    return found


def doubles(*values: float) -> bytes:
    return b"".join(bytes([(k << 3) | 1]) + struct.pack("<d", value) for k, value in enumerate(values, 1))


def block(number: int, data: bytes) -> bytes:
    return bytes([(number << 3) | 2, len(data)]) + data


class QuestNav:
    def __init__(self) -> None:
        inst = ntcore.NetworkTableInstance.getDefault()
        kind = "proto:questnav.protos.data.ProtobufQuestNavFrameData"
        options = ntcore.PubSubOptions(pollStorage=20, sendAll=True)
        self.frames = inst.getRawTopic("/QuestNav/frameData").subscribe(kind, b"", options)
        request = inst.getRawTopic("/QuestNav/request")
        self.request = request.publish("proto:questnav.protos.commands.ProtobufQuestNavCommand")
        self.number = 0
        self.last = -1.0

    def set_pose(self, pose: Pose3d) -> None:
        q = pose.rotation().getQuaternion()
        target = block(1, doubles(pose.X(), pose.Y(), pose.Z()))
        target += block(2, block(1, doubles(q.W(), q.X(), q.Y(), q.Z())))
        self.number += 1
        self.request.set(bytes([8, 1, 16, self.number]) + block(10, block(1, target)))

    def unread_frames(self) -> list[Frame]:
        found = []
        for sample in self.frames.readQueue():
            frame = fields(sample.value)
            pose = fields(frame.get(3, b""))
            at, turn = fields(pose.get(1, b"")), fields(fields(pose.get(2, b"")).get(1, b""))
            place = Translation3d(*(at.get(k, 0.0) for k in (1, 2, 3)))
            rotation = Rotation3d(Quaternion(*(turn.get(k, 0.0) for k in (1, 2, 3, 4))))
            self.last = sample.time / 1e6
            found.append(Frame(frame[1], Pose3d(place, rotation), self.last, bool(frame.get(4, 0))))
        return found

    def is_connected(self) -> bool:
        return wpilib.Timer.getFPGATimestamp() - self.last < 0.2
