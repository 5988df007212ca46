import commands2
from commands2.button import CommandXboxController, Trigger
from commands2.sysid import SysIdRoutine
from pathplannerlib.auto import AutoBuilder
from phoenix6 import swerve
from telemetry import Telemetry
from wpilib import DriverStation, SmartDashboard
from wpimath.geometry import Rotation2d


class RobotContainer:
    def __init__(self) -> None:
        from generated.tuner_constants import TunerConstants  # late import: it builds a CANBus with a hoot path

        self.max_speed = TunerConstants.speed_at_12_volts
        self.max_turn = 4.7
        self.joystick = CommandXboxController(0)
        self.logger = Telemetry(self.max_speed)
        self.drivetrain = TunerConstants.create_drivetrain()
        self.drive = (
            swerve.requests.FieldCentric()
            .with_deadband(self.max_speed * 0.1)
            .with_rotational_deadband(self.max_turn * 0.1)
            .with_drive_request_type(swerve.SwerveModule.DriveRequestType.OPEN_LOOP_VOLTAGE)
        )
        self.brake = swerve.requests.SwerveDriveBrake()
        self.point = swerve.requests.PointWheelsAt()
        self.straight = swerve.requests.RobotCentric().with_drive_request_type(
            swerve.SwerveModule.DriveRequestType.OPEN_LOOP_VOLTAGE
        )
        self.configure_bindings()
        self.autos = AutoBuilder.buildAutoChooser("Ahead")
        SmartDashboard.putData("Auto Mode", self.autos)

    def configure_bindings(self) -> None:
        pad, drivetrain = self.joystick, self.drivetrain
        drivetrain.setDefaultCommand(
            drivetrain.apply_request(
                lambda: (
                    self.drive.with_velocity_x(-pad.getLeftY() * self.max_speed)
                    .with_velocity_y(-pad.getLeftX() * self.max_speed)
                    .with_rotational_rate(-pad.getRightX() * self.max_turn)
                )
            )
        )
        Trigger(DriverStation.isDisabled).whileTrue(
            drivetrain.apply_request(lambda: swerve.requests.Idle()).ignoringDisable(True)
        )
        pad.a().whileTrue(drivetrain.apply_request(lambda: self.brake))
        pad.b().whileTrue(
            drivetrain.apply_request(
                lambda: self.point.with_module_direction(Rotation2d(-pad.getLeftY(), -pad.getLeftX()))
            )
        )
        pad.povUp().whileTrue(drivetrain.apply_request(lambda: self.straight.with_velocity_x(0.5).with_velocity_y(0)))
        for held, routine in ((pad.back(), drivetrain.sys_id_dynamic), (pad.start(), drivetrain.sys_id_quasistatic)):
            (held & pad.y()).whileTrue(routine(SysIdRoutine.Direction.kForward))
            (held & pad.x()).whileTrue(routine(SysIdRoutine.Direction.kReverse))
        pad.leftBumper().onTrue(drivetrain.runOnce(drivetrain.seed_field_centric))
        drivetrain.register_telemetry(self.logger.telemeterize)

    def get_autonomous_command(self) -> commands2.Command:
        return self.autos.getSelected()
