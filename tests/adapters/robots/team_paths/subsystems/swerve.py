from commands2 import Subsystem
from pathplannerlib.auto import AutoBuilder
from pathplannerlib.config import PIDConstants, RobotConfig
from pathplannerlib.controller import PPHolonomicDriveController
from phoenix6 import CANBus, configs, hardware, swerve, utils
from phoenix6.swerve import SwerveModule, requests
from wpilib import DriverStation, Notifier, RobotController

CANIVORE = CANBus("canivore", "./logs/paths.hoot")
HALF = 0.2731


def modules() -> list[swerve.SwerveModuleConstants]:
    factory = (
        swerve.SwerveModuleConstantsFactory()
        .with_drive_motor_gear_ratio(6.12)
        .with_steer_motor_gear_ratio(21.4286)
        .with_coupling_gear_ratio(3.5714)
        .with_wheel_radius(0.0508)
        .with_steer_motor_gains(configs.Slot0Configs().with_k_p(100).with_k_d(0.5).with_k_s(0.1).with_k_v(2.66))
        .with_drive_motor_gains(configs.Slot0Configs().with_k_p(0.1).with_k_v(0.124))
        .with_slip_current(100.0)
        .with_speed_at12_volts(4.9)
        .with_feedback_source(swerve.SteerFeedbackType.FUSED_CANCODER)
        .with_drive_motor_initial_configs(configs.TalonFXConfiguration())
        .with_steer_motor_initial_configs(configs.TalonFXConfiguration())
        .with_encoder_initial_configs(configs.CANcoderConfiguration())
    )
    corners = ((1, 1, 0.31), (1, -1, -0.22), (-1, 1, 0.08), (-1, -1, -0.47))
    return [
        factory.create_module_constants(2 * k + 2, 2 * k + 1, k + 1, offset, x * HALF, y * HALF, y < 0, True, False)
        for k, (x, y, offset) in enumerate(corners)
    ]


class Swerve(swerve.SwerveDrivetrain, Subsystem):
    def __init__(self) -> None:
        Subsystem.__init__(self)
        constants = swerve.SwerveDrivetrainConstants().with_can_bus_name(CANIVORE.name).with_pigeon2_id(0)
        super().__init__(hardware.TalonFX, hardware.TalonFX, hardware.CANcoder, constants, 250.0, modules(), None, None)
        request = requests.ApplyRobotSpeeds().with_drive_request_type(SwerveModule.DriveRequestType.VELOCITY)
        AutoBuilder.configure(
            lambda: self.get_state().pose,
            self.reset_pose,
            lambda: self.get_state().speeds,
            lambda speeds, forces: self.set_control(
                request.with_speeds(speeds)
                .with_wheel_force_feedforwards_x(forces.robotRelativeForcesXNewtons)
                .with_wheel_force_feedforwards_y(forces.robotRelativeForcesYNewtons)
            ),
            PPHolonomicDriveController(PIDConstants(6.0), PIDConstants(6.0)),
            RobotConfig.fromGUISettings(),
            lambda: DriverStation.getAlliance() == DriverStation.Alliance.kRed,
            self,
        )
        if utils.is_simulation():
            self.last = utils.get_current_time_seconds()
            self.notifier = Notifier(self.step)
            self.notifier.startPeriodic(0.005)

    def step(self) -> None:
        now = utils.get_current_time_seconds()
        self.update_sim_state(now - self.last, RobotController.getBatteryVoltage())
        self.last = now
