"""DC motors: linear model, and datasheet values of all motors in WPILib."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from simcore.errors import ConfigError, UnknownNameError
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
    shown,
)

__all__ = ["MOTOR_NAMES", "MotorModel", "as_motor", "controller_limits", "motor"]

_DATA = {
    # stall torque [N m], stall current [A], free current [A], free speed [rpm]
    "Andymark 9015": (0.36, 71.0, 3.7, 14270.0),
    "Bag": (0.43, 53.0, 1.8, 13180.0),
    "BaneBots RS-550": (0.38, 84.0, 0.4, 19000.0),
    "BaneBots RS-775": (0.72, 97.0, 2.7, 13050.0),
    "CIM": (2.42, 133.0, 2.7, 5310.0),
    "Falcon 500": (4.69, 257.0, 1.5, 6380.0),
    "Falcon 500 FOC": (5.84, 304.0, 1.5, 6080.0),
    "Kraken X44": (4.11, 279.0, 2.0, 7758.0),
    "Kraken X44 FOC": (5.01, 329.0, 2.0, 7368.0),
    "Kraken X60": (7.09, 366.0, 2.0, 6000.0),
    "Kraken X60 FOC": (9.37, 483.0, 2.0, 5800.0),
    "Mini CIM": (1.41, 89.0, 3.0, 5840.0),
    "Minion": (3.17, 211.0, 2.0, 7704.0),
    "NEO": (2.6, 105.0, 1.8, 5676.0),
    "NEO 550": (0.97, 100.0, 1.4, 11000.0),
    "NEO Vortex": (3.6, 211.0, 3.615, 6784.0),
    "RS-775 125": (0.28, 18.0, 1.6, 5800.0),
    "Romi built-in": (0.1765, 1.25, 0.13, 150.0),
    "Vex 775pro": (0.71, 134.0, 0.7, 18730.0),
}
"""Datasheet values by product name, at 4.5 V for the Romi motor and at 12 V for the others.

Source: WPILib's `DCMotor`, 2026.
"""
_ROMI_VOLTS = 4.5

MOTOR_NAMES = tuple(_DATA)
"""Product names of the motors in WPILib's `DCMotor`."""

_DEFAULT_ROTOR_INERTIA = 4.5e-5
"""Moment of inertia of the rotor of a brushless motor, such as a Kraken X60, a Falcon or a NEO [kg m^2].

Estimate, +-50 %.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorModel:
    """Permanent-magnet DC motor, described by datasheet values.

    Current and torque are linear in speed: I = (V - Omega / kv) / R and tau = kt * I, as in WPILib's `DCMotor`. Some
    datasheets contradict themselves: if `kt * kv` is above 1 (NEO: 1.25), the published stall torque and free speed
    imply more mechanical than electrical power near free speed, even before gear losses.
    """

    name: str
    stall_torque: float
    """Stall torque at nominal voltage [N m]."""
    stall_current: float
    """Stall current at nominal voltage [A]."""
    free_current: float
    """No-load current at nominal voltage [A]."""
    free_speed: float
    """No-load speed at nominal voltage [rad/s]."""
    nominal_voltage: float = 12.0
    """Voltage at which the datasheet values apply [V]."""
    rotor_inertia: float = _DEFAULT_ROTOR_INERTIA
    """Moment of inertia of the rotor about the motor axis [kg m^2]."""
    supply_resistance: float = 0.0
    """Resistance of supply and leads in the vendor's stall test, a part of `nominal_voltage / stall_current` [ohm]. The
    resistance acts only at full duty cycle. At a lower duty cycle or at a current limit, the controller compensates for
    the resistance, which gives more torque per volt. The value is 0 unless the vendor also published stall data below
    the nominal voltage."""

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
        # 0 < free current < stall current keeps R, kt and kv positive, and the model needs a resistance above zero.
        require(self.name, "stall_current - free_current", self.stall_current - self.free_current, CURRENT)
        require(
            self.name,
            "resistance - supply_resistance",
            self.winding_resistance,
            Quantity("ohm", 0.0, 1e6, is_open=True),
        )

    @property
    def resistance(self) -> float:
        """Resistance at full duty cycle: windings, controller, and the supply in the vendor's measurement [ohm]."""
        return self.nominal_voltage / self.stall_current

    @property
    def winding_resistance(self) -> float:
        """Resistance of windings and controller, without the supply [ohm]."""
        return self.resistance - self.supply_resistance

    @property
    def kt(self) -> float:
        """Torque constant: torque per current [N m/A]."""
        return self.stall_torque / self.stall_current

    @property
    def kv(self) -> float:
        """Speed constant: speed per volt of back-EMF [rad/s/V]."""
        return self.free_speed / (self.nominal_voltage - self.resistance * self.free_current)

    def varied(self, *, kt: float, resistance: float) -> MotorModel:
        """Return a copy with a scaled torque constant and a scaled resistance.

        Magnet strength affects the torque constant, and winding temperature affects the resistance. The friction
        torque, kt times the free current, does not change.

        Args:
            kt: Factor on torque per current and on back-EMF per speed [-].
            resistance: Factor on the resistance [-].

        >>> m = motor("Kraken X60")
        >>> one = m.varied(kt=1.02, resistance=1.1)
        >>> round(one.kt / m.kt, 9), round(m.kv / one.kv, 9), round(one.resistance / m.resistance, 9)
        (1.02, 1.02, 1.1)
        """
        if kt == resistance == 1.0:
            return self  # bit-identical
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
    """Look up a motor by name; upper and lower case, spaces and punctuation do not matter.

    >>> round(motor("Kraken X60").stall_torque, 2)
    7.09
    >>> motor("krakenx60") == motor("Kraken X60")
    True

    Raises:
        UnknownNameError: If WPILib has no motor with this name; the message suggests similar names.
    """
    wanted = _plain(name)
    for known in MOTOR_NAMES:
        if _plain(known) == wanted:
            return _from_table(known)
    raise UnknownNameError("motor", name, MOTOR_NAMES)


