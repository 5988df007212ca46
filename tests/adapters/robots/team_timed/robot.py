"""A plain TimedRobot in one file: drivetrain as a member, CANBus with a hoot path, telemetry to the signal logger, a
shooter, two feeder motors and a roller that coast when they are let go, and an auto by steps that resets its pose."""

import measures
import wpilib
from phoenix6 import CANBus, SignalLogger, configs, controls, hardware, signals
from phoenix6.swerve import SwerveModule, requests
from wpimath import applyDeadband
from wpimath.geometry import Pose2d, Rotation2d
from wpimath.kinematics import ChassisSpeeds

CANBUS = CANBus("", "./logs/timed.hoot")
START = Pose2d(2.6, 5.6, 0.0)
SWEEP = tuple(
    Pose2d(x, y, 0.0)
    for x, y in (
        *((1.3, 5.62), (0.6, 5.62), (0.6, 6.3), (0.95, 5.96), (0.5, 5.96), (0.5, 5.6)),
        *((0.9, 6.2), (0.5, 6.3), (0.5, 5.7), (1.6, 5.9)),
    )
)
HEIGHT, ELEVATION, METERS_PER_TURN = 0.5, 65.0, 0.154


def coasting(number: int, ratio: float, **gains: float) -> hardware.TalonFX:
    motor = hardware.TalonFX(number, CANBUS)
    config = configs.TalonFXConfiguration()
    config.feedback.sensor_to_mechanism_ratio = ratio
    config.motor_output.neutral_mode = signals.NeutralModeValue.COAST
    for name, value in gains.items():
        setattr(config.slot0, name, value)
    motor.configurator.apply(config)
    return motor


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        SignalLogger.enable_auto_logging(False)
        SignalLogger.set_path("./logs")
        SignalLogger.start()
        self.drivetrain = measures.build(bus=CANBUS.name, inverted_steer=True, coupling=3.5)
        self.drivetrain.register_telemetry(self.telemeterize)
        self.pad = wpilib.XboxController(0)
        self.wheels = coasting(31, 1.0, k_v=0.125, k_p=0.3)
        self.partner = coasting(32, 1.0)
        self.partner.set_control(controls.Follower(31, signals.MotorAlignmentValue.OPPOSED))
        self.indexer = coasting(33, 3.0)
        self.kicker = coasting(34, 2.0)
        self.roller = coasting(35, 3.0)
        self.request = requests.FieldCentric().with_drive_request_type(SwerveModule.DriveRequestType.VELOCITY)
        self.speeds = requests.ApplyFieldSpeeds()
        self.field = wpilib.Field2d()
        wpilib.SmartDashboard.putData("Field", self.field)

    def telemeterize(self, state) -> None:
        SignalLogger.write_struct("DriveState/Pose", Pose2d, state.pose)
        SignalLogger.write_struct("DriveState/Speeds", ChassisSpeeds, state.speeds)
        SignalLogger.write_double_array("DriveState/Angles", [m.angle.radians() for m in state.module_states])
        SignalLogger.write_string("DriveState/Mode", "enabled" if wpilib.DriverStation.isEnabled() else "disabled")

    def robotPeriodic(self) -> None:
        self.field.setRobotPose(self.drivetrain.get_state().pose)
        wpilib.SmartDashboard.putNumber("Wheels", self.wheels.get_velocity().value)

    def is_red(self) -> bool:
        return wpilib.DriverStation.getAlliance() == wpilib.DriverStation.Alliance.kRed

    def place(self, pose: Pose2d) -> Pose2d:
        return measures.for_red(pose) if self.is_red() else pose

    # --- autonomous: the depot, then the hub

    def autonomousInit(self) -> None:
        self.drivetrain.reset_pose(self.place(START))
        self.steps = [self.place(pose) for pose in SWEEP]
        self.timer = wpilib.Timer()
        self.timer.start()

    def autonomousPeriodic(self) -> None:
        pose = self.drivetrain.get_state().pose
        if self.steps:
            self.take_in(8.0)
            self.drivetrain.set_control(self.speeds.with_speeds(measures.toward(pose, self.steps[0], 1.6)))
            if measures.is_there(pose, self.steps[0]) or self.timer.hasElapsed(1.8):
                self.steps.pop(0)
                self.timer.restart()
            return
        self.take_in(0.0)
        self.aim_and_shoot(pose)

    def aim_and_shoot(self, pose: Pose2d) -> None:
        way = measures.hub_of(self.is_red()) - pose.translation()
        goal = Pose2d(self.place(Pose2d(2.3, 5.4, 0.0)).translation(), way.angle())
        self.drivetrain.set_control(self.speeds.with_speeds(measures.toward(pose, goal)))
        rps = measures.shot_speed(way.norm() - 0.1, HEIGHT, ELEVATION) / METERS_PER_TURN
        self.wheels.set_control(controls.VelocityVoltage(rps))
        is_ready = measures.is_there(pose, goal) and abs(self.wheels.get_velocity().value / rps - 1.0) < 0.03
        self.feed(7.0 if is_ready else 0.0)

    # --- teleop

    def teleopPeriodic(self) -> None:
        pad = self.pad
        self.drivetrain.set_control(
            self.request.with_velocity_x(-3.5 * applyDeadband(pad.getLeftY(), 0.05))
            .with_velocity_y(-3.5 * pad.getLeftX())
            .with_rotational_rate(-4.0 * pad.getRightX())
        )
        if pad.getLeftBumperPressed():
            self.drivetrain.seed_field_centric(Rotation2d())
        self.take_in(8.0 if pad.getAButton() else 0.0)
        if pad.getXButton():
            self.wheels.set_control(controls.VelocityVoltage(45.0))
        else:
            self.wheels.set_control(controls.CoastOut())
        self.feed(7.0 if pad.getXButton() and self.wheels.get_velocity().value > 43.0 else 0.0)

    def take_in(self, volts: float) -> None:
        self.roller.set_control(controls.VoltageOut(volts) if volts else controls.NeutralOut())

    def feed(self, volts: float) -> None:
        for motor in (self.indexer, self.kicker):
            motor.set_control(controls.VoltageOut(volts) if volts else controls.NeutralOut())

    def facts(self) -> dict:
        motors = {"wheels": self.wheels, "feeder": self.kicker, "roller": self.roller}
        return {name: motor.get_velocity().value for name, motor in motors.items()}
