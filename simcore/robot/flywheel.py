"""A wheel that stores energy: launcher wheels that a shot slows down."""

from __future__ import annotations

import math
from dataclasses import dataclass

from simcore.errors import NonFiniteError, require_non_negative, require_positive
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.shaft import ShaftSim

__all__ = ["FlywheelConfig", "FlywheelSim", "launch_impulse"]


@dataclass(frozen=True, slots=True, kw_only=True)
class FlywheelConfig:
    """A flywheel and what turns it."""

    gearbox: GearboxConfig
    inertia: float
    """Of wheels, shafts and rotors, seen at the wheel [kg m^2]."""

    def __post_init__(self) -> None:
        require_positive("FlywheelConfig", "inertia", self.inertia, "kg m^2")


class FlywheelSim(ShaftSim):
    """Launcher wheels: spin up through the motors, give energy to the piece they throw."""

    __slots__ = ()

    def __init__(self, config: FlywheelConfig) -> None:
        super().__init__(config.gearbox, config.inertia)

    def apply_impulse(self, angular_impulse: float) -> None:
        """Change the angular momentum at once.

        Args:
            angular_impulse: Along positive motion; a shot from a wheel that turns forward takes, so it is negative
                [N m s].
        """
        if not math.isfinite(angular_impulse):
            raise NonFiniteError(f"FlywheelSim: angular impulse must be a finite number, got {angular_impulse}")
        self.velocity += angular_impulse / self.inertia

    def take_energy(self, energy: float) -> float:
        """Take up to `energy` [J] out of the wheel, which keeps its direction; returns what was there to take [J]."""
        require_non_negative("FlywheelSim.take_energy", "energy", energy, "J")
        before = self.kinetic_energy
        taken = min(energy, before)
        self.velocity = math.copysign(math.sqrt(2.0 * (before - taken) / self.inertia), self.velocity)
        return taken


def launch_impulse(piece_mass: float, exit_speed: float, wheel_radius: float) -> float:
    """Angular impulse that a wheel loses to a piece that it accelerates from rest by its rim, never negative [N m s].

    The rim pushes with F for as long as it takes: the piece gains integral F dt = m v, the wheel loses r m v.
    """
    require_non_negative("launch_impulse", "piece_mass", piece_mass, "kg")
    require_non_negative("launch_impulse", "exit_speed", exit_speed, "m/s")
    require_positive("launch_impulse", "wheel_radius", wheel_radius, "m")
    return piece_mass * exit_speed * wheel_radius
