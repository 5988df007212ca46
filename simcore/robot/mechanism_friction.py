"""How much friction a mechanism has where nobody has measured it.

Without friction a mechanism that is let go would turn for ever. Two figures are known without a measurement: the
no-load current of the motor's datasheet, which is what its own bearings and iron take, and the volts of kS that
gearboxes, belts and bearings usually add to it.
"""

from __future__ import annotations

import math

from simcore.errors import ConfigError
from simcore.robot.gearbox import GearboxConfig

__all__ = ["GEARED_FRICTION_VOLTS", "default_friction", "friction_from_volts", "no_load_friction"]

GEARED_FRICTION_VOLTS = 0.2
"""Volts that start a mechanism with gears, belts and bearings [V]; estimate, -50 % to +100 %.

Source: the friction voltage that CTRE's Tuner X generates for both motors of a swerve module
(`SwerveModuleConstants.drive_friction_voltage`, `steer_friction_voltage`); no vendor publishes any for mechanisms.
"""


def no_load_friction(gearbox: GearboxConfig) -> float:
    """Torque that the motors themselves take when they turn free, at the mechanism [N m].

    Source: no-load current of the datasheet times kT; with it the free speed is the datasheet's.

    >>> from wpimath.system.plant import DCMotor
    >>> krakens = GearboxConfig(motor=DCMotor.krakenX60(1), motors=2, gearing=3.0)
    >>> round(no_load_friction(krakens), 3)  # 2 motors x 3 x 2 A x 0.0194 N m/A
    0.232
    """
    return float(gearbox.torque_per_amp * gearbox.motor.freeCurrent)


def friction_from_volts(gearbox: GearboxConfig, volts: float) -> float:
    """Torque at the mechanism for a kS, the volts that it takes to start it [N m].

    Args:
        gearbox: Of the mechanism.
        volts: As SysId finds them; the sign does not matter.

    Raises:
        ConfigError: The volts are not finite.
    """
    if not math.isfinite(volts):
        raise ConfigError(f"friction volts must be a finite number, got {volts}")
    return gearbox.torque_per_amp * abs(volts) / gearbox.resistance


def default_friction(gearbox: GearboxConfig, *, has_gears: bool = True) -> float:
    """Friction of a mechanism about which nothing else is known [N m].

    Args:
        gearbox: Of the mechanism.
        has_gears: False for a flywheel, which is built to run on: little more than the motors' own bearings.
    """
    own = no_load_friction(gearbox)
    return max(own, friction_from_volts(gearbox, GEARED_FRICTION_VOLTS)) if has_gears else own
