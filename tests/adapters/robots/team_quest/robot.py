"""A TimedRobot with a Quest headset: it tells the headset its pose when the auto begins, and takes every tracked frame
into the drivetrain's filter. Steers not inverted, coupling 3.57, an odometry frequency of its own."""

import measures
import wpilib
from phoenix6 import controls, hardware, swerve, utils
from phoenix6.swerve import SwerveModule, requests
from questnav import QuestNav
from wpimath.geometry import Pose2d, Pose3d, Rotation3d, Transform3d, Translation3d

ROBOT_TO_QUEST = Transform3d(Translation3d(0.15, 0.2, 0.5), Rotation3d.fromDegrees(0, 0, 90))


class Drivetrain(swerve.SwerveDrivetrain):
    def __init__(self, drive, steer, encoder, constants, modules) -> None:
        super().__init__(drive, steer, encoder, constants, 200.0, modules)


class Robot(wpilib.TimedRobot):
    def __init__(self) -> None:
        super().__init__(0.02)
        self.swerve = measures.build(Drivetrain, inverted_steer=False, coupling=3.57)
        self.quest = QuestNav()
        self.pad = wpilib.XboxController(0)
        self.request = requests.FieldCentric().with_drive_request_type(SwerveModule.DriveRequestType.VELOCITY)
        self.lights = hardware.CANdle(30)
        self.range = hardware.CANrange(31)
        self.climber = measures.talon(32, ratio=25.0)
        self.frames = 0
        self.is_told = False

    def start_at(self, pose: Pose2d) -> None:
        self.swerve.reset_pose(pose)
        self.is_told = True
        self.quest.set_pose(Pose3d(pose).transformBy(ROBOT_TO_QUEST))

    def robotPeriodic(self) -> None:
        for frame in self.quest.unread_frames():
            if self.is_told and frame.is_tracking and self.quest.is_connected():
                self.frames += 1
                robot = frame.pose.transformBy(ROBOT_TO_QUEST.inverse()).toPose2d()
                time = utils.fpga_to_current_time(frame.time)
                self.swerve.add_vision_measurement(robot, time, (0.02, 0.02, 0.035))
        color = controls.SolidColor(0, 8)
        self.lights.set_control(color)
        wpilib.SmartDashboard.putNumber("Piece distance", self.range.get_distance().value)

    def disabledPeriodic(self) -> None:
        self.swerve.set_control(requests.Idle())

    def autonomousInit(self) -> None:
        is_red = wpilib.DriverStation.getAlliance() == wpilib.DriverStation.Alliance.kRed
        start = Pose2d(3.5, 5.0, 0.0)
        self.start_at(measures.for_red(start) if is_red else start)
        self.goal = self.swerve.get_state().pose

    def autonomousPeriodic(self) -> None:
        speeds = measures.toward(self.swerve.get_state().pose, self.goal)
        self.swerve.set_control(requests.ApplyFieldSpeeds().with_speeds(speeds))

    def teleopInit(self) -> None:
        if not self.is_told:
            self.start_at(self.swerve.get_state().pose)

    def teleopPeriodic(self) -> None:
        self.swerve.set_control(
            self.request.with_velocity_x(-3.5 * self.pad.getLeftY())
            .with_velocity_y(-3.5 * self.pad.getLeftX())
            .with_rotational_rate(-3.5 * self.pad.getRightX())
        )
        self.climber.set_control(controls.DutyCycleOut(0.5 if self.pad.getYButton() else 0.0))

    def facts(self) -> dict:
        return {
            "frames": self.frames,
            "connected": self.quest.is_connected(),
            "climber": self.climber.get_velocity().value,
        }
