"""TimedRobot that reads two Limelights, one of them in simcore.toml, and a QuestNav headset, all by topics.

It opens its tables at the top of the file, in a class and at start, as robot programs do.
"""

import math

import measures
import wpilib
from ntcore import NetworkTableInstance
from questnav import QuestNav, fields
from wpimath.geometry import Pose2d, Pose3d, Rotation3d, Transform3d

FRONT = NetworkTableInstance.getDefault().getTable("limelight-front")
ROBOT_TO_QUEST = Transform3d(-0.2, 0.1, 0.6, Rotation3d(0.0, 0.0, math.pi))


class Vision:
    table = NetworkTableInstance.getDefault().getTable("limelight")


class Quest(QuestNav):
    def __init__(self) -> None:
        super().__init__()
        table = NetworkTableInstance.getDefault().getTable("QuestNav")
        kind = "proto:questnav.protos.{}.ProtobufQuestNav{}"
        self.device = table.getRawTopic("deviceData").subscribe(kind.format("data", "DeviceData"), b"")
        self.response = table.getRawTopic("response").subscribe(kind.format("commands", "CommandResponse"), b"")
        self.pose = None
        self.ages = []
        self.numbers = []
        self.tracking = False

    def read(self) -> None:
        for frame in self.unread_frames():
            self.pose = frame.pose.transformBy(ROBOT_TO_QUEST.inverse())
            self.tracking = frame.is_tracking
            self.numbers.append(frame.number)
            self.ages.append(wpilib.Timer.getFPGATimestamp() - frame.time)


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.drivetrain = measures.build()
        self.drivetrain.reset_pose(Pose2d(2.3, 4.2, 0.0))
        self.orientation = FRONT.getDoubleArrayTopic("robot_orientation_set").publish()
        self.botpose = FRONT.getDoubleArrayTopic("botpose_orb_wpiblue").subscribe([])
        self.quest = Quest()
        FRONT.getEntry("ledMode").setDouble(1.0)
        FRONT.getEntry("fiducial_offset_set").setDoubleArray([0.0, 0.1, 0.0])
        FRONT.getEntry("priorityID").setDouble(25.0)  # a mistake: the topic is priorityid
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
        """Return the values of the front camera, each topic read as robot programs do."""
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
        return list(fields(self.quest.device.get()).items())

    def quest_response(self):
        return list(fields(self.quest.response.get()).items())

    def ask(self, **topics: float) -> None:
        for name, value in topics.items():
            FRONT.getEntry(name).setDouble(value)
