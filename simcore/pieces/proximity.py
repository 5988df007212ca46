"""When pieces wake and sleep, and what of a robot the pieces need to know for it."""

from __future__ import annotations

from dataclasses import dataclass

from simcore.errors import ConfigError, require_positive

__all__ = ["Mover", "Proximity"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Proximity:
    """When pieces wake and sleep."""

    chunk_size: float = 2.0
    """Edge of a chunk [m]."""
    chunk_linger: int = 25
    """Ticks that a chunk stays visible to the engine after the last mover left its reach."""
    margin: float = 0.05
    """Added to the reach of a robot [m]."""
    piece_margin: float = 0.01
    """Added to the reach of a moving piece [m]."""
    waking_speed: float = 0.05
    """A piece slower than this wakes nobody by coming near [m/s]; by touch it still does, in the engine."""
    slow_speed: float = 0.03
    """Below this a piece counts as slow [m/s]: gravity alone gives 0.2 m/s in a tick, so nothing in the air does."""
    slow_ticks: int = 15
    """Ticks in a row that a piece must be slow before it sleeps; by then the engine has repaired overlaps, too."""

    def __post_init__(self) -> None:
        for name in ("chunk_size", "margin", "piece_margin", "slow_speed", "waking_speed"):
            require_positive("Proximity", name, getattr(self, name))
        if not (isinstance(self.chunk_linger, int) and self.chunk_linger >= 0):
            raise ConfigError(f"Proximity: chunk_linger must be a whole number >= 0, got {self.chunk_linger!r}")
        if self.slow_ticks < 5:
            raise ConfigError(f"Proximity: slow_ticks must be at least 5 (else apexes freeze), got {self.slow_ticks}")


@dataclass(frozen=True, slots=True)
class Mover:
    """A robot as the pieces see it."""

    x: float
    y: float
    yaw: float
    half_length: float
    """Half of the bumper box along its heading [m]."""
    half_width: float
    speed: float
    """Fastest point of the box [m/s], so including spin."""
