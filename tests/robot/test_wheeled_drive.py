"""Loads of the wheels, changes of mass, and friction of the tires."""

import math
from dataclasses import replace

import numpy as np
import pytest
from each_case import each
from hypothesis import given
from hypothesis import strategies as st

from simcore.errors import ConfigError, NonFiniteError
from simcore.loop.robot_state import STEP
from simcore.robot.chassis_config import MassDistribution
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.fixed_wheel_drive import TankDrive
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.swerve_drive import SwerveDrive
from simcore.robot.wheeled_drive import static_loads
from simcore.testing.benches import DriveBench, hold
from simcore.units import GRAVITY

SQUARE = SwerveConfig.square(0.527, SwerveModuleConfig(x=0, y=0))


def test_the_loads_at_rest_follow_the_center_of_mass():
    loads = static_loads(replace(SQUARE, center_of_mass=(0.1, 0.0, 0.2)))
    assert sum(loads) == pytest.approx(55.0 * GRAVITY)
    assert np.average([m.x for m in SQUARE.modules], weights=loads) == pytest.approx(0.1)


@each(("ahead", "end"), [(0.0, 0.0), (0.07, 0.25), (-0.07, 0.25)])
def test_the_middle_wheels_and_the_end_toward_the_center_of_mass_carry_all_the_load(ahead, end):
    """The share of an end is the center of mass's distance ahead over the distance to that end, 0.28 m."""
    tank = replace(TankConfig(), center_of_mass=(ahead, 0.0, 0.2))
    loads = static_loads(tank)
    front, middle, back = (loads[k] + loads[k + 3] for k in range(3))
    weight = tank.mass * GRAVITY
    assert (front, middle, back) == pytest.approx(
        (end * weight * (ahead > 0.0), (1.0 - end) * weight, end * weight * (ahead < 0.0)), abs=1e-9
    )


def test_without_a_dropped_center_all_six_wheels_carry_the_same_load():
    assert static_loads(TankConfig(dropped_center=False)) == pytest.approx([50.0 * GRAVITY / 6.0] * 6)


# --- a drivetrain whose robot gets heavier, or moves its center of mass, while it drives ------------------------------


CARRYING = SwerveModuleConfig(
    x=0, y=0, drive_friction_volts=0.0, drive_efficiency=1.0, rolling_resistance=0.0, drive_stator_limit=math.inf
)
HEAVIER = (67.0, 7.0, (0.05, -0.04, 0.35))


def swerve(config: SwerveConfig | None = None) -> SwerveDrive:
    drive = SwerveDrive(config or SwerveConfig.square(0.527, CARRYING))
    drive.set_volts([4.0, 3.0, 5.0, 4.0], [1.0, 0.0, 0.0, 0.5])
    return drive


def tank(config: TankConfig | None = None) -> TankDrive:
    drive = TankDrive(config or TankConfig())
    drive.set_volts(5.0, 3.0)
    return drive


@pytest.mark.parametrize("make", [swerve, tank])
def test_a_robot_with_a_changed_mass_moves_like_a_robot_built_with_it(make):
    """The test compares paths, which depend on mass, inertia, lever arms and wheel loads."""
    told = make()
    told.set_mass_properties(*HEAVIER)
    mass, yaw_inertia, center = HEAVIER
    built = make(replace(told.config, mass=mass, yaw_inertia=yaw_inertia, center_of_mass=center))
    assert told.robot.positions == built.config.positions
    paths = []
    for drive in (told, built):
        chassis = DriveBench(drive)
        chassis.run(0.5)
        paths.append((chassis.x, chassis.y, chassis.yaw, chassis.vx, chassis.vy, chassis.omega, *chassis.loads))
    assert paths[0] == pytest.approx(paths[1], rel=1e-9, abs=1e-9)
    assert abs(paths[0][0]) > 0.1


