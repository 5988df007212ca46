"""A TalonFXS: the motor controller of a TalonFX with a motor of choice."""

from __future__ import annotations

from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6_emulator.electrical import ARRANGEMENTS, KRAKEN_X60
from simcore.phoenix6_emulator.talon import Talon

__all__ = ["TalonFXS"]


class TalonFXS(Talon):
    """One TalonFXS; without a motor arrangement its bridge stays off."""

    model = "talon fxs"
    type_number = 7

    def configured(self) -> None:
        """Take over a configuration, and with it the motor.

        Raises:
            NotImplementedError: The arrangement is not modelled (a custom brushless motor).
        """
        arrangement = int(self.config[SpnValue.CONFIG_MOTOR_TYPE.value])
        if arrangement and arrangement not in ARRANGEMENTS:
            raise NotImplementedError(f"{self!r}: motor arrangement {arrangement} is not modelled in simulated time")
        self.bridge.motor = ARRANGEMENTS.get(arrangement, KRAKEN_X60)
        self._has_motor = arrangement != 0
        super().configured()

    def set_input(self, name: str, value: float) -> None:
        """As a TalonFX, which motor being a matter of its configuration."""
        if name == "MotorType":
            raise NotImplementedError(f"{self!r}: sim_state input {name!r} is not modelled in simulated time")
        super().set_input(name, value)

    def _loop(self, loops: int, enabled: bool) -> None:
        super()._loop(loops, enabled and self._has_motor)