def as_motor(source: Any) -> MotorModel:
    """Convert a WPILib `DCMotor` (2026 or 2027) to a `MotorModel`; return a `MotorModel` unchanged.

    Raises:
        ConfigError: If the source is of neither type.
    """
    if isinstance(source, MotorModel):
        return source
    fields = ("nominal_voltage", "stall_torque", "stall_current", "free_current", "free_speed")
    values: dict[str, Any] = {name: getattr(source, name, getattr(source, _camel_case(name), None)) for name in fields}
    if None in values.values():
        raise ConfigError(
            f"a motor must be one of simcore's, e.g. motor(\"Kraken X60\"), or WPILib's DCMotor; got {shown(source)}"
        )
    return MotorModel(name="DCMotor", **values)


_TALON_MOTORS = ("Kraken", "Falcon", "Minion")
_TALON_LIMITS = (120.0, 70.0)
_SPARK_LIMITS = (80.0, math.inf)


def controller_limits(
    model: MotorModel, stator: float | None = None, supply: float | None = None
) -> tuple[float, float]:
    """Return the stator and supply current limits of a motor [A]: the arguments, or the factory defaults for None.

    By default, a TalonFX or TalonFXS limits the stator current of a Kraken, Falcon or Minion to 120 A and the supply
    current to 70 A. A SPARK limits the stator current of a NEO, NEO 550 or NEO Vortex to 80 A. Other motors have no
    limit: most are brushed motors with a PWM controller and a 40 A breaker, which takes seconds to trip.

    Source: defaults of CurrentLimitsConfigs in Phoenix 6, 2025 and 2026 (without the reduction of the supply limit to
    40 A after a second at 70 A); default smart current limit of REV's SPARK MAX and SPARK Flex.

    >>> controller_limits(motor("Kraken X60")), controller_limits(motor("NEO")), controller_limits(motor("CIM"))
    ((120.0, 70.0), (80.0, inf), (inf, inf))
    """
    usual = (math.inf, math.inf)
    if model.name.startswith(_TALON_MOTORS):
        usual = _TALON_LIMITS
    elif model.name.startswith("NEO"):
        usual = _SPARK_LIMITS
    return usual[0] if stator is None else stator, usual[1] if supply is None else supply


def _camel_case(name: str) -> str:
    first, *others = name.split("_")
    return first + "".join(word.capitalize() for word in others)


def _plain(name: str) -> str:
    return "".join(c for c in name.lower() if c.isalnum())


# Rotors that differ clearly from the 60 mm brushless class; estimates from rotor mass and radius, +-50 %.
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

# At 4 V the vendor's dynamometer measured 2.15 N m and 39 A of supply current. The windings then carry 117 A and have
# 34 of the 47 mohm of 12 V / 257 A. Source: motors.vex.com, quoted in Chief Delphi 392256.
_SUPPLY_RESISTANCE = {"Falcon 500": 0.0127}


@cache
def _from_table(name: str) -> MotorModel:
    stall_torque, stall_current, free_current, free_rpm = _DATA[name]
    return MotorModel(
        name=name,
        stall_torque=stall_torque,
        stall_current=stall_current,
        free_current=free_current,
        free_speed=free_rpm * math.tau / 60.0,
        nominal_voltage=_ROMI_VOLTS if name.startswith("Romi") else 12.0,
        rotor_inertia=_ROTOR_INERTIA.get(name, _DEFAULT_ROTOR_INERTIA),
        supply_resistance=_SUPPLY_RESISTANCE.get(name, 0.0),
    )
