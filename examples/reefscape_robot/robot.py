"""The robot program. Run it with `robotpy sim --simcore`; see README.md."""

import commands2
import wpilib
from robotcontainer import RobotContainer


class Robot(commands2.TimedCommandRobot):
    """Runs the command scheduler; everything else is in the container."""

    def robotInit(self) -> None:
        wpilib.DriverStation.silenceJoystickConnectionWarning(self.isSimulation())
        self.container = RobotContainer()
        self.auto: commands2.Command | None = None
        self.seeded_for: wpilib.DriverStation.Alliance | None = None

    def autonomousInit(self) -> None:
        self.container.seed_pose()
        self.auto = self.container.autonomous_command()
        if self.auto is not None:
            self.auto.schedule()

    def disabledPeriodic(self) -> None:
        alliance = wpilib.DriverStation.getAlliance()  # known once the driver station is there
        if alliance != self.seeded_for:
            self.seeded_for = alliance
            self.container.seed_pose()

    def teleopInit(self) -> None:
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
