from magicbot import StateMachine, feedback, state, timed_state, tunable, will_reset_to
from phoenix6 import configs, controls, hardware, signals


class Shooter:
    """One of two, told apart by what is injected: id and gain."""

    id: int
    kv: float
    goal = will_reset_to(0.0)

    def setup(self) -> None:
        self.motor = hardware.TalonFX(self.id, "rio")
        config = configs.TalonFXConfiguration()
        config.slot0.k_v = self.kv
        config.slot0.k_p = 0.3
        config.motor_output.neutral_mode = signals.NeutralModeValue.COAST
        self.motor.configurator.apply(config)

    def spin(self, rps: float) -> None:
        self.goal = rps

    @feedback
    def speed(self) -> float:
        return self.motor.get_velocity().value

    def is_ready(self) -> bool:
        return self.speed() > 38.0

    def execute(self) -> None:
        self.motor.set_control(controls.VelocityVoltage(self.goal) if self.goal else controls.CoastOut())


class Feeder:
    volts = will_reset_to(0.0)

    def setup(self) -> None:
        self.motors = [hardware.TalonFX(33, "rio"), hardware.TalonFX(34, "rio")]

    def feed(self) -> None:
        self.volts = 7.0

    def execute(self) -> None:
        for motor in self.motors:
            motor.set_control(controls.VoltageOut(self.volts))


class ShotControl(StateMachine):
    left: Shooter
    right: Shooter
    feeder: Feeder
    rps = tunable(40.0)

    @state(first=True, must_finish=False)
    def spin_up(self) -> None:
        self.left.spin(self.rps)
        self.right.spin(self.rps)
        if self.left.is_ready() and self.right.is_ready():
            self.next_state("shoot")

    @timed_state(duration=0.5, next_state="spin_up")
    def shoot(self) -> None:
        self.left.spin(self.rps)
        self.right.spin(self.rps)
        self.feeder.feed()
