"""Mechanisms that teams build on a motor-driven shaft: arm, elevator, flywheel, rack and roller."""

from __future__ import annotations

import math
from dataclasses import dataclass

from simcore.errors import ConfigError
from simcore.quantities import (
    ACCELERATION,
    ANGLE,
    INERTIA,
    MASS,
    MASS_OR_NONE,
    ROBOT_LENGTH,
    ROBOT_PLACE,
    require_fields,
)
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.shaft import ShaftSim
from simcore.units import GRAVITY

__all__ = [
    "ArmConfig",
    "ArmSim",
    "ElevatorConfig",
    "ElevatorSim",
    "FlywheelConfig",
    "FlywheelSim",
    "RackConfig",
    "RackSim",
    "RollerConfig",
    "RollerSim",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmConfig:
    """An arm, what turns it and how far it can go. Angles are from the horizontal, up positive."""

    gearbox: GearboxConfig
    inertia: float
    """About the joint, rotors included [kg m^2]."""
    mass: float = 0.0
    """Of all that swings; 0 for an arm that springs or a counterweight balance [kg]."""
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

    def __post_init__(self) -> None:
        require_fields(
            self,
            inertia=INERTIA,
            mass=MASS_OR_NONE,
            center_of_mass=ROBOT_PLACE,
            min_angle=ANGLE,
            max_angle=ANGLE,
            start_angle=ANGLE,
            gravity=ACCELERATION,
        )
        if not self.min_angle < self.max_angle:
            raise ConfigError(f"ArmConfig: min_angle must be below max_angle, got {self.min_angle}, {self.max_angle}")
        if not self.min_angle <= self.start <= self.max_angle:
            raise ConfigError(
                f"ArmConfig: start_angle must be between the stops, min_angle = {self.min_angle:g} and max_angle = "
                f"{self.max_angle:g} rad, got {self.start_angle:g}"
            )

    @property
    def start(self) -> float:
        """Angle at first [rad]."""
        return self.min_angle if self.start_angle is None else self.start_angle


class ArmSim(ShaftSim):
    """A single-jointed arm: J dw/dt = motor - m g c cos(angle) + load."""

    __slots__ = ("config",)

    def __init__(self, config: ArmConfig) -> None:
        super().__init__(
            config.gearbox,
            config.inertia,
            lower_stop=config.min_angle,
            upper_stop=config.max_angle,
            position=config.start,
        )
        self.config = config
        self.record["weight_torque"] = config.mass * config.gravity * config.center_of_mass

    @property
    def holding_volts(self) -> float:
        """Voltage that holds the arm where it is against gravity [V]."""
        return self.gearbox.holding_volts(float(self.record["weight_torque"][0]) * math.cos(self.position))


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
        require_fields(
            self,
            carriage_mass=MASS,
            drum_radius=ROBOT_LENGTH,
            min_height=ROBOT_PLACE,
            max_height=ROBOT_PLACE,
            start_height=ROBOT_PLACE,
            gravity=ACCELERATION,
        )
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
    """An elevator; `position` is the drum's angle, `height` the carriage's. Gravity is constant, so exact."""

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
    def travel_per_radian(self) -> float:
        """Of the carriage, per radian of the drum [m]."""
        return self._radius

    @property
    def height(self) -> float:
        """Of the carriage [m]."""
        return self.position * self._radius

    @property
    def speed(self) -> float:
        """Of the carriage, upward positive [m/s]."""
        return self.velocity * self._radius


@dataclass(frozen=True, slots=True, kw_only=True)
class FlywheelConfig:
    """A flywheel and what turns it."""

    gearbox: GearboxConfig
    inertia: float
    """Of wheels, shafts and rotors, seen at the wheel [kg m^2]."""

    def __post_init__(self) -> None:
        require_fields(self, inertia=INERTIA)


class FlywheelSim(ShaftSim):
    """Launcher wheels: spin up through the motors, give energy to the piece they throw."""

    __slots__ = ()

    def __init__(self, config: FlywheelConfig) -> None:
        super().__init__(config.gearbox, config.inertia)


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
        require_fields(self, mass=MASS, pinion_radius=ROBOT_LENGTH, travel=ROBOT_LENGTH, start_extension=ROBOT_PLACE)
        if not 0.0 <= self.start_extension <= self.travel:
            raise ConfigError(
                f"RackConfig: start_extension must be between 0 and {self.travel} m, got {self.start_extension}"
            )


class RackSim(ShaftSim):
    """A rack on a pinion without gravity; `position` is the pinion's angle, `extension` the way of the slide."""

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
    def travel_per_radian(self) -> float:
        """Of the slide, per radian of the pinion [m]."""
        return self._radius

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


@dataclass(frozen=True, slots=True, kw_only=True)
class RollerConfig:
    """A roller and what turns it."""

    gearbox: GearboxConfig
    inertia: float
    """Seen at the roller [kg m^2]."""
    radius: float
    """Of the surface that touches the pieces [m]."""

    def __post_init__(self) -> None:
        require_fields(self, inertia=INERTIA, radius=ROBOT_LENGTH)


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
