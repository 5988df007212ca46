"""Command-based robot in the style of CTRE's generator: the drivetrain subsystem steps CTRE's simulation at 250 Hz.

Its other mechanisms are not described in a file: a shooter with two followers, an elevator and an arm with gravity
gains, and a turret with an absolute encoder.
"""

import commands2
import measures
import wpilib
from commands2 import Subsystem
from phoenix6 import configs, controls, hardware, signals, swerve, utils


class CommandSwerveDrivetrain(Subsystem, swerve.SwerveDrivetrain):
    def __init__(self, *args) -> None:
        Subsystem.__init__(self)
        swerve.SwerveDrivetrain.__init__(self, *args)
        self._last = utils.get_current_time_seconds()
        self._sim_notifier = wpilib.Notifier(self._step)
        self._sim_notifier.startPeriodic(0.004)
        self.steps = 0

    def _step(self) -> None:
        now = utils.get_current_time_seconds()
        self.update_sim_state(now - self._last, wpilib.RobotController.getBatteryVoltage())
        self._last = now
        self.steps += 1


class Mechanisms(Subsystem):
    def __init__(self) -> None:
        super().__init__()
        self.shooter = measures.talon(31, ratio=0.75, k_v=0.093, k_p=0.3, k_s=0.1)
        self.followers = [hardware.TalonFX(32), hardware.TalonFX(33)]
        for follower, how in zip(self.followers, ("ALIGNED", "OPPOSED"), strict=True):
            follower.set_control(controls.Follower(31, signals.MotorAlignmentValue[how]))
        self.elevator = measures.talon(34, ratio=9.0, k_p=60.0, k_d=1.0, k_g=0.35)
        arm = signals.GravityTypeValue.ARM_COSINE
        self.arm = measures.talon(35, ratio=45.0, k_p=90.0, k_d=1.0, k_g=0.4, gravity_type=arm)
        self.arm.set_position(-0.1)
        self.encoder = hardware.CANcoder(36)
        self.encoder.configurator.apply(configs.MagnetSensorConfigs().with_magnet_offset(0.17))
        self.turret = hardware.TalonFX(36)
        config = configs.TalonFXConfiguration()
        config.feedback.feedback_sensor_source = signals.FeedbackSensorSourceValue.FUSED_CANCODER
        config.feedback.feedback_remote_sensor_id = 36
        config.feedback.rotor_to_sensor_ratio = 25.0
        config.slot0.k_p = 60.0
        config.slot0.k_d = 0.5
        self.turret.configurator.apply(config)
        self.roller = measures.talon(
            37, cls=hardware.TalonFXS, ratio=3.0, arrangement=signals.MotorArrangementValue.MINION_JST, k_v=0.3, k_p=0.2
        )

    def run_all(self) -> None:
        self.shooter.set_control(controls.VelocityVoltage(60.0))
        self.elevator.set_control(controls.PositionVoltage(3.0))
        self.arm.set_control(controls.PositionVoltage(0.2))
        self.turret.set_control(controls.PositionVoltage(0.4))
        self.roller.set_control(controls.VelocityVoltage(10.0))


class Robot(commands2.TimedCommandRobot):
    def robotInit(self) -> None:
        self.drivetrain = measures.build(CommandSwerveDrivetrain, inverted_steer=True, coupling=3.57)
        self.mechanisms = Mechanisms()
        self.drivetrain.setDefaultCommand(
            self.drivetrain.run(lambda: self.drivetrain.set_control(measures.driver_request()))
        )
        self.mechanisms.setDefaultCommand(self.mechanisms.run(self.mechanisms.run_all))

    def facts(self) -> dict:
        m = self.mechanisms
        return {
            "notifier_steps": self.drivetrain.steps,
            "shooter_rps": m.shooter.get_velocity().value,
            "follower_rps": [f.get_velocity().value for f in m.followers],
            "elevator": m.elevator.get_position().value,
            "arm": m.arm.get_position().value,
            "turret": m.turret.get_position().value,
            "encoder": m.encoder.get_position().value,
            "roller_rps": m.roller.get_velocity().value,
        }
