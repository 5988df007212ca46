"""RobotPy version of swerve.cpp."""

import math

import wpilib


class Module:
    def __init__(self, k):
        self.drive, self.steer = wpilib.PWMSparkMax(2 * k), wpilib.PWMSparkMax(2 * k + 1)
        self.wheel, self.azimuth = wpilib.Encoder(2 * k, 2 * k + 1), wpilib.AnalogEncoder(k)
        self.wheel.setDistancePerPulse(0.319186 / 2048.0)

    def go(self, speed, angle):
        error = math.remainder(angle / (2.0 * math.pi) - self.azimuth.get(), 1.0)
        self.steer.set(max(-1.0, min(1.0, 4.0 * error)))
        self.drive.set(speed / 4.5 + 0.2 * (speed - self.wheel.getRate()))


class Robot(wpilib.TimedRobot):
    def __init__(self):
        super().__init__()
        self.modules = [Module(k) for k in range(4)]
        self.loops = 0

    def autonomousPeriodic(self):
        time = 0.02 * self.loops
        self.loops += 1
        angle = 0.6 * math.sin(0.8 * time)
        for module in self.modules:
            module.go(1.5, angle)

    def disabledPeriodic(self):
        for module in self.modules:
            module.drive.set(0.0)
            module.steer.set(0.0)


if __name__ == "__main__":
    Robot().startCompetition()
