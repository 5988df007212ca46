"""RobotPy version of elevator.cpp."""

import wpilib


class Robot(wpilib.TimedRobot):
    def __init__(self):
        super().__init__()
        self.motor, self.encoder = wpilib.PWMSparkMax(3), wpilib.Encoder(6, 7)
        self.low, self.high = wpilib.DigitalInput(4), wpilib.DigitalInput(5)
        self.encoder.setDistancePerPulse(1.0 / 2048.0)
        self.state = "down"
        self.loops = 0  # at the lower switch, to home

    def autonomousPeriodic(self):
        if self.state == "down" and not self.low.get():
            self.loops += 1
            if self.loops > 26:
                self.encoder.reset()
                self.state = "up"
        if self.state == "up" and not self.high.get():
            self.state = "hold"
        goal = 0.1 + 0.5 * (4.0 - self.encoder.getDistance())
        self.motor.set({"down": -0.1, "up": 0.5}.get(self.state, max(-0.3, min(0.5, goal))))

    def disabledPeriodic(self):
        self.motor.set(0.0)


if __name__ == "__main__":
    Robot().startCompetition()
