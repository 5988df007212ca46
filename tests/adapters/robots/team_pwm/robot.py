"""A TimedRobot with PWM and DIO beside CTRE's drivetrain: PWM motors, a quadrature and a duty-cycle encoder, a
potentiometer, a beam break that stops the feeder, a servo, a solenoid, and devices built on "" and "rio" both."""

import measures
import wpilib
from phoenix6 import hardware
from phoenix6.swerve import SwerveModule, requests
from wpimath.controller import PIDController


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.drivetrain = measures.build(bus="rio", inverted_steer=True)
        self.same = [hardware.TalonFX(k, "") for k in (1, 2, 3, 4)] + [hardware.Pigeon2(9, "")]
        self.pad = wpilib.XboxController(0)
        self.roller = wpilib.PWMSparkMax(0)
        self.feeder = wpilib.MotorControllerGroup(wpilib.PWMVictorSPX(1), wpilib.PWMVictorSPX(2))
        self.wheel = wpilib.PWMTalonFX(3)
        self.wheel.setInverted(True)
        self.arm = wpilib.PWMSparkMax(4)
        self.encoder = wpilib.Encoder(0, 1)
        self.encoder.setDistancePerPulse(1.0 / 2048.0)
        self.arm_angle = wpilib.DutyCycleEncoder(2)
        self.beam = wpilib.DigitalInput(3)
        self.potentiometer = wpilib.AnalogPotentiometer(0, 270.0, -30.0)
        self.hood = wpilib.Servo(5)
        self.clamp = wpilib.DoubleSolenoid(wpilib.PneumaticsModuleType.REVPH, 0, 1)
        self.compressor = wpilib.Compressor(wpilib.PneumaticsModuleType.REVPH)
        self.board = wpilib.PowerDistribution(1, wpilib.PowerDistribution.ModuleType.kRev)
        self.leds = wpilib.AddressableLED(9)
        self.leds.setLength(10)
        self.leds.start()
        self.loop = PIDController(2.0, 0.0, 0.0)
        self.request = requests.RobotCentric().with_drive_request_type(SwerveModule.DriveRequestType.VELOCITY)

    def robotPeriodic(self) -> None:
        wpilib.SmartDashboard.putNumber("Board volts", self.board.getVoltage())
        wpilib.SmartDashboard.putNumber("Board amps", self.board.getTotalCurrent())
        wpilib.SmartDashboard.putNumber("Heading", self.same[-1].get_yaw().value)
        wpilib.SmartDashboard.putNumber("Potentiometer", self.potentiometer.get())
        wpilib.SmartDashboard.putNumber("Wheel", self.encoder.getRate())
        wpilib.SmartDashboard.putBoolean("Piece", not self.beam.get())
        if wpilib.DriverStation.isEnabled() and wpilib.RobotController.isBrownedOut():
            self.wheel.stopMotor()

    def autonomousInit(self) -> None:
        self.drivetrain.reset_rotation(measures.Rotation2d())
        self.clamp.set(wpilib.DoubleSolenoid.Value.kForward)

    def autonomousPeriodic(self) -> None:
        self.drivetrain.set_control(requests.SwerveDriveBrake())
        self.wheel.set(0.5)

    def teleopPeriodic(self) -> None:
        pad = self.pad
        self.drivetrain.set_control(
            self.request.with_velocity_x(-3.5 * pad.getLeftY())
            .with_velocity_y(-3.5 * pad.getLeftX())
            .with_rotational_rate(-3.5 * pad.getRightX())
        )
        self.roller.setVoltage(8.0 if pad.getAButton() else 0.0)
        self.wheel.set(0.6 if pad.getXButton() else 0.0)
        self.feeder.set(0.5 if pad.getXButton() and self.beam.get() else 0.0)
        self.arm.set(self.loop.calculate(self.arm_angle.get(), 0.3 if pad.getYButton() else 0.1))
        self.hood.setAngle(90.0 if pad.getYButton() else 0.0)
        if pad.getBButtonPressed():
            self.clamp.toggle()

    def disabledInit(self) -> None:
        for motor in (self.roller, self.feeder, self.wheel, self.arm):
            motor.stopMotor()

    def facts(self) -> dict:
        return {"wheel": self.encoder.getRate(), "arm": self.arm_angle.get(), "hood": self.hood.getAngle()}
