"""The robot program. Run it with `robotpy sim`; see README.md."""

import commands2
import wpilib
from robotcontainer import RobotContainer


class Robot(commands2.TimedCommandRobot):
    """Runs the command scheduler; everything else is in the container."""

    def robotInit(self) -> None:
        wpilib.DriverStation.silenceJoystickConnectionWarning(self.isSimulation())
        self.container = RobotContainer()
        self.auto: commands2.Command | None = None

    def disabledPeriodic(self) -> None:
        # Until the first enable the robot stands where the drive team put it.
        self.container.seed_pose(wpilib.DriverStation.getAlliance())

    def autonomousInit(self) -> None:
        self.container.seed_pose(wpilib.DriverStation.getAlliance())
        self.container.is_seeded = True
        self.auto = self.container.autonomous_command()
        if self.auto is not None:
            self.auto.schedule()

    def teleopInit(self) -> None:
        self.container.seed_pose(wpilib.DriverStation.getAlliance())
        self.container.is_seeded = True
        if self.auto is not None:
            self.auto.cancel()

    def robotPeriodic(self) -> None:
        self.container.publish()

    def autonomousPeriodic(self) -> None:
        """Commands do it."""

    def teleopPeriodic(self) -> None:
        """Commands do it."""

    def testPeriodic(self) -> None:
        """Nothing yet."""
