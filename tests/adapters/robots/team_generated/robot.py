"""Project as CTRE's generator writes it: TimedCommandRobot, RobotContainer, generated constants, telemetry.py."""

import commands2
from robotcontainer import RobotContainer


class MyRobot(commands2.TimedCommandRobot):
    auto: commands2.Command | None = None

    def robotInit(self) -> None:
        self.container = RobotContainer()

    def autonomousInit(self) -> None:
        self.auto = self.container.get_autonomous_command()
        if self.auto:
            commands2.CommandScheduler.getInstance().schedule(self.auto)

    def teleopInit(self) -> None:
        if self.auto:
            self.auto.cancel()

    def testInit(self) -> None:
        commands2.CommandScheduler.getInstance().cancelAll()
