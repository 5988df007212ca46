"""Reads CTRE's generated swerve constants; by attribute names alone, so phoenix6 is not needed."""

from __future__ import annotations

import math
from collections.abc import Sequence

from simcore.errors import ConfigError
from simcore.robot.dc_motor import MotorModel, motor
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.wheel_config import plate_inertia

__all__ = ["arranged_motor", "swerve_config_from_ctre"]

# By the name of CTRE's arrangement enums. A TalonFX may be a Falcon or either Kraken; the constants do not say.
_ARRANGEMENTS = {
    "TALON_FX_INTEGRATED": "Kraken X60 FOC",
    "TALON_FXS_MINION_JST": "Minion",
    "TALON_FXS_NEO_JST": "NEO",
    "TALON_FXS_NEO550_JST": "NEO 550",
    "TALON_FXS_VORTEX_JST": "NEO Vortex",
    "TALON_FXS_BRUSHED_AB": "CIM",
    "TALON_FXS_BRUSHED_AC": "CIM",
    "TALON_FXS_BRUSHED_BC": "CIM",
}


def swerve_config_from_ctre(
    modules: Sequence[object],
    *,
    mass: float = 55.0,
    bumper: tuple[float, float] = (0.8, 0.8),
    height: float = 0.2,
    wheel_cof: float = 1.2,
    drive_motor: MotorModel | None = None,
    steer_motor: MotorModel | None = None,
) -> SwerveConfig:
    """A `SwerveConfig` from `SwerveModuleConstants`.

    Taken over: positions, gear ratios, coupling, wheel radius, motor kinds and current limits. Left out on
    purpose: inertias and friction voltages, which the generator fills with placeholders (0.01 kg m^2, 0.2 V) and which
    stand for no robot. Mass and bumpers are nowhere in the constants.

    Args:
        modules: One per module, in the robot's order.
        mass: Of the robot [kg].
        bumper: Length and width, for the yaw inertia [m].
        height: Of the center of mass [m].
        wheel_cof: Coefficient of friction of the wheels on carpet.
        drive_motor: When the constants' `TALON_FX_INTEGRATED` is not a Kraken X60 with FOC.
        steer_motor: The same for the azimuths.

    Raises:
        ConfigError: When an attribute is missing or makes no sense; it names the module.
    """
    return SwerveConfig(
        modules=tuple(_module(k, c, wheel_cof, drive_motor, steer_motor) for k, c in enumerate(modules)),
        mass=mass,
        yaw_inertia=plate_inertia(mass, *bumper),
        center_of_mass=(0.0, 0.0, height),
    )


def _module(
    k: int, constants: object, wheel_cof: float, drive_motor: MotorModel | None, steer_motor: MotorModel | None
) -> SwerveModuleConfig:
    owner = f"module {k}"

    def number(name: str) -> float:
        value = getattr(constants, name, None)
        if not isinstance(value, (int, float)) or not math.isfinite(value):
            raise ConfigError(f"{owner}: CTRE constants need a finite {name}, got {value!r}")
        return float(value)

    drive = getattr(constants, "drive_motor_initial_configs", None)
    steer = getattr(constants, "steer_motor_initial_configs", None)
    slip_current = getattr(constants, "slip_current", None)
    stator, supply = _limits(drive)
    # CTRE applies the slip current as the drive motors' stator limit.
    if isinstance(slip_current, (int, float)) and slip_current > 0.0:
        stator = float(slip_current) if stator is None else min(stator, float(slip_current))
    steer_stator, steer_supply = _limits(steer)
    return SwerveModuleConfig(
        name=owner,
        x=number("location_x"),
        y=number("location_y"),
        drive_motor=drive_motor or arranged_motor(constants, "drive_motor_type"),
        steer_motor=steer_motor or arranged_motor(constants, "steer_motor_type"),
        drive_gearing=number("drive_motor_gear_ratio"),
        steer_gearing=number("steer_motor_gear_ratio"),
        coupling_ratio=number("coupling_gear_ratio"),
        wheel_radius=number("wheel_radius"),
        wheel_cof=wheel_cof,
        drive_stator_limit=stator,
        drive_supply_limit=supply,
        steer_stator_limit=steer_stator,
        steer_supply_limit=steer_supply,
    )


def arranged_motor(constants: object, name: str) -> MotorModel:
    """The motor that an arrangement of CTRE's constants names.

    Args:
        constants: Of a module.
        name: `drive_motor_type` or `steer_motor_type`.
    """
    kind = getattr(getattr(constants, name, None), "name", "TALON_FX_INTEGRATED")
    return motor(_ARRANGEMENTS.get(kind, "Kraken X60 FOC"))


def _limits(configs: object) -> tuple[float | None, float | None]:
    """Stator and supply limit of a TalonFX configuration [A], infinite where disabled; None: it says nothing."""
    limits = getattr(configs, "current_limits", None)
    if limits is None:
        return None, None

    def one(kind: str) -> float:
        value = getattr(limits, f"{kind}_current_limit", None)
        enabled = getattr(limits, f"{kind}_current_limit_enable", False)
        return float(value) if enabled and isinstance(value, (int, float)) and value > 0.0 else math.inf

    return one("stator"), one("supply")
