"""Motor and bridge of a motor controller as CTRE's simulation has them: volts, torque current, current limits."""

from __future__ import annotations

import math
from dataclasses import dataclass

from simcore.errors import ConfigError

__all__ = ["KRAKEN_X44", "KRAKEN_X60", "MINION", "MotorConstants"]


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorConstants:
    """A motor without its mechanism, at 12 V.

    Source: stall current and free speed measured on CTRE's simulation 26.3 with FOC commutation; they are those of
    WPILib's `DCMotor`.
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
    free_rps=7368.0 / 60.0,
    trapezoidal_stall=279.0,
    trapezoidal_rps=7758.0 / 60.0,
    kt=0.0155,
    kv=617.0,
    reported_stall=329.0,
    connected=3,
)
MINION = MotorConstants(
    name="Minion",
    stall_current=200.46,
    free_rps=7704.0 / 60.0,
    trapezoidal_stall=200.46,
    trapezoidal_rps=7704.0 / 60.0,
    kt=0.0152,
    kv=633.0,
    reported_stall=212.0,
    connected=4,
)
