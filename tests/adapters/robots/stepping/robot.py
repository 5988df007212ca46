"""A TimedRobot that derives its drivetrain and steps CTRE's own simulation from the robot loop."""

import measures
import wpilib
from phoenix6 import swerve


class Drive(swerve.SwerveDrivetrain):
    pass


class Robot(wpilib.TimedRobot):
    own_hook = 0

    def robotInit(self) -> None:
        self.swerve = measures.build(Drive, inverted_steer=False, coupling=3.57)

    def teleopPeriodic(self) -> None:
        self.swerve.set_control(measures.driver_request())

    def _simulationPeriodic(self) -> None:
        Robot.own_hook += 1
        self.swerve.update_sim_state(0.02, 12.0)

    def facts(self) -> dict:
        return {"own_hook": Robot.own_hook}
