from robot import PLACES, PULSES, WHEEL_RADIUS, ZEROS

from games.rebuilt import REBUILT
from simcore import Match, RobotConfig, RobotEntry, RobotPhysics, SwerveConfig, SwerveModuleConfig
from simcore.devices.motor_ports import SwervePorts
from simcore.robot.chassis_config import ChassisConfig
from simcore.robot.dc_motor import motor
from simcore.robotpy.wpilib_ports import AbsoluteEncoderPort, EncoderPort, PWMMotorPort, WPILibGyroPort

NEO = motor("NEO")


class PhysicsEngine(RobotPhysics):
    def __init__(self, physics_controller, robot):
        modules = tuple(
            SwerveModuleConfig(
                x=x, y=y, drive_motor=NEO, steer_motor=NEO, wheel_radius=WHEEL_RADIUS, drive_stator_limit=60.0
            )
            for x, y in PLACES
        )
        build = RobotConfig(
            chassis=ChassisConfig(wheel_positions=PLACES, wheel_radius=WHEEL_RADIUS),
            drivetrain=SwerveConfig(modules=modules),
        )
        match = Match(REBUILT, robots=[RobotEntry(config=build, start=(2.0, 1.2, 0.0), preload=0)])
        devices = SwervePorts(
            match.robots[0].drive,
            [PWMMotorPort(m.drive) for m in robot.modules],
            [PWMMotorPort(m.steer) for m in robot.modules],
            steer_encoders=[AbsoluteEncoderPort(m.azimuth, zero=z) for m, z in zip(robot.modules, ZEROS, strict=True)],
            wheel_encoders=[EncoderPort(m.wheel, pulses_per_turn=PULSES) for m in robot.modules],
            gyro=WPILibGyroPort(robot.gyro),
        )
        super().__init__(physics_controller, robot, match=match, drivetrain=devices, pace_tests=False)
