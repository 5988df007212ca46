"""A slide that a pinion or a spool pushes along a line between hard stops: an intake that deploys, a climber hook."""

from __future__ import annotations

from dataclasses import dataclass

from simcore.errors import ConfigError, require_finite, require_positive
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.shaft import ShaftSim

__all__ = ["RackConfig", "RackSim"]


@dataclass(frozen=True, slots=True, kw_only=True)
class RackConfig:
    """A slide, what pushes it and how far it goes. Lengths are along the slide."""

    gearbox: GearboxConfig
    mass: float
    """Of all that slides, rotor inertia over radius squared included [kg]."""
    pinion_radius: float
    """Pitch radius of the pinion: slide travel per rad of it [m]."""
    travel: float
    """From the inner to the outer hard stop [m]."""
    start_extension: float = 0.0
    """Where the slide is at first [m]."""

    def __post_init__(self) -> None:
        require_positive("RackConfig", "mass", self.mass, "kg")
        require_positive("RackConfig", "pinion_radius", self.pinion_radius, "m")
        require_positive("RackConfig", "travel", self.travel, "m")
        require_finite("RackConfig", "start_extension", self.start_extension, "m")
        if not 0.0 <= self.start_extension <= self.travel:
            raise ConfigError(
                f"RackConfig: start_extension must be between 0 and {self.travel} m, got {self.start_extension}"
            )


class RackSim(ShaftSim):
    """A rack on a pinion without gravity; `position` is the pinion's angle, `extension` the slide's place."""

    __slots__ = ("_radius", "_travel")

    def __init__(self, config: RackConfig) -> None:
        radius = config.pinion_radius
        super().__init__(
            config.gearbox,
            config.mass * radius * radius,
            lower_stop=0.0,
            upper_stop=config.travel / radius,
            position=config.start_extension / radius,
        )
        self._radius = radius
        self._travel = config.travel

    @property
    def extension(self) -> float:
        """From the inner stop [m]."""
        return self.position * self._radius

    @property
    def speed(self) -> float:
        """Of the slide, outward positive [m/s]."""
        return self.velocity * self._radius

    @property
    def extended_fraction(self) -> float:
        """0 at the inner stop, 1 at the outer one [-]."""
        return self.extension / self._travel
