"""CTRE's swerve on a CANivore; on the roboRIO's own bus a shooter, an arm and a roller with ids of the swerve's."""

import measures
import wpilib
from phoenix6 import configs, controls, hardware, signals


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.drivetrain = measures.build(bus="canivore", inverted_steer=True, coupling=3.5)
        self.shooter, self.partner = measures.talon(1, k_v=0.125, k_p=0.3), hardware.TalonFX(3)
        self.partner.set_control(controls.Follower(1, signals.MotorAlignmentValue.OPPOSED))
        self.encoder, self.arm = hardware.CANcoder(21), hardware.TalonFX(11)
        config = configs.TalonFXConfiguration()
        config.feedback.feedback_sensor_source = signals.FeedbackSensorSourceValue.FUSED_CANCODER
        config.feedback.feedback_remote_sensor_id = 21
        config.feedback.rotor_to_sensor_ratio = 45.0
        config.slot0.k_p, config.slot0.k_d = 90.0, 1.0
        self.arm.configurator.apply(config)
        self.roller = measures.talon(2, ratio=3.0, k_v=0.4, k_p=0.2)

    def teleopPeriodic(self) -> None:
        self.drivetrain.set_control(measures.driver_request())
        self.shooter.set_control(controls.VelocityVoltage(50.0))
        self.arm.set_control(controls.PositionVoltage(0.2))
        self.roller.set_control(controls.VelocityVoltage(10.0))
