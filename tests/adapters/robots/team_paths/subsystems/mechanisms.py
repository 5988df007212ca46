from commands2 import Command, Subsystem
from phoenix6 import configs, controls, hardware, signals


def motor(number: int, ratio: float, *, coast: bool = True, **gains: float) -> hardware.TalonFX:
    made = hardware.TalonFX(number)
    config = configs.TalonFXConfiguration()
    config.feedback.sensor_to_mechanism_ratio = ratio
    mode = signals.NeutralModeValue
    config.motor_output.neutral_mode = mode.COAST if coast else mode.BRAKE
    for name, value in gains.items():
        setattr(config.slot0, name, value)
    made.configurator.apply(config)
    return made


class Intake(Subsystem):
    def __init__(self, volts: float) -> None:
        super().__init__()
        self.volts = volts
        self.roller = motor(40, 2.5)

    def start(self) -> None:
        self.roller.set_control(controls.VoltageOut(self.volts))

    def stop(self) -> None:
        self.roller.set_control(controls.NeutralOut())

    def take_in(self) -> Command:
        return self.startEnd(self.start, self.stop)


class Feeder(Subsystem):
    def __init__(self) -> None:
        super().__init__()
        self.floor, self.tunnel, self.kicker = motor(41, 4.0), motor(42, 3.0), motor(43, 2.0)

    def feed(self) -> Command:
        return self.runEnd(lambda: self.turn(8.0), lambda: self.turn(0.0))

    def turn(self, volts: float) -> None:
        for part in (self.floor, self.tunnel, self.kicker):
            part.set_control(controls.VoltageOut(volts))


class Wheels(Subsystem):
    def __init__(self, rps: float, tolerance: float) -> None:
        super().__init__()
        self.rps, self.tolerance = rps, tolerance
        self.leader = motor(44, 1.0, k_v=0.123, k_p=0.3, k_s=0.15)
        self.follower = motor(45, 1.0)
        self.follower.set_control(controls.Follower(44, signals.MotorAlignmentValue.OPPOSED))

    def spin(self) -> Command:
        return self.runEnd(lambda: self.leader.set_control(controls.VelocityVoltage(self.rps)), self.stop)

    def stop(self) -> None:
        self.leader.set_control(controls.CoastOut())

    def is_ready(self) -> bool:
        return abs(self.leader.get_velocity().value - self.rps) < self.tolerance
