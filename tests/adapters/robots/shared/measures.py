"""Swerve drivetrains with dimensions other than simcore's defaults; copied next to the robots of these tests."""

import wpilib
from phoenix6 import CANBus, configs, hardware, signals, swerve
from phoenix6.swerve import requests

INCH = 0.0254


def modules(
    *,
    inverted_steer: bool = True,
    coupling: float = 0.0,
    torque_current: bool = False,
    fxs: bool = False,
    slip_current: float = 90.0,
    k_s: float = 0.0,
) -> list:
    """Return four modules with ids 1-4, 11-14, 21-24; right drive motors and one encoder are inverted."""
    drive = configs.Slot0Configs().with_k_s(k_s).with_k_p(0.2).with_k_v(0.124)
    output = swerve.ClosedLoopOutputType.VOLTAGE
    if torque_current:
        drive = configs.Slot0Configs().with_k_p(15).with_k_s(2.0)
        output = swerve.ClosedLoopOutputType.TORQUE_CURRENT_FOC
    steer_motor, feedback = swerve.SteerMotorArrangement.TALON_FX_INTEGRATED, swerve.SteerFeedbackType.FUSED_CANCODER
    steer_configs = configs.TalonFXConfiguration()
    if fxs:
        steer_motor = swerve.SteerMotorArrangement.TALON_FXS_MINION_JST
        feedback = swerve.SteerFeedbackType.FUSED_CANDI_PWM1
        steer_configs = configs.TalonFXSConfiguration()
    factory = (
        swerve.SwerveModuleConstantsFactory()
        .with_drive_motor_gear_ratio(5.9)
        .with_steer_motor_gear_ratio(18.75)
        .with_coupling_gear_ratio(coupling)
        .with_wheel_radius(1.95 * INCH)
        .with_steer_motor_gains(configs.Slot0Configs().with_k_p(60 if fxs else 80).with_k_d(0.4).with_k_v(2.3))
        .with_drive_motor_gains(drive)
        .with_drive_motor_closed_loop_output(output)
        .with_slip_current(slip_current)
        .with_speed_at12_volts(4.9)
        .with_steer_motor_type(steer_motor)
        .with_feedback_source(feedback)
        .with_drive_motor_initial_configs(configs.TalonFXConfiguration())
        .with_steer_motor_initial_configs(steer_configs)
        .with_encoder_initial_configs(configs.CANdiConfiguration() if fxs else configs.CANcoderConfiguration())
    )
    corners = ((11.5, 9.0), (11.5, -9.0), (-11.5, 9.0), (-11.5, -9.0))
    return [
        factory.create_module_constants(
            *(k + 1, k + 11, k + 21, 0.11 * k - 0.2, x * INCH, y * INCH, y < 0, inverted_steer, k == 2)
        )
        for k, (x, y) in enumerate(corners)
    ]


def build(drivetrain=swerve.SwerveDrivetrain, *, bus="", **settings):
    """Return a drivetrain of the given modules and Pigeon 9."""
    constants = swerve.SwerveDrivetrainConstants().with_can_bus_name(bus).with_pigeon2_id(9)
    steer, encoder = hardware.TalonFX, hardware.CANcoder
    if settings.get("fxs"):
        steer, encoder = hardware.TalonFXS, hardware.CANdi
    return drivetrain(hardware.TalonFX, steer, encoder, constants, modules(**settings))


def driver_request():
    """Return the robot-centric request of the first gamepad's sticks, up to 3 m/s and 3 rad/s."""
    axis = wpilib.DriverStation.getStickAxis
    return (
        requests.RobotCentric()
        .with_velocity_x(-3.0 * axis(0, 1))
        .with_velocity_y(-3.0 * axis(0, 0))
        .with_rotational_rate(-3.0 * axis(0, 4))
        .with_drive_request_type(swerve.SwerveModule.DriveRequestType.VELOCITY)
    )


def talon(number, *, cls=hardware.TalonFX, ratio=1.0, arrangement=None, **gains):
    """Return a configured motor controller."""
    device = cls(number, CANBus(""))
    config = configs.TalonFXConfiguration() if cls is hardware.TalonFX else configs.TalonFXSConfiguration()
    feedback = config.feedback if cls is hardware.TalonFX else config.external_feedback
    feedback.sensor_to_mechanism_ratio = ratio
    config.motor_output.inverted = signals.InvertedValue.CLOCKWISE_POSITIVE
    config.motor_output.neutral_mode = signals.NeutralModeValue.BRAKE
    if arrangement is not None:
        config.commutation.motor_arrangement = arrangement
    for name, value in gains.items():
        setattr(config.slot0, name, value)
    device.configurator.apply(config)
    return device
