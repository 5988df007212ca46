from typing import TYPE_CHECKING

from phoenix6 import CANBus, configs, hardware, signals, swerve

if TYPE_CHECKING:
    from subsystems.command_swerve_drivetrain import CommandSwerveDrivetrain

INCH = 0.0254


class TunerConstants:
    _steer_gains = (
        configs.Slot0Configs()
        .with_k_p(100)
        .with_k_i(0)
        .with_k_d(0.5)
        .with_k_s(0.1)
        .with_k_v(2.49)
        .with_static_feedforward_sign(signals.StaticFeedforwardSignValue.USE_CLOSED_LOOP_SIGN)
    )
    _drive_gains = configs.Slot0Configs().with_k_p(0.1).with_k_s(0).with_k_v(0.124)
    _steer_initial_configs = configs.TalonFXConfiguration().with_current_limits(
        configs.CurrentLimitsConfigs().with_stator_current_limit(60).with_stator_current_limit_enable(True)
    )
    canbus = CANBus("rio", "./logs/example.hoot")
    speed_at_12_volts = 4.58
    drivetrain_constants = (
        swerve.SwerveDrivetrainConstants().with_can_bus_name(canbus.name).with_pigeon2_id(20).with_pigeon2_configs(None)
    )
    _creator = (
        swerve.SwerveModuleConstantsFactory()
        .with_drive_motor_gear_ratio(6.746031746031747)
        .with_steer_motor_gear_ratio(21.428571428571427)
        .with_coupling_gear_ratio(3.5714285714285716)
        .with_wheel_radius(2.0 * INCH)
        .with_steer_motor_gains(_steer_gains)
        .with_drive_motor_gains(_drive_gains)
        .with_steer_motor_closed_loop_output(swerve.ClosedLoopOutputType.VOLTAGE)
        .with_drive_motor_closed_loop_output(swerve.ClosedLoopOutputType.VOLTAGE)
        .with_slip_current(120.0)
        .with_speed_at12_volts(speed_at_12_volts)
        .with_feedback_source(swerve.SteerFeedbackType.FUSED_CANCODER)
        .with_drive_motor_initial_configs(configs.TalonFXConfiguration())
        .with_steer_motor_initial_configs(_steer_initial_configs)
        .with_encoder_initial_configs(configs.CANcoderConfiguration())
        .with_steer_inertia(0.01)
        .with_drive_inertia(0.01)
        .with_steer_friction_voltage(0.2)
        .with_drive_friction_voltage(0.2)
    )
    # steer, drive, encoder, offset, x, y, drive inverted, steer inverted, encoder inverted
    front_left = _creator.create_module_constants(2, 1, 11, 0.1235, 10.75 * INCH, 10.75 * INCH, False, True, False)
    front_right = _creator.create_module_constants(4, 3, 12, -0.3381, 10.75 * INCH, -10.75 * INCH, True, True, False)
    back_left = _creator.create_module_constants(6, 5, 13, 0.4121, -10.75 * INCH, 10.75 * INCH, False, True, False)
    back_right = _creator.create_module_constants(8, 7, 14, -0.0562, -10.75 * INCH, -10.75 * INCH, True, True, False)

    @classmethod
    def create_drivetrain(cls) -> "CommandSwerveDrivetrain":
        from subsystems.command_swerve_drivetrain import CommandSwerveDrivetrain

        modules = [cls.front_left, cls.front_right, cls.back_left, cls.back_right]
        return CommandSwerveDrivetrain(cls.drivetrain_constants, modules)


class TunerSwerveDrivetrain(swerve.SwerveDrivetrain[hardware.TalonFX, hardware.TalonFX, hardware.CANcoder]):
    """Drivetrain of the library with these devices; `None` arguments are completed."""

    def __init__(self, constants, arg0=None, arg1=None, arg2=None, arg3=None) -> None:
        swerve.SwerveDrivetrain.__init__(
            self, hardware.TalonFX, hardware.TalonFX, hardware.CANcoder, constants, arg0, arg1, arg2, arg3
        )
