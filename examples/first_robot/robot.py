import wpilib
from phoenix6 import configs, hardware, swerve
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
    constants = swerve.SwerveDrivetrainConstants().with_can_bus_name("").with_pigeon2_id(40)
    return swerve.SwerveDrivetrain(hardware.TalonFX, hardware.TalonFX, hardware.CANcoder, constants, modules)


class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.drivetrain = build_drivetrain()
        self.pad = wpilib.XboxController(0)
        self.drive = requests.FieldCentric().with_deadband(0.1).with_rotational_deadband(0.1)

    def teleopPeriodic(self):
        self.drivetrain.set_control(
            self.drive.with_velocity_x(-self.pad.getLeftY() * MAX_SPEED)
            .with_velocity_y(-self.pad.getLeftX() * MAX_SPEED)
            .with_rotational_rate(-self.pad.getRightX() * MAX_TURN)
        )

    def disabledPeriodic(self):
        pass

    def robotPeriodic(self):
        pose = self.drivetrain.get_state().pose
        wpilib.SmartDashboard.putNumberArray("Odometry", [pose.X(), pose.Y(), pose.rotation().degrees()])
