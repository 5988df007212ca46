"""Funnel and claw: rollers that bring a coral from the back of the robot to the end of the arm, and let it go there."""

from commands2 import Subsystem
from constants import Ids
from phoenix6 import configs, controls, hardware

HAS_CORAL = 0.12  # m; nearer than that it is a coral that the CANrange sees, and not the claw


class Claw(Subsystem):
    """Rollers around one coral, and a CANrange that sees it."""

    def __init__(self) -> None:
        super().__init__()
        self._motor = hardware.TalonFX(Ids.CLAW)
        config = configs.TalonFXConfiguration()
        config.current_limits.stator_current_limit = 40.0
        self._motor.configurator.apply(config)
        self._eye = hardware.CANrange(Ids.CLAW)
        sensor = configs.CANrangeConfiguration()
        sensor.proximity_params.proximity_threshold = HAS_CORAL
        self._eye.configurator.apply(sensor)
        self._turn = controls.VoltageOut(0.0)

    def take(self) -> None:
        self._motor.set_control(self._turn.with_output(6.0))

    def release(self) -> None:
        self._motor.set_control(self._turn.with_output(-8.0))

    def stop(self) -> None:
        self._motor.set_control(self._turn.with_output(0.0))

    @property
    def has_coral(self) -> bool:
        return bool(self._eye.get_is_detected().value)


class Funnel(Subsystem):
    """Rollers behind the arm that pull in what falls out of a station."""

    def __init__(self) -> None:
        super().__init__()
        self._motor = hardware.TalonFX(Ids.FUNNEL)
        config = configs.TalonFXConfiguration()
        config.current_limits.stator_current_limit = 40.0
        self._motor.configurator.apply(config)
        self._turn = controls.VoltageOut(0.0)

    def set_turning(self, turning: bool) -> None:
        self._motor.set_control(self._turn.with_output(6.0 if turning else 0.0))
