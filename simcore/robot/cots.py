"""COTS swerve modules and wheel treads, by name.

Source: `COTS` table of MapleSim 0.4. The gear ratios are from the vendors' pages. The coefficients of friction are from
tests on carpet by team 3847, Spectrum. Steer inertia, efficiency and friction are the defaults of `SwerveModuleConfig`.
"""

from __future__ import annotations

from dataclasses import dataclass

from simcore.errors import ConfigError, UnknownNameError
from simcore.quantities import GEARING, ROBOT_LENGTH, require_fields
from simcore.robot.dc_motor import MotorModel, motor
from simcore.robot.swerve_config import SwerveModuleConfig
from simcore.units import inches

__all__ = ["MODULES", "TREADS", "SwerveModuleType", "swerve_module", "tread"]


@dataclass(frozen=True, slots=True, kw_only=True)
class SwerveModuleType:
    """Gear ratios and wheel radius of a COTS swerve module."""

    name: str
    drive_gearings: tuple[float, ...]
    """Available drive gear ratios, from slowest to fastest [-]."""
    steer_gearing: float
    """Turns of the steer motor's rotor per turn of the module [-]."""
    wheel_radius: float = inches(2.0)
    """Radius of the wheel with a new tread [m]."""

    def __post_init__(self) -> None:
        require_fields(self, self.name, drive_gearings=[GEARING], steer_gearing=GEARING, wheel_radius=ROBOT_LENGTH)


def _row(name: str, gearings: tuple[float, ...], steer: float, radius: float = inches(2.0)) -> SwerveModuleType:
    return SwerveModuleType(name=name, drive_gearings=gearings, steer_gearing=steer, wheel_radius=radius)


_ROWS = (
    _row("SDS MK4", (8.14, 6.75, 6.12, 5.14), 12.8),
    _row("SDS MK4i", (8.14, 6.75, 6.12, 5.15), 150.0 / 7.0),
    _row("SDS MK4n", (7.13, 5.90, 5.36), 18.75),
    _row("SDS MK5n", (7.03, 6.03, 5.27), 287.0 / 11.0),
    _row("SDS MK5i", (7.03, 6.03, 5.27), 26.0),
    _row("WCP SwerveX Flipped", (8.10, 7.36, 6.75, 6.72, 6.11, 5.60, 5.51, 5.01, 4.59), 13.3714),
    _row("WCP SwerveXS", (6.00, 5.54, 5.14, 4.71, 4.40, 4.13), 41.25),
    _row("WCP SwerveX2", (7.67, 6.98, 6.82, 6.48, 6.39, 6.20, 5.89, 5.68, 5.67, 5.40, 5.15, 4.73), 12.1),
    _row("WCP SwerveX2S", (6.00, 5.63, 5.29, 4.94, 4.67, 4.42, 4.11, 3.90, 3.71), 25.9),
    _row("REV MAXSwerve", (5.50, 5.08, 4.71, 4.50, 4.29, 4.00, 3.75, 3.56), 9424.0 / 203.0, inches(1.5)),
    _row("Thrifty Swerve", (6.75, 6.23, 6.00, 5.79, 5.54, 5.14), 25.0),
)
MODULES: dict[str, SwerveModuleType] = {m.name: m for m in _ROWS}
"""Swerve module types by product name.

WCP publishes no final drive ratios for the first SwerveX (steer ratio 11.3142), so this table does not contain the
first SwerveX.
"""

TREADS = {
    "colson": 0.899,
    "neoprene": 1.426,
    "blue nitrile": 1.542,
    "VEX Grip V2": 1.916,
    "TPU": 2.106,
}
"""Coefficient of friction of each tread on carpet, by name [-]."""


def tread(name: str) -> float:
    """Look up the coefficient of friction of a tread on carpet [-].

    Raises:
        UnknownNameError: If no tread has this name; the message suggests similar names.
    """
    if name not in TREADS:
        raise UnknownNameError("tread", name, TREADS)
    return TREADS[name]


def swerve_module(
    name: str,
    *,
    gearing: float,
    drive_motor: MotorModel | None = None,
    steer_motor: MotorModel | None = None,
    wheel_cof: float = 1.2,
    drive_stator_limit: float | None = None,
    drive_supply_limit: float | None = None,
) -> SwerveModuleConfig:
    """Return the config of a COTS module at the robot center; `SwerveConfig.square` or `replace` sets the position.

    Example:
        >>> swerve_module("SDS MK4i", gearing=6.75).steer_gearing
        21.428571428571427

    Args:
        name: Product name, a key of `MODULES`.
        gearing: Drive gear ratio, within 1 % of one of the product's ratios [-]; for L2, 6.75 or the exact 6.746.
        drive_motor: Drive motor; None for a Kraken X60.
        steer_motor: Steer motor; None for a Kraken X60.
        wheel_cof: Coefficient of friction of the wheels on carpet [-]; see `tread`.
        drive_stator_limit: Stator current limit of the drive motor [A]; None for the controller's factory default.
        drive_supply_limit: Supply current limit of the drive motor [A]; None for the controller's factory default.

    Raises:
        UnknownNameError: If the product is unknown.
        ConfigError: If the product is not available with this gear ratio.
    """
    if name not in MODULES:
        raise UnknownNameError("swerve module", name, MODULES)
    product = MODULES[name]
    if all(abs(g - gearing) > 0.01 * g for g in product.drive_gearings):
        raise ConfigError(f"{name} is not sold with a drive gearing of {gearing}; it has {product.drive_gearings}")
    return SwerveModuleConfig(
        x=0.0,
        y=0.0,
        drive_motor=drive_motor or motor("Kraken X60"),
        steer_motor=steer_motor or motor("Kraken X60"),
        drive_gearing=gearing,
        steer_gearing=product.steer_gearing,
        wheel_radius=product.wheel_radius,
        wheel_cof=wheel_cof,
        drive_stator_limit=drive_stator_limit,
        drive_supply_limit=drive_supply_limit,
    )
