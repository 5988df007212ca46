"""A roller that moves pieces: intake, feeder, spindexer."""

from __future__ import annotations

from dataclasses import dataclass

from simcore.errors import require_positive
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.shaft import ShaftSim

__all__ = ["RollerConfig", "RollerSim"]


@dataclass(frozen=True, slots=True, kw_only=True)
class RollerConfig:
    """A roller and what turns it."""

    gearbox: GearboxConfig
    inertia: float
    """Seen at the roller [kg m^2]."""
    radius: float
    """Of the surface that touches the pieces [m]."""

    def __post_init__(self) -> None:
        require_positive("RollerConfig", "inertia", self.inertia, "kg m^2")
        require_positive("RollerConfig", "radius", self.radius, "m")


class RollerSim(ShaftSim):
    """A roller on a motor; pieces that it squeezes are a load (`set_load`)."""

    __slots__ = ("radius",)

    def __init__(self, config: RollerConfig) -> None:
        super().__init__(config.gearbox, config.inertia)
        self.radius = config.radius

    @property
    def surface_speed(self) -> float:
        """Of the roller's rim [m/s]."""
        return self.velocity * self.radius
