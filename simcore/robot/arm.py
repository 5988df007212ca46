"""An arm that turns about one joint under gravity, between hard stops: hood, wrist, intake pivot."""

from __future__ import annotations

import math
from dataclasses import dataclass

from simcore.errors import ConfigError, require_finite, require_non_negative, require_positive
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.shaft import ShaftSim
from simcore.units import GRAVITY

__all__ = ["ArmConfig", "ArmSim"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmConfig:
    """An arm, what turns it and how far it can go. Angles are from the horizontal, up positive."""

    gearbox: GearboxConfig
    inertia: float
    """About the joint, rotors included [kg m^2]."""
    mass: float = 0.0
    """Of all that swings; 0 for an arm that springs or its place balance [kg]."""
    center_of_mass: float = 0.0
    """From the joint to the center of mass [m]."""
    min_angle: float
    """Lower hard stop [rad]."""
    max_angle: float
    """Upper hard stop [rad]."""
    start_angle: float | None = None
    """Where the arm is at first; None is the lower stop [rad]."""
    gravity: float = GRAVITY
    """Zero for an arm that turns about a vertical axis [m/s^2]."""
    max_step: float = 0.005
    """Gravity is held for this long, then looked at again [s]."""

    def __post_init__(self) -> None:
        require_positive("ArmConfig", "inertia", self.inertia, "kg m^2")
        require_non_negative("ArmConfig", "mass", self.mass, "kg")
        require_non_negative("ArmConfig", "gravity", self.gravity, "m/s^2")
        require_positive("ArmConfig", "max_step", self.max_step, "s")
        for name in ("center_of_mass", "min_angle", "max_angle", "start"):
            require_finite("ArmConfig", name, getattr(self, name))
        if not self.min_angle < self.max_angle:
            raise ConfigError(f"ArmConfig: min_angle must be below max_angle, got {self.min_angle}, {self.max_angle}")
        if not self.min_angle <= self.start <= self.max_angle:
            raise ConfigError(f"ArmConfig: start_angle must be between the stops, got {self.start_angle}")

    @property
    def start(self) -> float:
        """Angle at first [rad]."""
        return self.min_angle if self.start_angle is None else self.start_angle


class ArmSim(ShaftSim):
    """A single-jointed arm: J dw/dt = motor - m g c cos(angle) + load.

    Gravity bends the line that `ShaftSim` solves, so the step is cut into pieces of at most `max_step`, each exact
    for the motor and with gravity at its middle: second order, and stable however stiff the gearing is.
    """

    __slots__ = ("_max_step", "_weight_torque", "config")

    def __init__(self, config: ArmConfig) -> None:
        super().__init__(
            config.gearbox,
            config.inertia,
            lower_stop=config.min_angle,
            upper_stop=config.max_angle,
            position=config.start,
        )
        self.config = config
        self._max_step = config.max_step
        self._weight_torque = config.mass * config.gravity * config.center_of_mass

    @property
    def holding_volts(self) -> float:
        """Voltage that holds the arm where it is against gravity [V]."""
        return self.gearbox.holding_volts(self._weight_torque * math.cos(self.position))

    def step(self, dt: float, battery_voltage: float = 12.0) -> None:
        """Move on by `dt` [s], with the volts held."""
        if self._weight_torque == 0.0 or not 0.0 < dt < math.inf:
            super().step(dt, battery_voltage)
            return
        load = self._load
        count = math.ceil(dt / self._max_step)
        h = dt / count
        current = supply_current = 0.0
        try:
            for _ in range(count):
                self._load = load - self._weight_torque * math.cos(self.position + 0.5 * h * self.velocity)
                super().step(h, battery_voltage)
                current += self.current
                supply_current += self.supply_current
        finally:
            self._load = load
        self.current = current / count
        self.supply_current = supply_current / count
