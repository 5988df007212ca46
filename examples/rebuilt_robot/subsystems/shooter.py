"""The shooter wheels: one leader, three followers; and the hood above them."""

from commands2 import Subsystem
from constants import HOOD_FOR_SHOTS, Ids
from phoenix6 import configs, controls, hardware, signals

LOWEST, HIGHEST = 20.0, 65.0  # degrees


class Shooter(Subsystem):
    """Wheels in closed loop."""

    def __init__(self) -> None:
        super().__init__()
        self._leader = hardware.TalonFX(Ids.SHOOTER)
        self._followers = [hardware.TalonFX(number) for number in Ids.SHOOTER_FOLLOWERS]
        config = configs.TalonFXConfiguration()
        config.motor_output.inverted = signals.InvertedValue.CLOCKWISE_POSITIVE
        config.current_limits.stator_current_limit = 40.0
        config.feedback.sensor_to_mechanism_ratio = 24 / 36
        config.slot0.k_v = 0.0815
        config.slot0.k_p = 0.4
        for motor in (self._leader, *self._followers):
            motor.configurator.apply(config)
        for k, follower in enumerate(self._followers):
            alignment = signals.MotorAlignmentValue.OPPOSED if k > 0 else signals.MotorAlignmentValue.ALIGNED
            follower.set_control(controls.Follower(Ids.SHOOTER, alignment))
        self._turn = controls.VelocityVoltage(0.0)
        self._coast = controls.CoastOut()
        self.goal_rps = 0.0

    def set_speed(self, rps: float) -> None:
        self.goal_rps = rps
        self._leader.set_control(self._turn.with_velocity(rps))

    def stop(self) -> None:
        self.goal_rps = 0.0
        self._leader.set_control(self._coast)

    @property
    def speed_rps(self) -> float:
        return self._leader.get_velocity().value

    @property
    def is_at_speed(self) -> bool:
        return self.goal_rps > 0.0 and abs(self.speed_rps / self.goal_rps - 1.0) < 0.025

    # ==================== SIMULATION SUPPORT - sim-only methods below this line ====================

    @property
    def leaderSimMotor(self) -> hardware.TalonFX:
        return self._leader

    @property
    def followerSimMotors(self) -> list[hardware.TalonFX]:
        return self._followers


class Hood(Subsystem):
    """Turns the shots' elevation; clockwise is up."""

    def __init__(self) -> None:
        super().__init__()
        self._motor = hardware.TalonFX(Ids.HOOD)
        config = configs.TalonFXConfiguration()
        config.motor_output.inverted = signals.InvertedValue.CLOCKWISE_POSITIVE
        config.motor_output.neutral_mode = signals.NeutralModeValue.BRAKE
        config.current_limits.stator_current_limit = 30.0
        config.feedback.sensor_to_mechanism_ratio = 90.0
        config.slot0.k_p = 150.0
        config.slot0.k_d = 4.0
        config.slot0.k_g = 0.05
        config.slot0.gravity_type = signals.GravityTypeValue.ARM_COSINE
        self._motor.configurator.apply(config)
        self._motor.set_position(LOWEST / 360.0)  # it is switched on against its lower stop
        self._place = controls.PositionVoltage(HOOD_FOR_SHOTS / 360.0)
        self.goal_deg = HOOD_FOR_SHOTS
        self.setDefaultCommand(self.run(self._hold))

    def _hold(self) -> None:
        self._motor.set_control(self._place.with_position(self.goal_deg / 360.0))

    def move_goal(self, degrees: float) -> None:
        self.goal_deg = min(max(self.goal_deg + degrees, LOWEST), HIGHEST)

    @property
    def angle_deg(self) -> float:
        return 360.0 * self._motor.get_position().value

    @property
    def is_at_goal(self) -> bool:
        return abs(self.angle_deg - self.goal_deg) < 1.5

    # ==================== SIMULATION SUPPORT - sim-only methods below this line ====================

    @property
    def hoodSimMotor(self) -> hardware.TalonFX:
        return self._motor
