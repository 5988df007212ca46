"""A TimedRobot without commands, with a drivetrain of its own measures; its period comes from the environment."""

import os

import wpilib
from phoenix6 import configs, hardware, swerve
from phoenix6.swerve import requests

INCH = 0.0254


def modules(slip_current=90.0):
    factory = (
        swerve.SwerveModuleConstantsFactory()
        .with_drive_motor_gear_ratio(5.9)
        .with_steer_motor_gear_ratio(18.75)
        .with_coupling_gear_ratio(0.0)
        .with_wheel_radius(1.9 * INCH)
        .with_steer_motor_gains(configs.Slot0Configs().with_k_p(80).with_k_d(0.4).with_k_v(2.3))
        .with_drive_motor_gains(configs.Slot0Configs().with_k_s(0.25).with_k_p(0.2).with_k_v(0.124))
        .with_slip_current(slip_current)
        .with_speed_at12_volts(4.9)
        .with_feedback_source(swerve.SteerFeedbackType.FUSED_CANCODER)
        .with_drive_motor_initial_configs(configs.TalonFXConfiguration())
        .with_steer_motor_initial_configs(configs.TalonFXConfiguration())
        .with_encoder_initial_configs(configs.CANcoderConfiguration())
    )
    rows = (
        (31, 41, 51, 0.11, 11.5, 9.0, True, False, True),
        (32, 42, 52, 0.42, 11.5, -9.0, False, False, True),
        (33, 43, 53, -0.3, -11.5, 9.0, True, True, False),
        (34, 44, 54, 0.0, -11.5, -9.0, False, True, False),
    )
    return [
        factory.create_module_constants(s, d, e, offset, x * INCH, y * INCH, *inverted)
        for s, d, e, offset, x, y, *inverted in rows
    ]


class Robot(wpilib.TimedRobot):
    def __init__(self) -> None:
        super().__init__(float(os.environ.get("ROBOT_PERIOD", "0.02")))

    def robotInit(self) -> None:
        constants = swerve.SwerveDrivetrainConstants().with_can_bus_name("").with_pigeon2_id(9)
        self.drivetrain = swerve.SwerveDrivetrain(
            hardware.TalonFX, hardware.TalonFX, hardware.CANcoder, constants, modules()
        )
        self.drive = (
            requests.RobotCentric()
            .with_velocity_x(2.0)
            .with_drive_request_type(swerve.SwerveModule.DriveRequestType.VELOCITY)
        )

    def teleopPeriodic(self) -> None:
        self.drivetrain.set_control(self.drive)

    def _simulationPeriodic(self) -> None:
        raise AssertionError("pyfrc replaces this hook")
