"""Robot of PWM controllers, roboRIO sensors, pneumatics, a servo, a relay and lights, described by simcore.toml.

The hood homes on its lower switch and then follows its encoder; the code counts fuel by light barriers.
"""

import measures
import wpilib
from phoenix6 import controls, hardware
from phoenix6.signals import RGBWColor

A, X = 1, 3
OUT, IN = wpilib.DoubleSolenoid.Value.kForward, wpilib.DoubleSolenoid.Value.kReverse
HOOD_GOAL = 20.0  # [deg] above its lower stop
GREEN, RED = RGBWColor(0, 255, 0), RGBWColor(255, 0, 0)


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.drivetrain = measures.build()
        self.wheels = measures.talon(31, k_v=0.125, k_p=0.4)
        # intake with two motors face to face, deployed by a cylinder
        self.roller, self.second_roller = wpilib.Spark(0), wpilib.VictorSP(1)
        self.second_roller.setInverted(True)
        self.roller.addFollower(self.second_roller)
        self.deploy = wpilib.DoubleSolenoid(wpilib.PneumaticsModuleType.REVPH, 0, 1)
        self.flap = wpilib.PneumaticHub(1).makeSolenoid(2)
        # hood on a PWM controller that turns the wrong way unless inverted
        self.hood = wpilib.PWMSparkMax(2)
        self.hood.setInverted(True)
        self.hood_encoder = wpilib.Encoder(0, 1)
        self.hood_encoder.setDistancePerPulse(360.0 / 2048.0 / 4.0)  # degrees of the hood
        self.hood_absolute = wpilib.DutyCycleEncoder(3, 360.0, 0.0)
        self.hood_analog = wpilib.AnalogEncoder(0)
        self.hood_angle = wpilib.AnalogPotentiometer(1, 100.0, -10.0)
        self.hood_switch = wpilib.DigitalInput(2)
        self.is_homed = False
        self.latch = wpilib.Servo(3)
        self.kicker = wpilib.Relay(0)
        # fuel sensors
        self.any_fuel = wpilib.DigitalInput(4)
        self.three_fuel = wpilib.DigitalInput(5)
        self.two_fuel = hardware.CANrange(12)
        self.candi = hardware.CANdi(30)
        # lights
        self.candle = hardware.CANdle(40)
        self.strip = wpilib.AddressableLED(7)
        self.strip.setLength(4)
        self.strip.start()
        # devices that no file describes
        self.spare = (wpilib.VictorSP(5), wpilib.DigitalInput(9), wpilib.AnalogInput(3), wpilib.Relay(1))

    def robotPeriodic(self) -> None:
        has_fuel = not self.any_fuel.get()
        self.candle.set_control(controls.SolidColor(0, 7, GREEN if has_fuel else RED))
        self.candle.set_control(controls.RainbowAnimation(8, 37, slot=1))
        self.strip.setData([wpilib.AddressableLED.LEDData(0, 0, 200 if has_fuel else 20)] * 4)

    def teleopPeriodic(self) -> None:
        pad = wpilib.DriverStation
        self.drivetrain.set_control(measures.driver_request())
        takes = pad.getStickButton(0, A)
        self.deploy.set(OUT if takes else IN)
        self.flap.set(takes)
        self.roller.setVoltage(8.0 if takes else 0.0)
        self.move_hood()
        shoots = pad.getStickButton(0, X)
        self.latch.setAngle(135.0 if shoots else 45.0)
        self.wheels.set_control(controls.VelocityVoltage(30.0 if shoots else 0.0))
        is_fast = self.wheels.get_velocity().value > 28.0
        self.kicker.set(wpilib.Relay.Value.kForward if shoots and is_fast else wpilib.Relay.Value.kOff)

    def move_hood(self) -> None:
        if not self.is_homed:
            self.hood.set(-0.2)
            if not self.hood_switch.get():  # a switch to ground
                self.hood_encoder.reset()
                self.is_homed = True
            return
        self.hood.set(min(max(0.05 * (HOOD_GOAL - self.hood_encoder.getDistance()), -0.5), 0.5))

    def facts(self) -> dict:
        return {
            "hood": self.hood_encoder.getDistance(),
            "hood_rate": self.hood_encoder.getRate(),
            "absolute": self.hood_absolute.get(),
            "analog": self.hood_analog.get(),
            "pot": self.hood_angle.get(),
            "is_homed": self.is_homed,
            "beams": (not self.any_fuel.get(), self.three_fuel.get()),
            "range": self.two_fuel.get_distance().value,
            "is_near": bool(self.two_fuel.get_is_detected().value),
            "is_out": bool(self.candi.get_s1_closed().value),
            "passes": bool(self.candi.get_s2_closed().value),
        }
