"""A drivetrain whose robot gets heavier, or moves its center of mass, while it drives."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from simcore.errors import NonFiniteError
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.fixed_wheel_drive import TankDrive
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.swerve_drive import SwerveDrive
from simcore.robot.wheeled_drive import PlanarChassis
from simcore.units import GRAVITY

MODULE = SwerveModuleConfig(
    x=0, y=0, drive_friction_volts=0.0, drive_efficiency=1.0, rolling_resistance=0.0, drive_stator_limit=math.inf
)
HEAVIER = (67.0, 7.0, (0.05, -0.04, 0.35))


def swerve(config: SwerveConfig | None = None) -> SwerveDrive:
    drive = SwerveDrive(config or SwerveConfig.square(0.527, MODULE))
    drive.set_volts([4.0, 3.0, 5.0, 4.0], [1.0, 0.0, 0.0, 0.5])
    return drive


def tank(config: TankConfig | None = None) -> TankDrive:
    drive = TankDrive(config or TankConfig())
    drive.set_volts(5.0, 3.0)
    return drive


@pytest.mark.parametrize("make", [swerve, tank])
def test_a_robot_told_its_mass_moves_as_one_built_with_it(make):
    """Force over mass, torque over inertia, arms and loads from the center of mass: all of them, to the last bit."""
    told = make()
    told.set_mass_properties(*HEAVIER)
    mass, yaw_inertia, center = HEAVIER
    built = make(replace(told.config, mass=mass, yaw_inertia=yaw_inertia, center_of_mass=center))
    assert told.robot.positions == built.config.positions
    paths = []
    for drive in (told, built):
        chassis = PlanarChassis(drive)
        chassis.run(0.5)
        paths.append((chassis.x, chassis.y, chassis.yaw, chassis.vx, chassis.vy, chassis.omega, *chassis.loads))
    assert paths[0] == paths[1]
    assert abs(paths[0][0]) > 0.1


@pytest.mark.parametrize("extra", [0.0, 10.75, 40.0])
def test_acceleration_falls_as_the_mass_grows(extra):
    """a = F / (m + 4 J / r^2) at a fixed motor current; the tires' slip is 1 % of the speed at full grip."""
    drive = swerve()
    drive.set_torque_currents([30.0] * 4, [0.0] * 4)
    mass = 55.0 + extra
    chassis = PlanarChassis(drive)
    chassis.run(0.1)
    drive.set_mass_properties(mass, 5.87 * mass / 55.0, (0.0, 0.0, 0.2))
    before = chassis.vx
    chassis.run(0.1)
    force = 4 * 30.0 * MODULE.drive_motor.kt * MODULE.drive_gearing / MODULE.wheel_radius
    accel = force / (mass + 4 * MODULE.drive_inertia / MODULE.wheel_radius**2)
    assert (chassis.vx - before) / 0.1 == pytest.approx(accel, rel=0.01)
    drive.step(0.005, (chassis.vx, 0.0, 0.0))  # at rest on level ground, says the owner
    assert sum(drive.normal_loads) == pytest.approx(mass * GRAVITY)


@pytest.mark.parametrize(
    "bad", [(0.0, 5.0, (0.0, 0.0, 0.2)), (50.0, -1.0, (0.0, 0.0, 0.2)), (50.0, 5.0, (math.nan,) * 3)]
)
def test_mass_without_sense_is_refused_and_changes_nothing(bad):
    drive = swerve()
    with pytest.raises(NonFiniteError, match="mass properties"):
        drive.set_mass_properties(*bad)
    assert drive.robot == drive.config
