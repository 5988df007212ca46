"""RobotPy version of arm.cpp."""

import wpilib


class Robot(wpilib.TimedRobot):
    def __init__(self):
        super().__init__()
        self.motor, self.pot = wpilib.PWMSparkMax(2), wpilib.AnalogPotentiometer(1, 5.0, 0.0)
        self.loops = 0

    def autonomousPeriodic(self):
        goal = 3.0 if self.loops % 200 < 100 else 1.5
        self.loops += 1
        self.motor.set(0.4 * (goal - self.pot.get()))

    def disabledPeriodic(self):
        self.motor.set(0.0)


if __name__ == "__main__":
    Robot().startCompetition()
