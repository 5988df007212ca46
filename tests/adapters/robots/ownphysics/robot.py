"""A TimedRobot whose project has a physics.py of its own: it steps a drivetrain model and turns the gyro, as it did
before simcore, and it drives a mechanism that simcore must leave alone. Coupling 0, steers inverted."""

import measures
import wpilib
from phoenix6 import controls


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.drivetrain = measures.build()
        self.intake = measures.talon(40, ratio=4.0, k_v=0.5)
        self.other = measures.talon(41, ratio=4.0, k_v=0.5, k_p=0.1)

    def teleopPeriodic(self) -> None:
        self.drivetrain.set_control(measures.driver_request())
        self.intake.set_control(controls.VoltageOut(6.0))
        self.other.set_control(controls.VelocityVoltage(5.0))

    def facts(self) -> dict:
        return {"intake_rps": self.intake.get_velocity().value, "other_rps": self.other.get_velocity().value}
