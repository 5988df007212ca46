"""Tank drive on SPARK MAX of 2027 with followers, and the onboard IMU."""

import math

import rev
import wpilib
from wpimath import DifferentialDriveKinematics, DifferentialDriveOdometry

BUS, BRUSHLESS = wpilib.CANPort.CAN_S0, rev.SparkLowLevel.MotorType.BRUSHLESS
METERS_PER_TURN = math.tau * 0.0762 / 8.45


class Robot(wpilib.TimedRobot):
    def __init__(self) -> None:
        super().__init__()
        sides = []
        for number, inverted in ((1, False), (3, True)):
            leader, follower = (rev.SparkMax(BUS, number + k, BRUSHLESS) for k in range(2))
            config = rev.SparkMaxConfig()
            config.set_idle_mode(rev.SparkMaxConfig.IdleMode.BRAKE).smart_current_limit(50).inverted(inverted)
            leader.configure(config, rev.ResetMode.RESET_SAFE_PARAMETERS, rev.PersistMode.PERSIST_PARAMETERS)
            config.follow(leader)
            follower.configure(config, rev.ResetMode.RESET_SAFE_PARAMETERS, rev.PersistMode.PERSIST_PARAMETERS)
            sides.append((leader, follower))
        (self.left, self.left_follower), (self.right, self.right_follower) = sides
        self.drive = wpilib.DifferentialDrive(self.left, self.right)
        self.imu = wpilib.OnboardIMU(wpilib.OnboardIMU.MountOrientation.FLAT)
        self.kinematics = DifferentialDriveKinematics(0.6)
        self.odometry = DifferentialDriveOdometry(self.imu.get_rotation2d(), 0.0, 0.0)
        self.pad = wpilib.Joystick(0)

    def robot_periodic(self) -> None:
        left, right = (METERS_PER_TURN * m.get_encoder().get_position().get() for m in (self.left, self.right))
        self.odometry.update(self.imu.get_rotation2d(), left, right)

    def teleop_periodic(self) -> None:
        self.drive.arcade_drive(-0.8 * self.pad.get_raw_axis(1), -0.8 * self.pad.get_raw_axis(4), False)
