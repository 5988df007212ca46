"""A MagicBot whose drivetrain is a member of a component, driven by torque current, with inverted steers."""

import magicbot
import wpilib
from phoenix6 import configs, hardware, swerve
from phoenix6.swerve import requests

INCH = 0.0254


class Chassis:
    def setup(self) -> None:
        factory = (
            swerve.SwerveModuleConstantsFactory()
            .with_drive_motor_gear_ratio(6.12)
            .with_steer_motor_gear_ratio(21.428571428571427)
            .with_coupling_gear_ratio(3.5714285714285716)
            .with_wheel_radius(2 * INCH)
            .with_steer_motor_gains(configs.Slot0Configs().with_k_p(80).with_k_d(0.5).with_k_v(2.66))
            .with_drive_motor_gains(configs.Slot0Configs().with_k_p(15).with_k_s(2.0))
            .with_drive_motor_closed_loop_output(swerve.ClosedLoopOutputType.TORQUE_CURRENT_FOC)
            .with_slip_current(80.0)
            .with_speed_at12_volts(5.0)
            .with_feedback_source(swerve.SteerFeedbackType.FUSED_CANCODER)
            .with_drive_motor_initial_configs(configs.TalonFXConfiguration())
            .with_steer_motor_initial_configs(configs.TalonFXConfiguration())
            .with_encoder_initial_configs(configs.CANcoderConfiguration())
        )
        modules = [
            factory.create_module_constants(k + 1, k + 11, k + 21, 0.1 * k, x * INCH, y * INCH, y < 0, True, False)
            for k, (x, y) in enumerate(((10, 10), (10, -10), (-10, 10), (-10, -10)))
        ]
        constants = swerve.SwerveDrivetrainConstants().with_pigeon2_id(3)
        self.hardware = swerve.SwerveDrivetrain(
            hardware.TalonFX, hardware.TalonFX, hardware.CANcoder, constants, modules
        )
        self.request = (
            requests.RobotCentric()
            .with_velocity_y(2.0)
            .with_drive_request_type(swerve.SwerveModule.DriveRequestType.VELOCITY)
        )

    def execute(self) -> None:
        if wpilib.DriverStation.isEnabled():
            self.hardware.set_control(self.request)


class Robot(magicbot.MagicRobot):
    chassis: Chassis

    def createObjects(self) -> None:
        pass
