"""The intake: a rack that goes out over the bumper, and a roller that pulls fuel in."""

from commands2 import Command, Subsystem
from constants import Ids
from phoenix6 import configs, controls, hardware, signals

OUT = 2.3  # rotations of the pinion
IN = 0.0


class Intake(Subsystem):
    """Out and turning, or in and still."""

    def __init__(self) -> None:
        super().__init__()
        self._deploy = hardware.TalonFX(Ids.DEPLOY)
        self._roller = hardware.TalonFX(Ids.ROLLER)
        deploy = configs.TalonFXConfiguration()
        deploy.motor_output.neutral_mode = signals.NeutralModeValue.BRAKE
        deploy.current_limits.stator_current_limit = 40.0
        deploy.feedback.sensor_to_mechanism_ratio = 10.0
        deploy.slot0.k_p = 20.0
        deploy.slot0.k_d = 0.3
        self._deploy.configurator.apply(deploy)
        roller = configs.TalonFXConfiguration()
        roller.current_limits.stator_current_limit = 60.0
        self._roller.configurator.apply(roller)
        self._deploy.set_position(IN)  # it is switched on with the rack against its inner stop
        self._place = controls.PositionVoltage(IN)
        self._turn = controls.VoltageOut(0.0)
        self.is_out = False

    def toggle(self) -> Command:
        return self.runOnce(lambda: self.set_out(not self.is_out))

    def out(self) -> Command:
        return self.runOnce(lambda: self.set_out(True))

    def set_out(self, out: bool) -> None:
        self.is_out = out
        self._deploy.set_control(self._place.with_position(OUT if out else IN))
        self._roller.set_control(self._turn.with_output(9.0 if out else 0.0))

    # ==================== SIMULATION SUPPORT - sim-only methods below this line ====================

    @property
    def deploySimMotor(self) -> hardware.TalonFX:
        return self._deploy

    @property
    def rollerSimMotor(self) -> hardware.TalonFX:
        return self._roller
