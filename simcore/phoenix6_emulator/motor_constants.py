"""Motor and bridge of a motor controller as CTRE's simulation has them: volts, torque current, current limits."""

from __future__ import annotations

import math
from dataclasses import dataclass

from simcore.errors import ConfigError

__all__ = ["ARRANGEMENTS", "KRAKEN_X44", "KRAKEN_X60", "MotorConstants"]


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorConstants:
    """A motor without its mechanism, at 12 V.

    Source: stall current and free speed measured on CTRE's simulation 26.3, torque current at 1, 3 and 6 V with the
    rotor held at 0, 20 and 60 rotations/s; the Kraken X60 is WPILib's `DCMotor.krakenX60FOC`.
    """

    name: str
    """As robot code calls it."""
    stall_current: float
    """[A]"""
    free_rps: float
    """Rotor speed without load [rotations/s]."""
    trapezoidal_stall: float
    """Stall current without FOC [A]."""
    trapezoidal_rps: float
    """Free speed without FOC [rotations/s]."""
    kt: float
    """What `get_motor_kt` answers [N m/A]."""
    kv: float
    """What `get_motor_kv` answers [rpm/V]."""
    reported_stall: float
    """What `get_motor_stall_current` answers [A]."""
    connected: int
    """`ConnectedMotorValue`."""

    def __post_init__(self) -> None:
        for field in ("stall_current", "free_rps", "trapezoidal_stall", "trapezoidal_rps"):
            value = getattr(self, field)
            if not (math.isfinite(value) and value > 0.0):
                raise ConfigError(f"{self.name}: {field} must be finite and > 0, got {value}")


KRAKEN_X60 = MotorConstants(
    name="Kraken X60",
    stall_current=483.0,
    free_rps=5800.0 / 60.0,
    trapezoidal_stall=366.0,
    trapezoidal_rps=100.0,
    kt=0.0198,
    kv=490.0,
    reported_stall=476.0,
    connected=2,
)
KRAKEN_X44 = MotorConstants(
    name="Kraken X44",
    stall_current=329.0,
    free_rps=125.0,
    trapezoidal_stall=277.5,
    trapezoidal_rps=130.0,
    kt=0.0154,
    kv=625.0,
    reported_stall=329.0,
    connected=2,  # the simulated device reports this for both motors
)


def _jst(name: str, stall: float, rps: float, kt: float, kv: float, reported: float, connected: int) -> MotorConstants:
    return MotorConstants(
        name=name,
        stall_current=stall,
        free_rps=rps,
        trapezoidal_stall=stall,
        trapezoidal_rps=rps,
        kt=kt,
        kv=kv,
        reported_stall=reported,
        connected=connected,
    )


ARRANGEMENTS: dict[int, MotorConstants] = {
    1: _jst("Minion", 211.0, 126.9, 0.0152, 633.0, 212.0, 4),
    2: _jst("brushed motor", 129.1, 89.0, 0.0, 444.0, 0.0, 5),
    5: _jst("NEO", 103.5, 94.6, 0.0196, 490.0, 216.0, 8),
    6: _jst("NEO 550", 98.9, 185.0, 0.0097, 975.0, 111.0, 9),
    7: _jst("Vortex", 207.8, 113.6, 0.0154, 565.0, 391.0, 10),
}
"""Motors of a TalonFXS by `MotorArrangementValue`; a brushed motor is a CIM."""
