"""RobotPy version of examples/cpp_tank."""

import wpilib
from wpimath.controller import PIDController


class Robot(wpilib.TimedRobot):
    def __init__(self):
        super().__init__()
        self.motors = wpilib.PWMSparkMax(0), wpilib.PWMSparkMax(1)
        self.encoders = wpilib.Encoder(0, 1), wpilib.Encoder(2, 3)
        for encoder in self.encoders:
            encoder.setDistancePerPulse(0.000234)
        self.loops = PIDController(0.5, 0.0, 0.0), PIDController(0.5, 0.0, 0.0)

    def autonomousPeriodic(self):
        for motor, encoder, loop, goal in zip(self.motors, self.encoders, self.loops, (1.0, 0.95), strict=True):
            motor.set(0.25 + loop.calculate(encoder.getRate(), goal))

    def disabledPeriodic(self):
        for motor in self.motors:
            motor.set(0.0)


if __name__ == "__main__":
    Robot().startCompetition()
