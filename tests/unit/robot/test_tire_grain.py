"""Treads that hold less across than along: an ellipse of friction."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from simcore.errors import ConfigError
from simcore.loop.robot_state import STEP
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.fixed_wheel_drive import TankDrive
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.swerve_drive import SwerveDrive
from simcore.robot.wheeled_drive import PlanarChassis
from simcore.units import GRAVITY

MODULE = SwerveModuleConfig(x=0, y=0, wheel_grain=0.73, rolling_resistance=0.0)


def sliding(angle: float, module: SwerveModuleConfig = MODULE) -> SwerveDrive:
    """Locked wheels that slide forward at 3 m/s, turned by an angle [rad]; load stays where it is."""
    drive = SwerveDrive(SwerveConfig.square(0.527, module, height=0.0))
    drive.reset(angles=[angle] * 4)
    drive.state.wheel_speed[:] = [0.0] * 4
    chassis = PlanarChassis(drive)
    chassis.reset(vx=3.0)
    for _ in range(4):
        drive.state.wheel_speed[:] = [0.0] * 4
        chassis.step(2e-5)  # within it a wheel that the carpet turns gains 0.1 % of the slip
    return drive


@pytest.mark.parametrize("angle", [0.0, 90.0, 30.0, -45.0])
def test_a_slide_is_braked_by_the_point_of_the_ellipse_against_it(angle):
    """F = -mu N (s_l, q^2 s_t) / |(s_l, q s_t)|: mu N along, q mu N across, and between them beside the slip."""
    a, q = math.radians(angle), MODULE.wheel_grain
    along, across = math.cos(a), -q * math.sin(a)
    size = math.hypot(along, across)
    f_l, f_t = -along / size, -q * across / size
    fx, fy = sliding(a).wheel_forces.sum(axis=0) / (1.2 * 55.0 * GRAVITY)
    assert fx == pytest.approx(math.cos(a) * f_l - math.sin(a) * f_t, abs=0.005)
    assert fy == pytest.approx(math.sin(a) * f_l + math.cos(a) * f_t, abs=0.005)


@given(
    grain=st.floats(0.5, 1.3),
    volts=st.tuples(*[st.floats(-12.0, 12.0)] * 4),
    steer=st.tuples(*[st.floats(-12.0, 12.0)] * 4),
    velocity=st.tuples(st.floats(-4.0, 4.0), st.floats(-4.0, 4.0), st.floats(-8.0, 8.0)),
)
def test_no_force_is_beyond_its_ellipse(grain, volts, steer, velocity):
    drive = SwerveDrive(SwerveConfig.square(0.527, replace(MODULE, wheel_grain=grain)))
    drive.set_volts(volts, steer)
    for _ in range(4):
        drive.step(STEP, velocity)  # one step of the loop: no mean of several directions
        for k, (fx, fy) in enumerate(drive.wheel_forces):
            c, s = drive.state.cos[k], drive.state.sin[k]
            along, across = c * fx + s * fy, (c * fy - s * fx) / grain
            assert math.hypot(along, across) <= 1.2 * drive.normal_loads[k] * (1.0 + 1e-9)


def test_a_tank_turns_more_easily_on_treads_with_grain():
    """Its wheels scrub across: q of the moment is left."""
    spins = []
    for grain in (1.0, 0.73):
        drive = TankDrive(TankConfig(wheel_grain=grain, dropped_center=False))
        chassis = PlanarChassis(drive)
        drive.set_volts(-8.0, 8.0)
        chassis.run(0.5)
        spins.append(chassis.omega)
    assert spins[1] > 1.05 * spins[0] > 0.5


def test_a_grain_without_sense_is_refused():
    for grain in (0.0, -1.0, math.nan, 3.0):
        with pytest.raises(ConfigError, match="wheel_grain"):
            replace(MODULE, wheel_grain=grain)
