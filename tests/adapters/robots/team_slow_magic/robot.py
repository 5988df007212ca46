"""A MagicBot with loops of 30 ms, an arm and an elevator; the drive motors follow a torque current, and the drivetrain
derives CTRE's inside a component that waits for its devices at start as teams do who had configurations fail."""

import magicbot
import measures
import wpilib
from magicbot import feedback, tunable
from phoenix6 import CANBus, StatusCode, configs, controls, hardware, signals, swerve
from phoenix6.swerve import SwerveModule, requests
from wpimath.geometry import Pose2d


class Swerve(swerve.SwerveDrivetrain):
    def __init__(self, *args) -> None:
        super().__init__(*args)
        self.request = requests.RobotCentric().with_drive_request_type(SwerveModule.DriveRequestType.VELOCITY)


def configured(number: int, config: configs.TalonFXConfiguration, cls=hardware.TalonFX):
    """Applies and reads back until both are fine, five times at the most."""
    device = cls(number, CANBus(""))
    for _ in range(5):
        back = type(config)()
        if device.configurator.apply(config).is_ok() and device.configurator.refresh(back) == StatusCode.OK:
            break
    return device


class Chassis:
    def __init__(self) -> None:
        self.swerve = measures.build(Swerve, torque_current=True, coupling=3.57, inverted_steer=False)

    def on_enable(self) -> None:
        self.goal = (0.0, 0.0, 0.0)

    def drive(self, vx: float, vy: float, turn: float) -> None:
        self.goal = (vx, vy, turn)

    def execute(self) -> None:
        if wpilib.DriverStation.isEnabled():
            vx, vy, turn = self.goal
            request = self.swerve.request
            self.swerve.set_control(request.with_velocity_x(vx).with_velocity_y(vy).with_rotational_rate(turn))


class Lift:
    height = tunable(0.0)

    def setup(self) -> None:
        config = configs.TalonFXConfiguration()
        config.feedback.sensor_to_mechanism_ratio = 9.0
        config.slot0.k_p, config.slot0.k_g = 60.0, 0.35
        config.slot0.gravity_type = signals.GravityTypeValue.ELEVATOR_STATIC
        config.motion_magic.motion_magic_cruise_velocity = 4.0
        config.motion_magic.motion_magic_acceleration = 12.0
        self.motor = configured(31, config)
        self.follower = hardware.TalonFX(32)
        self.follower.set_control(controls.Follower(31, signals.MotorAlignmentValue.OPPOSED))

    @feedback
    def position(self) -> float:
        return self.motor.get_position().value

    def execute(self) -> None:
        self.motor.set_control(controls.MotionMagicVoltage(self.height))


class Arm:
    angle = tunable(0.0)

    def setup(self) -> None:
        config = configs.TalonFXConfiguration()
        config.feedback.feedback_sensor_source = signals.FeedbackSensorSourceValue.FUSED_CANCODER
        config.feedback.feedback_remote_sensor_id = 33
        config.feedback.rotor_to_sensor_ratio = 60.0
        config.slot0.k_p, config.slot0.k_d = 90.0, 1.0
        self.encoder = hardware.CANcoder(33)
        self.motor = configured(33, config)

    def execute(self) -> None:
        self.motor.set_control(controls.PositionVoltage(self.angle))


class SlowRobot(magicbot.MagicRobot):
    control_loop_wait_time = 0.03
    chassis: Chassis
    lift: Lift
    arm: Arm

    def createObjects(self) -> None:
        self.pad = wpilib.XboxController(0)

    def autonomousInit(self) -> None:
        self.chassis.swerve.reset_pose(Pose2d(3.0, 2.0, 0.0))
        self.chassis.drive(0.5, 0.0, 0.0)

    def teleopPeriodic(self) -> None:
        self.chassis.drive(-3.5 * self.pad.getLeftY(), -3.5 * self.pad.getLeftX(), -3.5 * self.pad.getRightX())
        self.lift.height = 2.0 if self.pad.getYButton() else 0.0
        self.arm.angle = 0.2 if self.pad.getXButton() else 0.0

    def facts(self) -> dict:
        return {"lift": self.lift.position(), "arm": self.arm.motor.get_position().value}
