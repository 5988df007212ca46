"""A TimedRobot that reads two Limelights, of which simcore.toml describes one, and a QuestNav headset, all by topics.

It asks for its tables at the top of the file, in a class and when it starts, as robots do."""

import math
import struct

import measures
import ntcore
import wpilib
from ntcore import NetworkTableInstance
from wpimath.geometry import Pose2d, Pose3d, Quaternion, Rotation3d, Transform3d, Translation3d

FRONT = NetworkTableInstance.getDefault().getTable("limelight-front")
ROBOT_TO_QUEST = Transform3d(-0.2, 0.1, 0.6, Rotation3d(0.0, 0.0, math.pi))


class Vision:
    table = NetworkTableInstance.getDefault().getTable("limelight")


def fields(data):
    """Number and value of each field of a Protocol Buffers message, of those wire types that QuestNav uses."""
    at = 0
    while at < len(data):
        tag = data[at]
        at += 1
        if tag & 7 == 1:
            value, at = struct.unpack_from("<d", data, at)[0], at + 8
        else:
            value = shift = 0
            while True:
                byte, at = data[at], at + 1
                value |= (byte & 127) << shift
                shift += 7
                if byte < 128:
                    break
            if tag & 7 == 2:
                value, at = data[at : at + value], at + value
        yield tag >> 3, value


class Quest:
    def __init__(self) -> None:
        table = NetworkTableInstance.getDefault().getTable("QuestNav")
        every = ntcore.PubSubOptions(sendAll=True, pollStorage=20, periodic=0.005)
        self.frames = table.getRawTopic("frameData").subscribe(
            "proto:questnav.protos.data.ProtobufQuestNavFrameData", b"", every
        )
        self.device = table.getRawTopic("deviceData").subscribe(
            "proto:questnav.protos.data.ProtobufQuestNavDeviceData", b""
        )
        self.response = table.getRawTopic("response").subscribe(
            "proto:questnav.protos.commands.ProtobufQuestNavCommandResponse", b""
        )
        self.request = table.getRawTopic("request").publish("proto:questnav.protos.commands.ProtobufQuestNavCommand")
        self.pose = None
        self.ages = []
        self.numbers = []
        self.tracking = False

    def set_pose(self, pose: Pose3d) -> None:
        q = pose.rotation().getQuaternion()
        place = b"".join(
            bytes([8 * k + 9]) + struct.pack("<d", v) for k, v in enumerate((pose.X(), pose.Y(), pose.Z()))
        )
        turn = b"".join(bytes([8 * k + 9]) + struct.pack("<d", v) for k, v in enumerate((q.W(), q.X(), q.Y(), q.Z())))
        turn = b"\x0a" + bytes([len(turn)]) + turn
        both = b"\x0a" + bytes([len(place)]) + place + b"\x12" + bytes([len(turn)]) + turn
        payload = b"\x0a" + bytes([len(both)]) + both
        self.request.set(b"\x08\x01\x10\x01\x52" + bytes([len(payload)]) + payload)

    def read(self) -> None:
        for change in self.frames.readQueue():
            message = dict(fields(change.value))
            pose = dict(fields(message[3]))
            place, turn = dict(fields(pose[1])), dict(fields(dict(fields(pose[2]))[1]))
            quest = Pose3d(
                Translation3d(*(place[k] for k in (1, 2, 3))), Rotation3d(Quaternion(*(turn[k] for k in (1, 2, 3, 4))))
            )
            self.pose = quest.transformBy(ROBOT_TO_QUEST.inverse())
            self.tracking = bool(message[4])
            self.numbers.append(message[1])
            self.ages.append(wpilib.Timer.getFPGATimestamp() - change.time * 1e-6)


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.drivetrain = measures.build()
        self.drivetrain.reset_pose(Pose2d(2.3, 4.2, 0.0))
        self.orientation = FRONT.getDoubleArrayTopic("robot_orientation_set").publish()
        self.botpose = FRONT.getDoubleArrayTopic("botpose_orb_wpiblue").subscribe([])
        self.quest = Quest()
        FRONT.getEntry("ledMode").setDouble(1.0)
        FRONT.getEntry("fiducial_offset_set").setDoubleArray([0.0, 0.1, 0.0])
        FRONT.getEntry("priorityID").setDouble(25.0)  # it is called priorityid
        Vision.table.getEntry("pipeline").setDouble(0.0)
        self.has_told_quest = False

    def robotPeriodic(self) -> None:
        self.drivetrain.set_control(measures.driver_request())
        pose = self.drivetrain.get_state().pose
        self.orientation.set([pose.rotation().degrees(), 0.0, 0.0, 0.0, 0.0, 0.0])
        self.quest.read()
        if not self.has_told_quest and self.quest.pose is not None:
            self.has_told_quest = True
            self.quest.set_pose(Pose3d(pose).transformBy(ROBOT_TO_QUEST))

    def seen(self) -> dict:
        """What the front camera tells, each topic read as robots read it."""
        return {
            "tv": FRONT.getEntry("tv").getInteger(0),
            "tid": FRONT.getEntry("tid").getInteger(-1),
            "tx": FRONT.getEntry("tx").getDouble(0.0),
            "ty": FRONT.getNumber("ty", 0.0),
            "ta": FRONT.getEntry("ta").getDouble(0.0),
            "raw": FRONT.getEntry("rawfiducials").getDoubleArray([]),
            "targets": FRONT.getEntry("rawtargets").getDoubleArray([]),
            "target": FRONT.getEntry("targetpose_robotspace").getDoubleArray([]),
            "json": FRONT.getEntry("json").getString(""),
            "botpose": self.botpose.get(),
            "type": FRONT.getEntry("getpipetype").getString(""),
        }

    def quest_device(self):
        return list(fields(self.quest.device.get()))

    def quest_response(self):
        return list(fields(self.quest.response.get()))

    def ask(self, **topics: float) -> None:
        for name, value in topics.items():
            FRONT.getEntry(name).setDouble(value)
