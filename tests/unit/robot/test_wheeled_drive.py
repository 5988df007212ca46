"""How much of the robot each wheel carries."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simcore.errors import ConfigError, NonFiniteError
from simcore.loop.robot_state import STEP
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.fixed_wheel_drive import TankDrive
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.swerve_drive import SwerveDrive
from simcore.robot.wheeled_drive import PlanarChassis, normal_loads
from simcore.units import GRAVITY

SQUARE = SwerveConfig.square(0.527, SwerveModuleConfig(x=0, y=0))


class TestLoads:
    LEVEL = (0.0, 0.0, -GRAVITY)

    def test_speeding_up_loads_the_rear(self):
        """m a h / wheelbase per axle."""
        loads = normal_loads(SQUARE, [True] * 4, self.LEVEL, (3.0, 0.0, 0.0))
        assert sum(loads[2:]) - sum(loads[:2]) == pytest.approx(2 * 55.0 * 3.0 * 0.2 / 0.527)

    def test_a_left_turn_loads_the_right(self):
        loads = normal_loads(SQUARE, [True] * 4, self.LEVEL, (0.0, 3.0, 0.0))
        assert loads[1] > loads[0]

    def test_nose_up_loads_the_rear(self):
        a = math.radians(15)
        loads = normal_loads(SQUARE, [True] * 4, (-GRAVITY * math.sin(a), 0.0, -GRAVITY * math.cos(a)))
        assert loads[2] > loads[0]

    def test_wheels_in_the_air_carry_nothing(self):
        loads = normal_loads(SQUARE, [True, True, False, True], self.LEVEL)
        assert loads[2] == 0.0
        assert sum(loads) == pytest.approx(55.0 * GRAVITY)
        assert normal_loads(SQUARE, [False] * 4, self.LEVEL) == [0.0] * 4
        assert normal_loads(SQUARE, [True] * 4, (0.0, 0.0, 0.0)) == [0.0] * 4

    def test_beyond_tipping_the_outer_wheels_carry_all(self):
        loads = normal_loads(SQUARE, [True] * 4, self.LEVEL, (20.0, 0.0, 0.0))
        assert loads[:2] == [0.0, 0.0]
        assert sum(loads) == pytest.approx(55.0 * GRAVITY)

    @pytest.mark.parametrize("bad", [math.nan, math.inf])
    def test_bad_accelerations_are_refused(self, bad):
        with pytest.raises(NonFiniteError, match="loads"):
            normal_loads(SQUARE, [True] * 4, self.LEVEL, (bad, 0.0, 0.0))

    def test_shares_follow_the_center_of_mass(self):
        loads = normal_loads(replace(SQUARE, center_of_mass=(0.1, 0.0, 0.2)), [True] * 4, self.LEVEL)
        assert sum(loads) == pytest.approx(55.0 * GRAVITY)
        assert np.average([m.x for m in SQUARE.modules], weights=loads) == pytest.approx(0.1)

    @pytest.mark.parametrize(("accel", "rear"), [(0.0, 0.0), (3.0, 1.0), (-3.0, 0.0)])
    def test_a_dropped_center_carries_all_with_the_end_that_it_leans_on(self, accel, rear):
        """m a h over half the wheelbase on the end behind, or before; nothing on the other."""
        tank = TankConfig()
        loads = normal_loads(tank, [True] * 6, self.LEVEL, (accel, 0.0, 0.0))
        front, middle, back = (loads[k] + loads[k + 3] for k in range(3))
        end = tank.mass * abs(accel) * tank.center_of_mass[2] / 0.28
        assert (front, back) == pytest.approx(((1.0 - rear) * end, rear * end), abs=1e-9)
        assert middle == pytest.approx(tank.mass * GRAVITY - end)

    def test_without_a_dropped_center_all_six_wheels_carry_alike(self):
        loads = normal_loads(TankConfig(dropped_center=False), [True] * 6, self.LEVEL)
        assert loads == pytest.approx([50.0 * GRAVITY / 6.0] * 6)

    def test_a_dropped_center_in_the_air_leaves_the_load_to_the_ends(self):
        loads = normal_loads(TankConfig(), [True, False, True] * 2, self.LEVEL)
        assert loads == pytest.approx([50.0 * GRAVITY / 4.0, 0.0, 50.0 * GRAVITY / 4.0] * 2)


class TestLag:
    """Loads from step to step of the loop: they follow what tires do to the chassis, of the step before."""

    LEVEL = (0.0, 0.0, -GRAVITY)
    LAG = 0.010
    BRAKED = SwerveModuleConfig(x=0, y=0, wheel_cof=0.6, rolling_resistance=0.0, drive_friction_volts=20.0)
    """Its wheels are held: they slide, with mu m g at any load and speed."""

    @classmethod
    def sliding(cls, vx, vy, *, cof=0.6, yaw=0.0) -> PlanarChassis:
        """A robot that slides over the field with held wheels."""
        module = replace(cls.BRAKED, wheel_cof=cof)
        # What lifted wheels leave unbalanced does not turn it.
        config = replace(SwerveConfig.square(0.527, module), yaw_inertia=1000.0)
        robot = PlanarChassis(SwerveDrive(config))
        robot.reset(yaw=yaw, vx=vx, vy=vy)
        return robot

    @staticmethod
    def to_the_rear(loads):
        return sum(loads[2:]) - sum(loads[:2])

    @pytest.mark.parametrize("h", [0.005, STEP, 0.00025])
    def test_loads_follow_the_tires_with_the_lag_at_any_step(self, h):
        """After n steps of the loop 2 m h_c / wheelbase times a (1 - exp(-t / lag)); a reading is a mean of them."""
        robot = self.sliding(6.0, 0.0)
        count = math.ceil(h / STEP - 1e-9)
        for k in range(round(0.02 / h)):
            robot.step(h)
            assert robot.ax == pytest.approx(-0.6 * GRAVITY)
            times = [(k + part / count) * h for part in range(count)]
            followed = np.mean([1.0 - math.exp(-t / self.LAG) for t in times])
            expected = -2 * 55.0 * 0.6 * GRAVITY * 0.2 / 0.527 * followed
            assert self.to_the_rear(robot.loads) == pytest.approx(expected, rel=1e-9, abs=1e-9)

    @pytest.mark.parametrize("turn", [10.0, -25.0])
    def test_what_was_transferred_stays_in_the_field_while_the_robot_turns(self, turn):
        """On ice: with what it has followed before, the only thing that is left to fade."""
        robot = self.sliding(0.0, 0.0, cof=1e-9)
        robot.reset(omega=turn)
        robot.drive.robot_record["followed"] = (3.0, 0.0, 0.0)
        for k in range(50):
            robot.step(STEP)
            left = 2 * 55.0 * 3.0 * 0.2 / 0.527 * math.exp(-(k + 1) * STEP / self.LAG)
            loads, turned = robot.loads, turn * k * STEP
            assert self.to_the_rear(loads) == pytest.approx(left * math.cos(turned), abs=1e-4)
            to_the_left = loads[0] + loads[2] - loads[1] - loads[3]
            assert to_the_left == pytest.approx(left * math.sin(turned), abs=1e-4)

    @pytest.mark.parametrize("way", [(4.0, 0.0), (2.4, -3.2), (0.0, 4.0)])
    @pytest.mark.parametrize("off", [(), (1,), (0, 1, 2, 3)])
    @pytest.mark.parametrize("cof", [0.6, 2.5])
    def test_at_last_they_are_those_of_the_acceleration(self, cof, off, way):
        """Also where a wheel is off the ground, or lifts, and in the air; they are late by a turn of omega lag."""
        robot = self.sliding(*way, cof=cof, yaw=0.3)
        down = [k not in off for k in range(4)]
        robot.drive.wheel_records["is_down"] = down
        robot.run(0.1, h=STEP)
        c, s = math.cos(robot.yaw), math.sin(robot.yaw)
        accel = (c * robot.ax + s * robot.ay, c * robot.ay - s * robot.ax, 0.0)
        assert math.hypot(*accel) == pytest.approx(cof * GRAVITY if any(down) else 0.0, rel=1e-3)
        wanted = normal_loads(robot.drive.robot, down, self.LEVEL, accel)
        late = 2 * 55.0 * cof * GRAVITY * 0.2 / 0.527 * abs(robot.omega) * self.LAG
        assert late < 1.0
        assert robot.loads == pytest.approx(wanted, abs=late + 0.03)  # and 0.1 s are 10 lags: exp(-10) is left
        robot.reset()
        robot.step(1e-9)
        assert robot.loads == pytest.approx(normal_loads(SQUARE, down, self.LEVEL), abs=1e-3)


# --- a drivetrain whose robot gets heavier, or moves its center of mass, while it drives ----------------------------


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
    force = 4 * 30.0 * CARRYING.drive_motor.kt * CARRYING.drive_gearing / CARRYING.wheel_radius
    accel = force / (mass + 4 * CARRYING.drive_inertia / CARRYING.wheel_radius**2)
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


# --- treads that hold less across than along: an ellipse of friction ------------------------------------------------


GRAINED = SwerveModuleConfig(x=0, y=0, wheel_grain=0.73, rolling_resistance=0.0)


def sliding(angle: float, module: SwerveModuleConfig = GRAINED) -> SwerveDrive:
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
def test_no_force_is_beyond_its_ellipse(grain, volts, steer, velocity):
    drive = SwerveDrive(SwerveConfig.square(0.527, replace(GRAINED, wheel_grain=grain)))
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
            replace(GRAINED, wheel_grain=grain)
