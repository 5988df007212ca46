"""A command-based robot with fourteen devices besides its drivetrain, a class with trailing None: a turret with a hood
and an upper and a lower wheel, a second shooter that throws to the back, feeders of several motors, MegaTag2."""

import commands2
import measures
import ntcore
import wpilib
from commands2 import Subsystem, cmd
from commands2.button import CommandXboxController, Trigger
from mechanisms import BackShooter, Intake, Turret
from phoenix6 import swerve, utils
from phoenix6.swerve import SwerveModule, requests
from wpimath.geometry import Pose2d, Rotation2d

START = Pose2d(2.6, 5.6, 3.14159)
WAY = ((1.3, 5.62), (0.62, 5.62), (0.62, 6.3), (0.9, 5.96), (0.55, 5.96), (0.55, 5.6), (0.55, 6.3), (2.0, 5.6))


class Drive(Subsystem, swerve.SwerveDrivetrain):
    def __init__(self, a, b, c, constants, arg0=None, arg1=None, arg2=None, arg3=None) -> None:
        Subsystem.__init__(self)
        swerve.SwerveDrivetrain.__init__(self, a, b, c, constants, arg0, arg1, arg2, arg3)
        self.speeds = requests.ApplyFieldSpeeds().with_drive_request_type(SwerveModule.DriveRequestType.VELOCITY)
        inst = ntcore.NetworkTableInstance.getDefault()
        self.orientation = inst.getDoubleArrayTopic("/limelight-rear/robot_orientation_set").publish()
        self.megatag = inst.getDoubleArrayTopic("/limelight-rear/botpose_orb_wpiblue").subscribe([])

    def periodic(self) -> None:
        state = self.get_state()
        self.orientation.set([state.pose.rotation().degrees(), 0, 0, 0, 0, 0])
        for sample in self.megatag.readQueue():
            values = sample.value
            if len(values) >= 11 and values[7] >= 1 and abs(state.speeds.omega) < 2.0:
                pose = Pose2d(values[0], values[1], Rotation2d.fromDegrees(values[5]))
                time = utils.fpga_to_current_time(sample.time / 1e6 - values[6] / 1e3)
                self.add_vision_measurement(pose, time, (0.5, 0.5, 9999999.0))

    def to(self, pose: Pose2d) -> commands2.Command:
        def goal() -> Pose2d:
            return measures.for_red(pose) if is_red() else pose

        def run() -> None:
            self.set_control(self.speeds.with_speeds(measures.toward(self.get_state().pose, goal(), 1.6)))

        return self.run(run).until(lambda: measures.is_there(self.get_state().pose, goal())).withTimeout(1.8)


def is_red() -> bool:
    return wpilib.DriverStation.getAlliance() == wpilib.DriverStation.Alliance.kRed


class RobotContainer:
    def __init__(self) -> None:
        self.pad = pad = CommandXboxController(0)
        self.drive = measures.build(Drive, inverted_steer=False)
        self.intake, self.back = Intake(), BackShooter()
        self.turret = Turret(lambda: self.drive.get_state().pose, lambda: measures.hub_of(is_red()))
        request = requests.FieldCentric().with_deadband(0.15)
        self.drive.setDefaultCommand(
            self.drive.run(
                lambda: self.drive.set_control(
                    request.with_velocity_x(-3.5 * pad.getLeftY())
                    .with_velocity_y(-3.5 * pad.getLeftX())
                    .with_rotational_rate(-3.5 * pad.getRightX())
                )
            )
        )
        self.turret.setDefaultCommand(self.turret.rest())
        pad.a().toggleOnTrue(self.intake.take_in())
        pad.x().whileTrue(self.turret.shoot())
        pad.b().whileTrue(self.back.shoot())
        Trigger(lambda: pad.getRightTriggerAxis() > 0.5).whileTrue(self.turret.shoot())
        self.chooser = wpilib.SendableChooser()
        self.chooser.setDefaultOption("depot", "depot")
        self.chooser.addOption("nothing", "nothing")
        wpilib.SmartDashboard.putData("Auto", self.chooser)

    def auto(self) -> commands2.Command:
        if self.chooser.getSelected() != "depot":
            return cmd.none()
        reset = cmd.runOnce(lambda: self.drive.reset_pose(measures.for_red(START) if is_red() else START))
        way = [self.drive.to(Pose2d(x, y, 3.14159)) for x, y in WAY]
        return cmd.sequence(
            reset,
            cmd.sequence(*way).deadlineFor(self.intake.take_in()),
            self.drive.runOnce(lambda: self.drive.set_control(requests.SwerveDriveBrake())),
            self.turret.shoot().withTimeout(6.0),
        )


class Robot(commands2.TimedCommandRobot):
    def robotInit(self) -> None:
        self.container = RobotContainer()
        self.auto = cmd.none()

    def autonomousInit(self) -> None:
        self.auto = self.container.auto()
        self.auto.schedule()

    def teleopInit(self) -> None:
        self.auto.cancel()

    def facts(self) -> dict:
        turret = self.container.turret
        motors = {"lower": turret.lower, "upper": turret.upper, "feeder": turret.kicker}
        speeds = {name: motor.get_velocity().value for name, motor in motors.items()}
        return {**speeds, "aim": turret.turret.get_closed_loop_error().value}
