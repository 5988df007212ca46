"""Swerve robot made of op modes, which came with WPILib 2027."""

import wpilib
from phoenix6 import CANBus, configs, hardware, swerve
from phoenix6.swerve import requests

# steer id, drive id, encoder id, encoder offset [turns], x, y [m], drive, steer, encoder inverted
MODULES = (
    (21, 11, 31, 0.120, 0.280, 0.240, False, True, False),
    (22, 12, 32, -0.415, 0.280, -0.240, True, True, False),
    (23, 13, 33, 0.333, -0.280, 0.240, False, True, False),
    (24, 14, 34, 0.050, -0.280, -0.240, True, True, False),
)
MAX_SPEED = 4.4  # m/s
MAX_TURN = 6.0  # rad/s


def build_drivetrain():
    factory = (
        swerve.SwerveModuleConstantsFactory()
        .with_drive_motor_gear_ratio(6.12)
        .with_steer_motor_gear_ratio(18.75)
        .with_coupling_gear_ratio(3.375)
        .with_wheel_radius(0.0495)
        .with_drive_motor_gains(configs.Slot0Configs().with_k_p(0.1).with_k_v(0.124))
        .with_steer_motor_gains(configs.Slot0Configs().with_k_p(80).with_k_d(0.4).with_k_v(2.3))
        .with_slip_current(80)
        .with_speed_at12_volts(4.9)
        .with_feedback_source(swerve.SteerFeedbackType.FUSED_CANCODER)
        .with_drive_motor_initial_configs(configs.TalonFXConfiguration())
        .with_steer_motor_initial_configs(configs.TalonFXConfiguration())
        .with_encoder_initial_configs(configs.CANcoderConfiguration())
    )
    modules = [factory.create_module_constants(*row) for row in MODULES]
    constants = swerve.SwerveDrivetrainConstants().with_network(CANBus("")).with_pigeon2_id(40)
    return swerve.SwerveDrivetrain(hardware.TalonFX, hardware.TalonFX, hardware.CANcoder, constants, modules)


@wpilib.teleop(name="Drive")
class Drive(wpilib.PeriodicOpMode):
    def __init__(self, robot):
        super().__init__()
        self.robot = robot
        self.pad = wpilib.NiDsXboxController(0)
        self.drive = requests.FieldCentric().with_deadband(0.1).with_rotational_deadband(0.1)

    def periodic(self):
        self.robot.drivetrain.set_control(
            self.drive.with_velocity_x(-self.pad.get_left_y() * MAX_SPEED).with_velocity_y(
                -self.pad.get_left_x() * MAX_SPEED
            )
        )


@wpilib.autonomous(name="Ahead")
class Ahead(wpilib.PeriodicOpMode):
    def __init__(self, robot):
        super().__init__()
        self.robot = robot
        self.drive = requests.RobotCentric()

    def periodic(self):
        self.robot.drivetrain.set_control(self.drive.with_velocity_x(0.5))

    def end(self):
        self.robot.drivetrain.set_control(requests.Idle())


@wpilib.utility(name="Spin")
class Spin(wpilib.PeriodicOpMode):
    def __init__(self, robot):
        super().__init__()
        self.robot = robot

    def periodic(self):
        self.robot.drivetrain.set_control(requests.RobotCentric().with_rotational_rate(1.0))


class Robot(wpilib.OpModeRobot):
    def __init__(self):
        super().__init__()
        self.drivetrain = build_drivetrain()
