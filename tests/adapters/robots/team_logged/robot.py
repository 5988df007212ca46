"""A LoggedRobot as PyKit's: an IterativeRobotBase that waits for its own HAL notifier and logs before and after each
loop; hardware sits behind IO layers that fill inputs once a loop, and odometry is read by a thread at 200 Hz."""

from dataclasses import dataclass, field

import hal
import measures
import wpilib
from logged_robot import LoggedRobot, Logger
from phoenix6 import BaseStatusSignal, controls
from phoenix6.swerve import SwerveModule, requests
from wpimath.geometry import Pose2d


@dataclass
class DriveInputs:
    pose: Pose2d = field(default_factory=Pose2d)
    speeds: tuple[float, float, float] = (0.0, 0.0, 0.0)
    samples: int = 0


@dataclass
class ArmInputs:
    position: float = 0.0
    velocity: float = 0.0
    volts: float = 0.0
    amps: float = 0.0


class DriveIOPhoenix:
    def __init__(self) -> None:
        self.drivetrain = measures.build(bus="rio", inverted_steer=True, coupling=3.57)
        self.samples = 0
        self.thread = wpilib.Notifier(self.sample)
        self.thread.setName("odometry")
        self.thread.startPeriodic(0.005)

    def sample(self) -> None:
        self.drivetrain.update_sim_state(0.005, wpilib.RobotController.getBatteryVoltage())
        self.samples += 1

    def update(self, inputs: DriveInputs) -> None:
        state = self.drivetrain.get_state()
        inputs.pose = state.pose
        inputs.speeds = (state.speeds.vx, state.speeds.vy, state.speeds.omega)
        inputs.samples, self.samples = self.samples, 0


class ArmIOPhoenix:
    def __init__(self) -> None:
        self.motor = measures.talon(31, ratio=45.0, k_p=80.0, k_d=1.0)
        self.signals = (
            self.motor.get_position(),
            self.motor.get_velocity(),
            self.motor.get_motor_voltage(),
            self.motor.get_stator_current(),
        )
        BaseStatusSignal.set_update_frequency_for_all(50.0, *self.signals)
        self.motor.optimize_bus_utilization()

    def update(self, inputs: ArmInputs) -> None:
        BaseStatusSignal.refresh_all(*self.signals)
        inputs.position, inputs.velocity, inputs.volts, inputs.amps = (s.value for s in self.signals)


class MyRobot(LoggedRobot):
    def robotInit(self) -> None:
        self.drive, self.arm = DriveIOPhoenix(), ArmIOPhoenix()
        self.drive_inputs, self.arm_inputs = DriveInputs(), ArmInputs()
        self.pad = wpilib.XboxController(0)
        self.request = requests.FieldCentric().with_drive_request_type(SwerveModule.DriveRequestType.VELOCITY)
        hal.report(hal.tResourceType.kResourceType_Framework.value, hal.tInstances.kFramework_AdvantageKit.value)

    def robotPeriodic(self) -> None:
        self.drive.update(self.drive_inputs)
        self.arm.update(self.arm_inputs)
        Logger.process("Drive", self.drive_inputs)
        Logger.process("Arm", self.arm_inputs)

    def autonomousInit(self) -> None:
        self.drive.drivetrain.reset_pose(Pose2d(3.0, 4.0, 0.0))
        self.loops = 0

    def autonomousPeriodic(self) -> None:
        self.loops += 1
        vx = -0.8 if self.loops < 75 else 0.0
        self.drive.drivetrain.set_control(self.request.with_velocity_x(vx).with_velocity_y(0).with_rotational_rate(0))

    def teleopPeriodic(self) -> None:
        self.drive.drivetrain.set_control(
            self.request.with_velocity_x(-3.5 * self.pad.getLeftY())
            .with_velocity_y(-3.5 * self.pad.getLeftX())
            .with_rotational_rate(-3.5 * self.pad.getRightX())
        )
        self.arm.motor.set_control(controls.PositionVoltage(0.25 if self.pad.getYButton() else 0.0))

    def facts(self) -> dict:
        return {"arm": self.arm_inputs.position, "samples": self.drive_inputs.samples}
