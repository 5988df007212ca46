"""A carriage that a drum lifts against gravity between hard stops."""

from __future__ import annotations

from dataclasses import dataclass

from simcore.errors import ConfigError, require_finite, require_non_negative, require_positive
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.shaft import ShaftSim
from simcore.units import GRAVITY

__all__ = ["ElevatorConfig", "ElevatorSim"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ElevatorConfig:
    """A carriage, what lifts it and how far it goes."""

    gearbox: GearboxConfig
    carriage_mass: float
    """Of all that is lifted, rotor inertia over radius squared included [kg]."""
    drum_radius: float
    """Carriage travel per rad of the drum [m]."""
    min_height: float = 0.0
    """Lower hard stop [m]."""
    max_height: float
    """Upper hard stop [m]."""
    start_height: float | None = None
    """Where the carriage is at first; None is the lower stop [m]."""
    gravity: float = GRAVITY
    """Along the elevator; zero if a spring carries the weight [m/s^2]."""

    def __post_init__(self) -> None:
        require_positive("ElevatorConfig", "carriage_mass", self.carriage_mass, "kg")
        require_positive("ElevatorConfig", "drum_radius", self.drum_radius, "m")
        require_non_negative("ElevatorConfig", "gravity", self.gravity, "m/s^2")
        for name in ("min_height", "max_height", "start"):
            require_finite("ElevatorConfig", name, getattr(self, name), "m")
        if not self.min_height < self.max_height:
            raise ConfigError(
                f"ElevatorConfig: min_height must be below max_height, got {self.min_height}, {self.max_height}"
            )
        if not self.min_height <= self.start <= self.max_height:
            raise ConfigError(f"ElevatorConfig: start_height must be between the stops, got {self.start_height}")

    @property
    def start(self) -> float:
        """Height at first [m]."""
        return self.min_height if self.start_height is None else self.start_height


class ElevatorSim(ShaftSim):
    """An elevator; `position` is the drum's angle, `height` the carriage's place. Gravity is constant, so exact."""

    __slots__ = ("_radius", "_weight_torque", "holding_volts")

    def __init__(self, config: ElevatorConfig) -> None:
        radius = config.drum_radius
        super().__init__(
            config.gearbox,
            config.carriage_mass * radius * radius,
            lower_stop=config.min_height / radius,
            upper_stop=config.max_height / radius,
            position=config.start / radius,
        )
        self._radius = radius
        self._weight_torque = config.carriage_mass * config.gravity * radius
        self.holding_volts = config.gearbox.holding_volts(self._weight_torque)
        """Voltage that holds the carriage against gravity [V]."""
        self.set_load(0.0)

    def set_load(self, torque: float) -> None:
        """Let this torque [N m] act on the drum besides the weight, along positive motion."""
        super().set_load(torque - self._weight_torque)

    @property
    def height(self) -> float:
        """Of the carriage [m]."""
        return self.position * self._radius

    @property
    def speed(self) -> float:
        """Of the carriage, upward positive [m/s]."""
        return self.velocity * self._radius
