"""Simulation of a drivetrain on level carpet without walls, with the logged motor voltages as input."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from simcore.calibrate.runs import Run
from simcore.loop.robot_state import VOLTS
from simcore.robot.battery import Battery, BatteryConfig
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.chassis_config import ChassisConfig, MassDistribution
from simcore.robot.fixed_wheel_config import MecanumConfig, TankConfig
from simcore.robot.fixed_wheel_drive import MecanumDrive, TankDrive
from simcore.robot.swerve_config import SwerveConfig
from simcore.robot.swerve_drive import SwerveDrive
from simcore.robot.wheeled_drive import WheeledDrive
from simcore.typing import FloatArray
from simcore.world.world import PhysicsWorld

__all__ = ["DriveConfig", "Driven", "drive", "varied"]

DriveConfig: TypeAlias = SwerveConfig | TankConfig | MecanumConfig
_BUS = 12.5  # [V], minimum bus voltage of the model


class Driven(NamedTuple):
    """Simulated motion and battery current at the sample times of a run."""

    way: FloatArray
    """Wheel distance that robot code computes with the assumed wheel radius [m], shape (n, sides)."""
    yaw: FloatArray
    """Yaw of the robot, counter-clockwise and continuous over turns [rad], shape (n,)."""
    ground: FloatArray
    """Displacement of the robot's center along the initial heading [m], shape (n,)."""
    amps: FloatArray
    """Battery current of the drive motors [A], shape (n,)."""


def varied(
    config: DriveConfig, *, ks: float, mass: float, efficiency: float | None = None, sides: float = 0.0,
    radius: float | None = None, speed: float | None = None,
) -> DriveConfig:  # fmt: skip
    """Return a copy of a drivetrain config with new values of the fitted parameters.

    Args:
        config: Drivetrain to copy.
        ks: Static friction voltage of the drive motors [V].
        mass: Mass of the robot [kg]; the yaw moment of inertia changes in proportion.
        efficiency: Efficiency of the drive gearing [-]; None to keep the efficiency of `config`.
        sides: Logarithm of the ratio between right and left efficiency, for a tank drive [-].
        radius: Wheel radius [m]; None to keep the radius of `config`.
        speed: Ratio of the drive motors' free speed to the datasheet value [-]; None to keep the value of `config`.
    """
    body: dict[str, Any] = {"mass": mass, "yaw_inertia": config.yaw_inertia * mass / config.mass}
    own: dict[str, Any] = {} if radius is None else {"wheel_radius": radius}
    own |= {} if speed is None else {"free_speed_share": speed}
    if isinstance(config, SwerveConfig):
        own |= {"drive_friction_volts": ks} | ({} if efficiency is None else {"drive_efficiency": efficiency})
        return replace(config, **body, modules=tuple(replace(m, **own) for m in config.modules))
    mean = config.efficiency if efficiency is None else efficiency
    body |= own | {"friction_volts": ks, "efficiency": min(1.0, mean * math.exp(-0.5 * sides))}
    if isinstance(config, TankConfig) and sides:
        body["right_efficiency"] = min(1.0, mean * math.exp(0.5 * sides))
    return replace(config, **body)


def _drive_of(config: DriveConfig, battery: Battery) -> WheeledDrive[Any]:
    if isinstance(config, SwerveConfig):
        return SwerveDrive(config, battery=battery)
    return (
        TankDrive(config, battery=battery) if isinstance(config, TankConfig) else MecanumDrive(config, battery=battery)
    )


def drive(config: DriveConfig, run: Run, *, radius: float | None = None) -> Driven:
    """Simulate a drivetrain from rest with the motor voltages of a run, and return the motion.

    Args:
        config: Drivetrain to simulate.
        run: Run with one column of voltages per side of a tank drive. All motors of another drivetrain get the mean
            voltage, so the robot drives straight.
        radius: Wheel radius with which robot code computes distances [m]; None for the radius in `config`.
    """
    top = max(_BUS, float(np.abs(run.volts).max()))
    model = _drive_of(config, Battery(BatteryConfig.stiff(top)))
    world = PhysicsWorld()
    size = 2.0 * max(max(abs(x), abs(y)) for x, y in config.wheel_positions) + 0.2
    body = ChassisConfig.around(config, bumper=(size, size))
    roll, pitch, yaw_inertia = body.inertia
    mass = MassDistribution(config.mass, config.center_of_mass, (roll, pitch, yaw_inertia))
    chassis = ChassisSimulation(world, body, drivetrain=model, mass=mass)
    shafts, is_tank = model.shafts, isinstance(config, TankConfig)
    driven = len(model.shaft_angles)
    sides = [0, driven - 1] if is_tank else [0]
    request, position = shafts["request"], shafts["position"]
    request["mode"], request["value"] = VOLTS, 0.0
    values = run.volts if is_tank else run.volts.mean(axis=1, keepdims=True)
    columns = values[:, [0, -1]] if is_tank else np.repeat(values, driven, axis=1)
    n = len(run.times)
    steps, pose, known = (
        np.diff(run.times),
        world.bodies.of(chassis.row),
        config.wheel_radius if radius is None else radius,
    )
    angles, yaw, ground, amps = np.zeros((n, len(sides))), np.zeros(n), np.zeros(n), np.zeros(n)
    for k in range(n - 1):
        request["value"][:driven] = columns[k]
        world.advance(float(steps[k]))
        angles[k + 1] = position[sides]
        axes = pose["axes"][0]
        yaw[k + 1], ground[k + 1] = math.atan2(axes[1, 0], axes[0, 0]), pose["pos"][0, 0]
        amps[k + 1] = shafts["mean_supply"][:driven].sum()
    return Driven(angles * known, np.unwrap(yaw), ground, amps)
