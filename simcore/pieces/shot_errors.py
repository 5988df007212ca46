"""What single shots of a shooter are off by."""

from __future__ import annotations

from dataclasses import dataclass

from simcore.typing import FloatSupplier

__all__ = ["ShotErrors"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotErrors:
    """Suppliers are called once a shot, in the order of the shots."""

    exit_speed: FloatSupplier
    """Factor of the speed at which it leaves [-]."""
    elevation: FloatSupplier
    """[rad]"""
    azimuth: FloatSupplier
    """To the left [rad]."""
    spin: FloatSupplier
    """Factor [-]."""
    feed_time: FloatSupplier
    """Until the next one [s]."""
    hood: float = 0.0
    """How much farther the hood truly is than its encoder shows [rad]."""
    turret: float = 0.0
    """The same of the turret [rad]."""
