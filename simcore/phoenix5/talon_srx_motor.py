"""A Talon SRX or Victor SPX on a mechanism."""

from __future__ import annotations

import math
from typing import Any

from simcore.devices.motor_sim import LoopMotorSim, LoopPort
from simcore.phoenix5.talon_srx_port import TalonSRXPort

__all__ = ["TalonSRXMotorSim"]


class TalonSRXMotorSim(LoopMotorSim):
    """Connects a Talon SRX or Victor SPX, and those that follow it, with any mechanism; arguments as `LoopMotorSim`.

    An encoder is on the mechanism, and counts from where it was switched on; an absolute one is zero at the mechanism's
    zero. There is none on the rotor.
    """

    def port(self, controller: Any, sign: float) -> LoopPort:
        """See `LoopMotorSim`."""
        port = TalonSRXPort(controller, sign=sign)
        port.start_at_zero(self.mechanism.position * self._encoder_gearing / math.tau)
        return port
