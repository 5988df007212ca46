"""DC motors: the linear model and the table of every motor that WPILib knows."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache

from simcore.errors import UnknownNameError
from simcore.quantities import (
    CURRENT,
    CURRENT_OR_NONE,
    INERTIA_OR_NONE,
    TORQUE,
    TURN_RATE,
    VOLTAGE,
    Quantity,
    require,
    require_fields,
)

__all__ = ["MOTOR_NAMES", "MotorModel", "controller_limits", "motor"]

MOTOR_NAMES = (
    "Andymark 9015",
    "Bag",
    "BaneBots RS-550",
    "BaneBots RS-775",
    "CIM",
    "Falcon 500",
    "Falcon 500 FOC",
    "Kraken X44",
    "Kraken X44 FOC",
    "Kraken X60",
    "Kraken X60 FOC",
    "Mini CIM",
    "Minion",
    "NEO",
    "NEO 550",
    "NEO Vortex",
    "RS-775 125",
    "Romi built-in",
    "Vex 775pro",
)
"""The motors of WPILib's `DCMotor`, by the name printed on the box."""

_DEFAULT_ROTOR_INERTIA = 4.5e-5
"""Inertia of a brushless rotor [kg m^2]; estimate, +-50 %: vendors publish none for Kraken, Falcon, NEO or Vortex."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorModel:
    """A permanent-magnet DC motor as its datasheet describes it.

    Current and torque are straight lines over speed: I = (V - Omega / kv) / R and tau = kt * I, as in WPILib's
    `DCMotor`. Some datasheets contradict themselves: where `kt * kv` is above 1 (NEO: 1.25) the published stall
    torque and free speed together deliver more than the electrical power near free speed, before any gear loss.
    """

    name: str
    stall_torque: float
    """At nominal voltage [N m]."""
    stall_current: float
    """At nominal voltage [A]."""
    free_current: float
    """At nominal voltage and no load [A]."""
    free_speed: float
    """At nominal voltage and no load [rad/s]."""
    nominal_voltage: float = 12.0
    """Voltage of the datasheet [V]."""
    rotor_inertia: float = _DEFAULT_ROTOR_INERTIA
    """Inertia of the rotor about its own axis [kg m^2]."""
    supply_resistance: float = 0.0
    """Share of `nominal_voltage / stall_current` that lay before the controller as the datasheet was measured: supply
    and leads [ohm]. At full duty it acts as on the datasheet; at less duty and at a current limit the controller makes
    up for it, so that a volt makes more torque. 0 unless the vendor has published stall below the nominal voltage."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            self.name,
            stall_torque=TORQUE,
            stall_current=CURRENT,
            free_current=CURRENT_OR_NONE,
            free_speed=TURN_RATE,
            nominal_voltage=VOLTAGE,
            rotor_inertia=INERTIA_OR_NONE,
            supply_resistance=Quantity("ohm", 0.0, 10.0),
        )
        # 0 < free current < stall current keeps R, kt and kv positive: a motor without resistance cannot be written.
        require(self.name, "stall_current - free_current", self.stall_current - self.free_current, CURRENT)
        require(
            self.name,
            "resistance - supply_resistance",
            self.winding_resistance,
            Quantity("ohm", 0.0, 1e6, is_open=True),
        )

    @property
    def resistance(self) -> float:
        """At full duty: windings, controller and the datasheet's supply [ohm]."""
        return self.nominal_voltage / self.stall_current

    @property
    def winding_resistance(self) -> float:
        """Behind the controller: what its own voltage meets [ohm]."""
        return self.resistance - self.supply_resistance

    @property
    def kt(self) -> float:
        """Torque per current [N m/A]."""
        return self.stall_torque / self.stall_current

    @property
    def kv(self) -> float:
        """Speed per volt of back-EMF [rad/s/V]."""
        return self.free_speed / (self.nominal_voltage - self.resistance * self.free_current)

    def varied(self, *, kt: float, resistance: float) -> MotorModel:
        """One of its kind with stronger magnets or a warmer winding; the friction torque stays.

        Args:
            kt: Factor of torque per current, and of volts per speed [-].
            resistance: Factor of the resistance [-].

        >>> m = motor("Kraken X60")
        >>> one = m.varied(kt=1.02, resistance=1.1)
        >>> round(one.kt / m.kt, 9), round(m.kv / one.kv, 9), round(one.resistance / m.resistance, 9)
        (1.02, 1.02, 1.1)
        """
        if kt == resistance == 1.0:
            return self  # to the last bit
        free_current = self.free_current / kt
        return replace(
            self,
            stall_torque=self.stall_torque * kt / resistance,
            stall_current=self.stall_current / resistance,
            free_current=free_current,
            supply_resistance=self.supply_resistance * resistance,
            free_speed=self.kv / kt * (self.nominal_voltage - self.resistance * resistance * free_current),
        )


