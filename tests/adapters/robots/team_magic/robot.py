"""A MagicBot with injected components: the drivetrain is a component of a class of its own, two shooters of different
wheels, tunables, feedbacks, a state machine, autonomous modes, and two Limelights whose MegaTag2 corrects the pose."""

import magicbot
import wpilib
from components.limelights import Limelights
from components.shooters import Feeder, Shooter, ShotControl
from components.swerve import Drivetrain


class Robot(magicbot.MagicRobot):
    shots: ShotControl
    drivetrain: Drivetrain
    cameras: Limelights
    left: Shooter
    right: Shooter
    feeder: Feeder

    max_speed = magicbot.tunable(4.0)

    def createObjects(self) -> None:
        self.pad = wpilib.XboxController(0)
        self.left_id, self.left_kv = 31, 0.125
        self.right_id, self.right_kv = 32, 0.123
        self.field = wpilib.Field2d()
        wpilib.SmartDashboard.putData("Robot on field", self.field)

    def teleopPeriodic(self) -> None:
        with self.consumeExceptions():
            self.drivetrain.go(
                -self.max_speed * self.pad.getLeftY(),
                -self.max_speed * self.pad.getLeftX(),
                -4.0 * self.pad.getRightX(),
            )
            if self.pad.getXButton():
                self.shots.engage()

    def robotPeriodic(self) -> None:
        super().robotPeriodic()
        self.field.setRobotPose(self.drivetrain.pose())

    @magicbot.feedback
    def battery(self) -> float:
        return wpilib.RobotController.getBatteryVoltage()

    def facts(self) -> dict:
        return {
            "wheels": self.left.speed(),
            "feeder": self.feeder.motors[0].get_velocity().value,
            "seen": self.cameras.seen,
        }
