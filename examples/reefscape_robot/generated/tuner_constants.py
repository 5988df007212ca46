"""What Tuner X's swerve project generator writes for this robot."""

from phoenix6 import configs, hardware, signals, swerve, units
from subsystems.command_swerve_drivetrain import CommandSwerveDrivetrain
from wpimath.units import inchesToMeters


class TunerConstants:
    """Gains, ids and measures of the drivetrain."""

    _steer_gains = (
        configs.Slot0Configs()
        .with_k_p(100)
        .with_k_i(0)
        .with_k_d(0.5)
        .with_k_s(0.1)
        .with_k_v(2.66)
        .with_k_a(0)
        .with_static_feedforward_sign(signals.StaticFeedforwardSignValue.USE_CLOSED_LOOP_SIGN)
    )
    _drive_gains = configs.Slot0Configs().with_k_p(0.1).with_k_i(0).with_k_d(0).with_k_s(0.2).with_k_v(0.124)

    _steer_closed_loop_output = swerve.ClosedLoopOutputType.VOLTAGE
    _drive_closed_loop_output = swerve.ClosedLoopOutputType.VOLTAGE
    _slip_current: units.ampere = 80.0

    _drive_initial_configs = configs.TalonFXConfiguration().with_current_limits(
        configs.CurrentLimitsConfigs().with_supply_current_limit(45).with_supply_current_limit_enable(True)
    )
    _steer_initial_configs = configs.TalonFXConfiguration().with_current_limits(
        configs.CurrentLimitsConfigs().with_stator_current_limit(60).with_stator_current_limit_enable(True)
    )
    _encoder_initial_configs = configs.CANcoderConfiguration()

    speed_at_12_volts: units.meters_per_second = 4.55

    _couple_ratio = 3.5714285714285716
    _drive_gear_ratio = 6.75
    _steer_gear_ratio = 21.428571428571427
    _wheel_radius: units.meter = inchesToMeters(2)

    _invert_left_side = False
    _invert_right_side = True
    _pigeon_id = 0

    drivetrain_constants = swerve.SwerveDrivetrainConstants().with_can_bus_name("").with_pigeon2_id(_pigeon_id)

    _constants_creator = (
        swerve.SwerveModuleConstantsFactory()
        .with_drive_motor_gear_ratio(_drive_gear_ratio)
        .with_steer_motor_gear_ratio(_steer_gear_ratio)
        .with_coupling_gear_ratio(_couple_ratio)
        .with_wheel_radius(_wheel_radius)
        .with_steer_motor_gains(_steer_gains)
        .with_drive_motor_gains(_drive_gains)
        .with_steer_motor_closed_loop_output(_steer_closed_loop_output)
        .with_drive_motor_closed_loop_output(_drive_closed_loop_output)
        .with_slip_current(_slip_current)
        .with_speed_at12_volts(speed_at_12_volts)
        .with_drive_motor_type(swerve.DriveMotorArrangement.TALON_FX_INTEGRATED)
        .with_steer_motor_type(swerve.SteerMotorArrangement.TALON_FX_INTEGRATED)
        .with_feedback_source(swerve.SteerFeedbackType.FUSED_CANCODER)
        .with_drive_motor_initial_configs(_drive_initial_configs)
        .with_steer_motor_initial_configs(_steer_initial_configs)
        .with_encoder_initial_configs(_encoder_initial_configs)
        .with_steer_inertia(0.01)
        .with_drive_inertia(0.01)
        .with_steer_friction_voltage(0.2)
        .with_drive_friction_voltage(0.2)
    )

    _x: units.meter = inchesToMeters(10.5)
    _y: units.meter = inchesToMeters(10.5)

    # steer id, drive id, encoder id, encoder offset, x, y, drive inverted, steer inverted, encoder inverted
    front_left = _constants_creator.create_module_constants(1, 2, 1, 0.152, _x, _y, _invert_left_side, True, False)
    front_right = _constants_creator.create_module_constants(3, 4, 2, -0.488, _x, -_y, _invert_right_side, True, False)
    back_left = _constants_creator.create_module_constants(5, 6, 3, 0.219, -_x, _y, _invert_left_side, True, False)
    back_right = _constants_creator.create_module_constants(7, 8, 4, 0.173, -_x, -_y, _invert_right_side, True, False)

    @classmethod
    def create_drivetrain(cls) -> CommandSwerveDrivetrain:
        """The drivetrain; call once."""
        return CommandSwerveDrivetrain(
            hardware.TalonFX,
            hardware.TalonFX,
            hardware.CANcoder,
            cls.drivetrain_constants,
            [cls.front_left, cls.front_right, cls.back_left, cls.back_right],
        )
