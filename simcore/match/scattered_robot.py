"""The robot that was really built, with this battery and on this carpet: what scatter makes of a `RobotConfig`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from simcore.geometry.symmetry import Pose
from simcore.match.scatter import ScatterDraws
from simcore.pieces.shooter import ShotErrors
from simcore.robot.battery import BatteryConfig
from simcore.robot.dc_motor import MotorModel
from simcore.robot.fixed_wheel_config import MecanumConfig, TankConfig
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.gyro import GyroConfig
from simcore.robot.positioned_mechanisms import PistonConfig, ServoConfig
from simcore.robot.robot_config import BuiltRobot, MechanismConfig, RobotConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.typing import FloatSupplier

__all__ = ["built_robot", "start_error"]

_DRIVE, _STEER, _MECHANISM = range(3)  # groups of motors
_AZIMUTH, _HOOD, _TURRET = range(3)  # groups of encoders
_MAX_COF = 10.0  # what a friction may be
_AHEAD = 64  # numbers that a shooter draws at once


def built_robot(config: RobotConfig, draws: ScatterDraws, robot: int) -> BuiltRobot:
    """What was built after a config.

    Args:
        config: What it should be.
        draws: Of the match.
        robot: Its number.
    """
    drivetrain = config.drivetrain
    return BuiltRobot(
        drivetrain=(
            _swerve(drivetrain, draws, robot)
            if isinstance(drivetrain, SwerveConfig)
            else _fixed_wheels(drivetrain, draws, robot)
        ),
        battery=_battery(config.battery, draws, robot),
        gyro=_gyro(config.gyro, draws, robot),
        mechanisms={
            name: _mechanism(mechanism, draws, robot, number)
            for number, (name, mechanism) in enumerate(config.mechanisms.items())
        },
        shot_errors=tuple(
            _shot_errors(draws, robot, number, hood=shooter.hood is not None, turret=shooter.turret is not None)
            for number, shooter in enumerate(config.shooters)
        ),
    )


def start_error(draws: ScatterDraws, robot: int) -> Pose:
    """By how much people put a robot elsewhere than they should: ahead of it, to its left, and turned [m, m, rad]."""
    return (
        draws.normal("start_position", robot, 0),
        draws.normal("start_position", robot, 1),
        draws.normal("start_heading", robot),
    )


# --- drivetrain -----------------------------------------------------------------------------------------------------


def _swerve(config: SwerveConfig, draws: ScatterDraws, robot: int) -> SwerveConfig:
    tread = draws.factor("tread_friction", robot)

    def built(number: int, module: SwerveModuleConfig) -> SwerveModuleConfig:
        return replace(
            module,
            drive_motor=_motor(module.drive_motor, draws, robot, _DRIVE, number),
            steer_motor=_motor(module.steer_motor, draws, robot, _STEER, number),
            wheel_cof=min(_MAX_COF, tread * module.wheel_cof),
            wheel_radius=module.wheel_radius * (1.0 - draws.share("wheel_wear", robot, number)),
            steer_offset=module.steer_offset + draws.normal("encoder", robot, _AZIMUTH, number),
        )

    return replace(config, modules=tuple(built(number, module) for number, module in enumerate(config.modules)))


def _fixed_wheels(
    config: TankConfig | MecanumConfig, draws: ScatterDraws, robot: int
) -> tuple[TankConfig | MecanumConfig, ...]:
    """Each wheel of a mecanum drive, or the sides of a tank: motors share a side's load, its wheels wear alike."""
    tread = draws.factor("tread_friction", robot)
    is_tank = isinstance(config, TankConfig)
    motors = config.motors_per_side if isinstance(config, TankConfig) else config.motors_per_wheel

    def built(side: int) -> TankConfig | MecanumConfig:
        kt, resistance = _motor_factors(draws, motors, robot, _DRIVE, side)
        return replace(
            config,
            motor=config.motor.varied(kt=kt, resistance=resistance),
            wheel_cof=min(_MAX_COF, tread * config.wheel_cof),
            wheel_radius=config.wheel_radius * (1.0 - draws.share("wheel_wear", robot, side)),
        )

    return tuple(built(shaft) for shaft in range(2 if is_tank else 4))


# --- motors, battery, gyro ------------------------------------------------------------------------------------------


def _motor_factors(draws: ScatterDraws, motors: int, *numbers: int) -> tuple[float, float]:
    """Mean factors of kt and of resistance of motors that turn one shaft."""
    kt = [draws.factor("motor_kt", *numbers, motor) for motor in range(motors)]
    resistance = [draws.factor("motor_resistance", *numbers, motor) for motor in range(motors)]
    return math.fsum(kt) / motors, math.fsum(resistance) / motors


def _motor(motor: MotorModel, draws: ScatterDraws, *numbers: int) -> MotorModel:
    kt, resistance = _motor_factors(draws, 1, *numbers)
    return motor.varied(kt=kt, resistance=resistance)


def _gearbox(gearbox: GearboxConfig, draws: ScatterDraws, *numbers: int) -> GearboxConfig:
    kt, resistance = _motor_factors(draws, gearbox.motors, *numbers)
    return gearbox.varied(kt=kt, resistance=resistance)


def _mechanism(config: MechanismConfig, draws: ScatterDraws, robot: int, number: int) -> MechanismConfig:
    if isinstance(config, PistonConfig | ServoConfig):
        return config
    return replace(config, gearbox=_gearbox(config.gearbox, draws, robot, _MECHANISM, number))


def _battery(config: BatteryConfig, draws: ScatterDraws, robot: int) -> BatteryConfig:
    aged = draws.factor("battery_resistance", robot)  # one cause: what is slow ages with what is fast
    return replace(
        config,
        initial_charge=max(0.0, config.initial_charge - draws.share("battery_charge", robot)),
        resistance=aged * config.resistance,
        recovery_resistance=aged * config.recovery_resistance,
    )


def _gyro(config: GyroConfig, draws: ScatterDraws, robot: int) -> GyroConfig:
    return replace(config, bias_dps=config.bias_dps + math.degrees(draws.normal("gyro", robot)))


# --- shots ----------------------------------------------------------------------------------------------------------


def _shot_errors(draws: ScatterDraws, robot: int, shooter: int, *, hood: bool, turret: bool) -> ShotErrors:
    def errors(name: str) -> FloatSupplier:
        return _normals(getattr(draws.scatter, name), draws.generator(name, robot, shooter))

    def factors(name: str) -> FloatSupplier:
        error = errors(name)
        return lambda: math.exp(error())

    return ShotErrors(
        exit_speed=factors("exit_speed"),
        elevation=errors("elevation"),
        azimuth=errors("azimuth"),
        spin=factors("spin"),
        feed_time=errors("feed_time"),
        hood=draws.normal("encoder", robot, _HOOD, shooter) if hood else 0.0,
        turret=draws.normal("encoder", robot, _TURRET, shooter) if turret else 0.0,
    )


def _normals(size: float, rng: np.random.Generator) -> Callable[[], float]:
    """Normal numbers one by one."""
    ready: list[float] = []

    def next_one() -> float:
        if not ready:
            ready.extend(reversed((size * rng.standard_normal(_AHEAD)).tolist()))
        return ready.pop()

    return next_one
