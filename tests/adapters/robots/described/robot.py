"""TimedRobot with a drivetrain member that no code steps, and mechanisms that simcore.toml describes."""

import measures
import ntcore
import wpilib
from phoenix6 import controls, hardware, signals


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.drivetrain = measures.build()
        self.drivetrain.reset_pose(measures.swerve.swerve_drivetrain.Pose2d(12.96, 4.01, 3.14159))
        self.wheels = measures.talon(31, ratio=0.8, k_v=0.1, k_p=0.4)
        self.follower = hardware.TalonFX(32)
        self.follower.set_control(controls.Follower(31, signals.MotorAlignmentValue.OPPOSED))
        self.feeder = measures.talon(33, ratio=2.0)
        self.roller = measures.talon(34, ratio=3.0)
        self.pivot = measures.talon(35, ratio=50.0, k_p=60.0, k_d=0.5)
        self.pivot.set_position(0.25)  # the pivot is upright at power-on

    def teleopPeriodic(self) -> None:
        self.drivetrain.set_control(measures.driver_request())
        self.pivot.set_control(controls.PositionVoltage(0.0))
        self.roller.set_control(controls.VoltageOut(8.0))
        buttons = wpilib.DriverStation
        if buttons.getStickButton(0, 1):
            self.wheels.set_control(controls.VelocityVoltage(55.0))
            is_fast = self.wheels.get_velocity().value > 53.0
            self.feeder.set_control(controls.VoltageOut(6.0 if is_fast else 0.0))

    def facts(self) -> dict:
        limelight = ntcore.NetworkTableInstance.getDefault().getTable("limelight-back")
        return {
            "heartbeat": limelight.getNumber("hb", 0.0),
            "tag": limelight.getNumber("tid", 0.0),
            "pivot": self.pivot.get_position().value,
            "wheels_rps": self.wheels.get_velocity().value,
            "roller_rps": self.roller.get_velocity().value,
        }
