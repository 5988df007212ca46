import rev
from commands2 import Command, Subsystem

SAVE = rev.ResetMode.kResetSafeParameters, rev.PersistMode.kPersistParameters
BRUSHLESS, ControlType = rev.SparkLowLevel.MotorType.kBrushless, rev.SparkLowLevel.ControlType
RPM, TOLERANCE = 2700.0, 120.0


class Intake(Subsystem):
    def __init__(self) -> None:
        super().__init__()
        self.roller = rev.SparkMax(40, BRUSHLESS)

    def turn(self, share: float) -> None:
        self.roller.set(share)


class Feeder(Subsystem):
    def __init__(self) -> None:
        super().__init__()
        self.feeder = rev.SparkMax(41, BRUSHLESS)

    def feed(self) -> Command:
        return self.runEnd(lambda: self.feeder.set(0.6), lambda: self.feeder.set(0.0))


class Shooter(Subsystem):
    def __init__(self) -> None:
        super().__init__()
        self.wheels, self.follower = rev.SparkFlex(42, BRUSHLESS), rev.SparkFlex(43, BRUSHLESS)
        config = rev.SparkFlexConfig()
        config.closedLoop.pid(0.0004, 0, 0).feedForward.kV(12.0 / 6784.0).kS(0.15)
        self.wheels.configure(config, *SAVE)
        self.follower.configure(rev.SparkFlexConfig().follow(42, True), *SAVE)
        self.control = self.wheels.getClosedLoopController()

    def spin(self) -> Command:
        return self.runEnd(lambda: self.control.setReference(RPM, ControlType.kVelocity), self.stop)

    def stop(self) -> None:
        self.wheels.set(0.0)

    def is_ready(self) -> bool:
        return abs(self.wheels.getEncoder().getVelocity() - RPM) < TOLERANCE