@each("extra", [0.0, 10.75, 40.0])
def test_acceleration_falls_as_the_mass_grows(extra):
    """a = F / (m + 4 J / r^2) at a fixed motor current; the tires' slip is 1 % of the speed at full grip."""
    drive = swerve()
    drive.set_torque_currents([30.0] * 4, [0.0] * 4)
    mass = 55.0 + extra
    chassis = DriveBench(drive)
    chassis.run(0.1)
    body = chassis.chassis
    body.set_mass(MassDistribution(mass, (0.0, 0.0, 0.2), (4.0, 4.0, 5.87 * mass / 55.0)), body.vel, body.rate)
    before = chassis.vx
    chassis.run(0.1)
    force = 4 * 30.0 * CARRYING.drive_motor.kt * CARRYING.drive_gearing / CARRYING.wheel_radius
    accel = force / (mass + 4 * CARRYING.drive_inertia / CARRYING.wheel_radius**2)
    assert (chassis.vx - before) / 0.1 == pytest.approx(accel, rel=0.01)
    assert sum(drive.normal_loads) == pytest.approx(mass * GRAVITY, rel=1e-3)


@each("bad", [(0.0, 5.0, (0.0, 0.0, 0.2)), (50.0, -1.0, (0.0, 0.0, 0.2)), (50.0, 5.0, (math.nan,) * 3)])
def test_an_invalid_mass_is_refused_and_changes_nothing(bad):
    drive = swerve()
    with pytest.raises(NonFiniteError, match="mass properties"):
        drive.set_mass_properties(*bad)
    assert drive.robot == drive.config


# --- treads that hold less across than along: an ellipse of friction --------------------------------------------------


GRAINED = SwerveModuleConfig(x=0, y=0, wheel_grain=0.73, rolling_resistance=0.0)


def sliding(angle: float, module: SwerveModuleConfig = GRAINED) -> SwerveDrive:
    """Return a drive with locked wheels, turned by an angle [rad], that slides forward at 3 m/s; loads are constant."""
    drive = SwerveDrive(SwerveConfig.square(0.527, module, height=0.0))
    drive.reset(angles=[angle] * 4)
    drive.state.wheel_speed[:] = [0.0] * 4
    chassis = DriveBench(drive)
    chassis.reset(vx=3.0)
    for _ in range(4):
        drive.state.wheel_speed[:] = [0.0] * 4
        chassis.step(2e-5)  # within this time, a wheel that the carpet turns gains 0.1 % of the slip
    return drive


@each("angle", [0.0, 90.0, 30.0, -45.0])
def test_a_sliding_tire_brakes_with_the_opposite_point_of_its_friction_ellipse(angle):
    """F = -mu N (s_l, q^2 s_t) / |(s_l, q s_t)|: mu N along, q mu N across; between them, it is not along the slip."""
    a, q = math.radians(angle), GRAINED.wheel_grain
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
def test_no_tire_force_exceeds_its_friction_ellipse(grain, volts, steer, velocity):
    drive = SwerveDrive(SwerveConfig.square(0.527, replace(GRAINED, wheel_grain=grain)))
    drive.set_volts(volts, steer)
    for _ in range(4):
        hold(drive, STEP, velocity)  # one step of the loop: no mean over several directions
        for k, (fx, fy) in enumerate(drive.wheel_forces):
            c, s = drive.state.cos[k], drive.state.sin[k]
            along, across = c * fx + s * fy, (c * fy - s * fx) / grain
            assert math.hypot(along, across) <= 1.2 * drive.normal_loads[k] * (1.0 + 1e-9)


def test_a_tank_drive_turns_more_easily_on_treads_with_grain():
    """The wheels scrub sideways, which leaves q of the moment."""
    spins = []
    for grain in (1.0, 0.73):
        drive = TankDrive(TankConfig(wheel_grain=grain, dropped_center=False))
        chassis = DriveBench(drive)
        drive.set_volts(-8.0, 8.0)
        chassis.run(0.5)
        spins.append(chassis.omega)
    assert spins[1] > 1.05 * spins[0] > 0.5


def test_an_invalid_grain_is_refused():
    for grain in (0.0, -1.0, math.nan, 3.0):
        with pytest.raises(ConfigError, match="wheel_grain"):
            replace(GRAINED, wheel_grain=grain)
