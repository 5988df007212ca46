"""Spindexer and feeder: they bring fuel from the hopper to the shooter wheels."""

from commands2 import Subsystem
from constants import Ids
from phoenix6 import configs, controls, hardware, signals

FEED_RPS = 35.0  # of the feeder wheels


class Spindexer(Subsystem):
    """A plate that turns under the fuel."""

    def __init__(self) -> None:
        super().__init__()
        self._motor = hardware.TalonFX(Ids.SPINDEXER)
        config = configs.TalonFXConfiguration()
        config.motor_output.inverted = signals.InvertedValue.CLOCKWISE_POSITIVE
        config.current_limits.stator_current_limit = 60.0
        self._motor.configurator.apply(config)
        self._turn = controls.VoltageOut(0.0)

    def set_turning(self, turning: bool) -> None:
        self._motor.set_control(self._turn.with_output(6.0 if turning else 0.0))

    # ==================== SIMULATION SUPPORT - sim-only methods below this line ====================

    @property
    def spindexerSimMotor(self) -> hardware.TalonFX:
        return self._motor


class Feeder(Subsystem):
    """Wheels that push fuel into the shooter, in closed loop."""

    def __init__(self) -> None:
        super().__init__()
        self._motor = hardware.TalonFX(Ids.FEEDER)
        config = configs.TalonFXConfiguration()
        config.motor_output.inverted = signals.InvertedValue.CLOCKWISE_POSITIVE
        config.motor_output.neutral_mode = signals.NeutralModeValue.BRAKE
        config.current_limits.stator_current_limit = 60.0
        config.feedback.sensor_to_mechanism_ratio = 2.0
        config.slot0.k_v = 0.24
        config.slot0.k_p = 0.2
        self._motor.configurator.apply(config)
        self._turn = controls.VelocityVoltage(0.0)
        self._stop = controls.NeutralOut()

    def set_turning(self, turning: bool) -> None:
        self._motor.set_control(self._turn.with_velocity(FEED_RPS) if turning else self._stop)

    # ==================== SIMULATION SUPPORT - sim-only methods below this line ====================

    @property
    def feederSimMotor(self) -> hardware.TalonFX:
        return self._motor
