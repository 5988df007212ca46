"""Swerve drivetrains of other measures than simcore's own, for the robots of these tests; copied beside each."""

import math

import wpilib
from phoenix6 import CANBus, configs, hardware, signals, swerve
from phoenix6.swerve import requests
from wpimath.geometry import Pose2d, Rotation2d, Translation2d
from wpimath.kinematics import ChassisSpeeds

INCH = 0.0254


def modules(
    *,
    inverted_steer: bool = True,
    coupling: float = 0.0,
    torque_current: bool = False,
    fxs: bool = False,
    slip_current: float = 90.0,
) -> list:
    """Four modules with ids 1-4, 11-14, 21-24; the right side's drive motors and one encoder are inverted."""
    drive = configs.Slot0Configs().with_k_p(0.2).with_k_v(0.124)
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
    """A drivetrain of these modules and Pigeon 9."""
    constants = swerve.SwerveDrivetrainConstants().with_can_bus_name(bus).with_pigeon2_id(9)
    steer, encoder = hardware.TalonFX, hardware.CANcoder
    if settings.get("fxs"):
        steer, encoder = hardware.TalonFXS, hardware.CANdi
    return drivetrain(hardware.TalonFX, steer, encoder, constants, modules(**settings))


def driver_request():
    """What the first gamepad's sticks ask for, robot-centric: 3 m/s and 3 rad/s at the most."""
    axis = wpilib.DriverStation.getStickAxis
    return (
        requests.RobotCentric()
        .with_velocity_x(-3.0 * axis(0, 1))
        .with_velocity_y(-3.0 * axis(0, 0))
        .with_rotational_rate(-3.0 * axis(0, 4))
        .with_drive_request_type(swerve.SwerveModule.DriveRequestType.VELOCITY)
    )


def talon(number, *, cls=hardware.TalonFX, ratio=1.0, arrangement=None, **gains):
    """A configured motor controller."""
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


HUB = Translation2d(4.625, 4.035)


def hub_of(alliance_is_red: bool) -> Translation2d:
    """Center of the alliance's hub on the field of 2026."""
    return Translation2d(16.541 - HUB.X(), 8.069 - HUB.Y()) if alliance_is_red else HUB


def shot_speed(distance: float, height: float, elevation_deg: float) -> float:
    """Speed with which a piece meets the rim of the hub, 1.83 m high, and some for the air [m/s]."""
    angle = math.radians(elevation_deg)
    rise = distance * math.tan(angle) - (1.83 - height)
    return 1.02 * math.sqrt(9.81 * distance**2 / (2.0 * math.cos(angle) ** 2 * rise))


def toward(pose: Pose2d, goal: Pose2d, fastest: float = 2.5) -> ChassisSpeeds:
    """Field speeds that bring a robot to a pose, in proportion to what is left."""
    way = goal.translation() - pose.translation()
    speed = min(fastest, 3.0 * way.norm())
    turn = (goal.rotation() - pose.rotation()).radians()
    direction = way / way.norm() if way.norm() > 1e-6 else way
    return ChassisSpeeds(direction.X() * speed, direction.Y() * speed, min(max(4.0 * turn, -4.0), 4.0))


def is_there(pose: Pose2d, goal: Pose2d) -> bool:
    """Within 8 cm and 3 degrees."""
    return (
        pose.translation().distance(goal.translation()) < 0.08
        and abs((goal.rotation() - pose.rotation()).degrees()) < 3.0
    )


def for_red(pose: Pose2d) -> Pose2d:
    """The corresponding pose on the other side: the field of 2026 is turned by half a turn."""
    return Pose2d(16.541 - pose.X(), 8.069 - pose.Y(), pose.rotation() + Rotation2d(math.pi))
