"""A Talon SRX or Victor SPX on a mechanism."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from simcore.devices.loop_ports import LoopMotorSim
from simcore.devices.makers import known_device
from simcore.phoenix5.talon_port import TalonSRXPort
from simcore.robot.shaft import ShaftSim

__all__ = ["TalonSRXMotorSim"]


class TalonSRXMotorSim(LoopMotorSim):
    """Connects a Talon SRX or Victor SPX with any mechanism.

    Positive is the same thing on both sides, as with `TalonFXMotorSim`. An encoder is on the mechanism, and counts from
    where it was switched on; an absolute one is zero at the mechanism's zero.

    Args:
        talon: The device of the robot code; a Victor SPX, too.
        mechanism: What it turns.
        followers: Devices that follow it.
        reversed: Whether positive in robot code is negative for the mechanism.
        encoder_gearing: Turns of the encoder per turn of the mechanism [-].

    Raises:
        ConfigError: The mechanism's gearbox has another number of motors than there are devices, or a device was built
            before simcore was imported.
    """

    def __init__(
        self,
        talon: Any,
        mechanism: ShaftSim,
        *,
        followers: Sequence[Any] = (),
        reversed: bool = False,
        encoder_gearing: float = 1.0,
    ) -> None:
        device = known_device(talon)
        sign = -1.0 if reversed else 1.0
        ports = [TalonSRXPort(d, sign=sign) for d in (device, *(known_device(f) for f in followers))]
        for port in ports:
            port.start_at_zero(mechanism.position * encoder_gearing / math.tau)
        super().__init__(str(device), mechanism, ports[0], ports[1:], encoder_gearing=encoder_gearing)
