"""Robot program that uses every kind of port and prints its readings in loop 100."""

import json

import hal
import wpilib


class Robot(wpilib.TimedRobot):
    def __init__(self):
        super().__init__()
        self.motors = wpilib.PWMSparkMax(0), wpilib.PWMSparkMax(1)
        self.servo, self.relay = wpilib.Servo(3), wpilib.Relay(0)
        self.valve = wpilib.DoubleSolenoid(wpilib.PneumaticsModuleType.REVPH, 0, 1)
        self.hood = wpilib.PWMSparkMax(2)
        self.absolute, self.pulse = wpilib.DutyCycleEncoder(8), wpilib.DutyCycle(wpilib.DigitalInput(9))
        self.analog, self.pot = wpilib.AnalogEncoder(2), wpilib.AnalogInput(3)
        self.switch, self.lamp = wpilib.DigitalInput(4), wpilib.DigitalOutput(5)
        self.adis, self.gyro = wpilib.ADIS16448_IMU(), wpilib.AnalogGyro(0)
        self.pad = wpilib.XboxController(0)
        self.loops = 0

    def teleopPeriodic(self):
        self.loops += 1
        turn = self.pad.getLeftX()
        for motor, sign in zip(self.motors, (1.0, -1.0), strict=True):
            motor.set(0.3 * sign * turn)
        self.servo.set(0.75)
        self.relay.set(wpilib.Relay.Value.kForward)
        self.valve.set(wpilib.DoubleSolenoid.Value.kForward)
        self.hood.set(0.2 if self.pad.getAButton() else 0.0)
        self.lamp.set(True)
        if self.loops == 50:
            self.gyro.reset()
            hal.sendError(True, 1, False, "fifty loops", "robot", "", True)
        if self.loops == 100:
            reads = {
                "absolute": self.absolute.get(), "pulse": self.pulse.getOutput(), "analog": self.analog.get(),
                "volts": self.pot.getVoltage(), "switch": self.switch.get(), "adis": self.adis.getAngle(),
                "gyro": self.gyro.getAngle(), "data": wpilib.DriverStation.getGameSpecificMessage(),
                "alliance": str(wpilib.DriverStation.getAlliance()),
                "battery": wpilib.RobotController.getBatteryVoltage(),
            }  # fmt: skip
            print("READS", json.dumps(reads), flush=True)


if __name__ == "__main__":
    Robot().startCompetition()