def motor(name: str) -> MotorModel:
    """Look up a motor by name; case, spaces, dots and dashes do not matter.

    >>> round(motor("Kraken X60").stall_torque, 2)
    7.09
    >>> motor("krakenx60") == motor("Kraken X60")
    True

    Raises:
        UnknownNameError: When WPILib has no such motor; the message names the nearest.
    """
    wanted = _plain(name)
    for known in MOTOR_NAMES:
        if _plain(known) == wanted:
            return _from_wpilib(known)
    raise UnknownNameError("motor", name, MOTOR_NAMES)


_TALON_MOTORS = ("Kraken", "Falcon", "Minion")
_TALON_LIMITS = (120.0, 70.0)
_SPARK_LIMITS = (80.0, math.inf)


def controller_limits(
    model: MotorModel, stator: float | None = None, supply: float | None = None
) -> tuple[float, float]:
    """Stator and supply limit in force: what is configured, else as the motor's controller is delivered [A].

    A TalonFX or TalonFXS limits a Kraken, Falcon or Minion to 120 A and 70 A, a SPARK a NEO or Vortex to 80 A. For
    other motors, mostly brushed ones behind a PWM controller, there are none: what ends them is a breaker of 40 A, that
    takes seconds.

    Source: defaults of CurrentLimitsConfigs in Phoenix 6, 2025 and 2026 (that supply current falls to 40 A after a
    second at 70 A is left out); default smart current limit of REV's SPARK MAX and Flex.

    >>> controller_limits(motor("Kraken X60")), controller_limits(motor("NEO")), controller_limits(motor("CIM"))
    ((120.0, 70.0), (80.0, inf), (inf, inf))
    """
    usual = (math.inf, math.inf)
    if model.name.startswith(_TALON_MOTORS):
        usual = _TALON_LIMITS
    elif model.name.startswith("NEO"):
        usual = _SPARK_LIMITS
    return usual[0] if stator is None else stator, usual[1] if supply is None else supply


def _plain(name: str) -> str:
    return "".join(c for c in name.lower() if c.isalnum())


_FACTORIES = {
    "Andymark 9015": "andymark9015",
    "Bag": "bag",
    "BaneBots RS-550": "banebotsRS550",
    "BaneBots RS-775": "banebotsRS775",
    "CIM": "CIM",
    "Falcon 500": "falcon500",
    "Falcon 500 FOC": "falcon500FOC",
    "Kraken X44": "krakenX44",
    "Kraken X44 FOC": "krakenX44FOC",
    "Kraken X60": "krakenX60",
    "Kraken X60 FOC": "krakenX60FOC",
    "Mini CIM": "miniCIM",
    "Minion": "minion",
    "NEO": "NEO",
    "NEO 550": "NEO550",
    "NEO Vortex": "neoVortex",
    "RS-775 125": "RS775_125",
    "Romi built-in": "romiBuiltIn",
    "Vex 775pro": "vex775Pro",
}

# Rotors that are clearly not of the 60 mm brushless class; estimates from rotor mass and radius, +-50 %.
_ROTOR_INERTIA = {
    "CIM": 7.8e-5,
    "Mini CIM": 5.0e-5,
    "Kraken X44": 2.0e-5,
    "Kraken X44 FOC": 2.0e-5,
    "Minion": 2.0e-5,
    "NEO 550": 6.0e-6,
    "Bag": 1.2e-5,
    "Vex 775pro": 1.2e-5,
    "BaneBots RS-550": 6.0e-6,
    "BaneBots RS-775": 1.2e-5,
    "RS-775 125": 1.2e-5,
    "Andymark 9015": 6.0e-6,
    "Romi built-in": 1.0e-7,
}

# At 4 V the vendor's dynamometer had 2.15 N m and 39 A from the supply: 117 A in the windings, which is 34 of the
# 47 mohm of 12 V / 257 A. Source: motors.vex.com, quoted in Chief Delphi 392256.
_SUPPLY_RESISTANCE = {"Falcon 500": 0.0127}


@cache
def _from_wpilib(name: str) -> MotorModel:
    from wpimath.system.plant import DCMotor  # here, so that importing simcore stays free of native libraries

    m = getattr(DCMotor, _FACTORIES[name])(1)
    return MotorModel(
        name=name,
        stall_torque=m.stallTorque,
        stall_current=m.stallCurrent,
        free_current=m.freeCurrent,
        free_speed=m.freeSpeed,
        nominal_voltage=m.nominalVoltage,
        rotor_inertia=_ROTOR_INERTIA.get(name, _DEFAULT_ROTOR_INERTIA),
        supply_resistance=_SUPPLY_RESISTANCE.get(name, 0.0),
    )
