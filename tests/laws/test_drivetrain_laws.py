"""Laws that hold for any robot, command and seed."""

import logging
import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from simcore.robot.battery import Battery, BatteryConfig
from simcore.robot.dc_motor import MOTOR_NAMES, motor
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.fixed_wheel_drive import TankDrive
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.swerve_drive import SwerveDrive
from simcore.testing.benches import DriveBench

pytestmark = pytest.mark.engines("bullet")


@pytest.fixture(autouse=True, scope="module")
def _random_robots_are_unusual():
    log = logging.getLogger("simcore.robot")
    log.setLevel(logging.ERROR)
    yield
    log.setLevel(logging.NOTSET)


settings.register_profile("drive", suppress_health_check=[HealthCheck.too_slow], derandomize=True)
settings.load_profile("drive")

FAST_MOTORS = [n for n in MOTOR_NAMES if n != "Romi built-in"]


def log_floats(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(math.log(low), math.log(high)).map(math.exp)


@st.composite
def modules(draw: st.DrawFn, x: float, y: float) -> SwerveModuleConfig:
    limit = st.one_of(st.just(math.inf), st.floats(5.0, 200.0))
    return SwerveModuleConfig(
        x=x,
        y=y,
        drive_motor=motor(draw(st.sampled_from(FAST_MOTORS))),
        steer_motor=motor(draw(st.sampled_from(FAST_MOTORS))),
        drive_gearing=draw(st.floats(3.0, 12.0)),
        steer_gearing=draw(st.floats(7.0, 47.0)),
        coupling_ratio=draw(st.sampled_from([0.0, 3.57, -3.0])),
        wheel_radius=draw(st.floats(0.03, 0.08)),
        wheel_cof=draw(st.floats(0.5, 2.5)),
        wheel_inertia=draw(log_floats(1e-7, 1e-2)),
        steer_inertia=draw(log_floats(1e-9, 1e-1)),
        rolling_resistance=draw(st.floats(0.0, 0.05)),
        drive_friction_volts=draw(st.floats(0.0, 0.5)),
        steer_friction_volts=draw(st.floats(0.0, 0.5)),
        drive_efficiency=draw(st.floats(0.7, 1.0)),
        steer_efficiency=draw(st.floats(0.7, 1.0)),
        drive_stator_limit=draw(limit),
        drive_supply_limit=draw(limit),
        steer_stator_limit=draw(limit),
        steer_supply_limit=draw(limit),
        drive_brake=draw(st.booleans()),
    )


@st.composite
def robots(draw: st.DrawFn) -> SwerveConfig:
    """Draw a robot that stands on three to five modules and cannot tip by its own grip (mu h < b)."""
    count = draw(st.integers(3, 5))
    turns = [(k + draw(st.floats(-0.1, 0.1))) / count for k in range(count)]
    places = [(draw(st.floats(0.3, 0.4)) * math.cos(math.tau * t), 0.35 * math.sin(math.tau * t)) for t in turns]
    return SwerveConfig(
        modules=tuple(draw(modules(x, y)) for x, y in places),
        mass=draw(st.floats(10.0, 80.0)),
        yaw_inertia=draw(st.floats(0.5, 12.0)),
        center_of_mass=(draw(st.floats(-0.02, 0.02)), draw(st.floats(-0.02, 0.02)), draw(st.floats(0.0, 0.04))),
    )


batteries = st.one_of(
    st.none(), st.builds(BatteryConfig, resistance=st.floats(0.0, 0.05), initial_charge=st.floats(0.0, 1.0))
)
seeds = st.integers(0, 2**32 - 1)
steps = st.sampled_from([0.001, 0.004, 0.005, 0.02])


def command(drive: SwerveDrive, rng: np.random.Generator) -> None:
    n = len(drive.config.modules)
    kind = rng.integers(5)
    if kind == 0:
        drive.set_volts(rng.uniform(-13, 13, n), rng.uniform(-13, 13, n))
    elif kind == 1:
        drive.set_chassis_speeds(*rng.uniform(-6, 6, 3))
    elif kind == 2:
        drive.set_torque_currents(rng.uniform(-150, 150, n), rng.uniform(-3, 3, n))
    elif kind == 3:
        drive.set_duty_cycles(rng.uniform(-1, 1, n), rng.uniform(-0.1, 0.1, n))
    else:
        drive.stop()


def drive_around(config: SwerveConfig, battery: BatteryConfig | None, seed: int, h: float, n: int = 60):  # type: ignore[no-untyped-def]
    """Apply random commands from a random velocity; yield the drive and the bench after every step."""
    rng = np.random.default_rng(seed)
    drive = SwerveDrive(config, battery=Battery(battery) if battery else None)
    drive.reset(angles=rng.uniform(-4, 4, len(config.modules)))
    chassis = DriveBench(drive)
    vx, vy, omega = rng.uniform(-5, 5, 3)
    chassis.reset(vx=vx, vy=vy, omega=omega)
    for k in range(n):
        if k % 7 == 0:
            command(drive, rng)
        drive.other_current = float(rng.uniform(0, 60))
        chassis.step(h)
        yield drive, chassis


@given(robots(), batteries, seeds, steps)
@settings(max_examples=60)
def test_tire_forces_never_exceed_the_available_grip(config, battery, seed, h):
    for drive, chassis in drive_around(config, battery, seed, h):
        force = drive.wheel_forces
        grip = np.array([m.wheel_cof for m in config.modules]) * np.array(chassis.loads)
        assert (np.linalg.norm(force, axis=1) <= grip * (1 + 1e-9) + 1e-9).all()
        assert np.linalg.norm(force.sum(axis=0)) <= grip.sum() * (1 + 1e-9)


@given(robots(), batteries, seeds, steps)
@settings(max_examples=60)
def test_currents_stay_within_their_limits_in_all_four_quadrants(config, battery, seed, h):
    for drive, _ in drive_around(config, battery, seed, h):
        bus = drive.bus_voltage
        for readout, kind in ((drive.drive_motors, "drive"), (drive.steer_motors, "steer")):
            for m, v, i, supply in zip(config.modules, readout.volts, readout.current, readout.supply, strict=True):
                assert abs(i) <= getattr(m, f"{kind}_stator_limit") * (1 + 1e-9)
                limit = getattr(m, f"{kind}_supply_limit")
                if bus > 0.5:
                    assert abs(supply) <= limit * (1 + 1e-6)
                    assert supply == pytest.approx(v * i / bus, rel=1e-9, abs=1e-9)


@given(robots(), batteries, seeds)
@settings(max_examples=40)
def test_kinetic_energy_never_exceeds_the_electrical_energy_drawn(config, battery, seed):
    """The gain in kinetic energy is at most the energy drawn less the energy fed back.

    Where a datasheet's kt and kv disagree, electrical and mechanical power differ by their product, so the bound
    includes this factor.
    """
    rng = np.random.default_rng(seed)
    h = 0.004  # one inner step, so that volts times amps is the whole power
    drive = SwerveDrive(config, battery=Battery(battery) if battery else None)
    chassis = DriveBench(drive)
    given_energy = 0.0
    for k in range(80):
        if k % 7 == 0:
            command(drive, rng)
        chassis.step(h)
        for readout, kind in ((drive.drive_motors, "drive_motor"), (drive.steer_motors, "steer_motor")):
            for m, v, i in zip(config.modules, readout.volts, readout.current, strict=True):
                model = getattr(m, kind)
                product = model.kt * model.kv
                power = v * i
                given_energy += power * h * (max(1.0, product) if power > 0.0 else min(1.0, product))
        wheels = sum(
            0.5 * m.wheel_inertia * w * w for m, w in zip(config.modules, drive.state.wheel_speed, strict=True)
        )
        assert chassis.kinetic_energy + wheels <= given_energy * 1.01 + 0.05


@given(robots(), seeds, st.sampled_from([0.001, 0.004, 0.005, 0.02]))
@settings(max_examples=40)
def test_a_robot_in_neutral_never_speeds_up(config, seed, h):
    rng = np.random.default_rng(seed)
    drive = SwerveDrive(config)
    drive.reset(angles=rng.uniform(-4, 4, len(config.modules)))
    chassis = DriveBench(drive)
    vx, vy, omega = rng.uniform(-5, 5, 3)
    chassis.reset(vx=vx, vy=vy, omega=omega)
    own = sum(m.drive_inertia for m in config.modules)
    before = chassis.kinetic_energy
    for _ in range(40):
        chassis.step(h)
        turning = 0.5 * own * max(w * w for w in drive.state.wheel_speed)
        assert chassis.kinetic_energy <= before * (1 + 1e-9) + turning + 1e-9


@given(robots(), batteries, seeds)
@settings(max_examples=3)
def test_the_robot_state_stays_finite_through_a_minute_of_random_commands(config, battery, seed):
    *_, (drive, c) = drive_around(config, battery, seed, 0.02, n=3000)
    state = [c.x, c.y, c.yaw, c.vx, c.vy, c.omega, drive.bus_voltage, *drive.state.wheel_speed, *drive.steer_angles]
    assert all(map(math.isfinite, state))
    assert c.speed < 30.0


@given(robots(), seeds, st.floats(-math.pi, math.pi))
@settings(max_examples=30)
def test_rotating_the_field_rotates_the_run(config, seed, turn):
    rng = np.random.default_rng(seed)
    velocity = rng.uniform(-4, 4, 2)
    paths = []
    for yaw in (0.0, turn):
        rng = np.random.default_rng(seed + 1)
        drive = SwerveDrive(config)
        chassis = DriveBench(drive)
        c, s = math.cos(yaw), math.sin(yaw)
        chassis.reset(yaw=yaw, vx=c * velocity[0] - s * velocity[1], vy=s * velocity[0] + c * velocity[1])
        for k in range(40):
            if k % 10 == 0:
                command(drive, rng)
            chassis.step(0.005)
        turned = math.remainder(chassis.yaw - yaw - 1.0, math.tau)  # far from the wrap-around
        paths.append((c * chassis.x + s * chassis.y, c * chassis.y - s * chassis.x, turned))
    assert paths[0] == pytest.approx(paths[1], abs=1e-6)


@given(seeds)
@settings(max_examples=20)
def test_mirrored_commands_give_the_mirrored_run(seed):
    rng = np.random.default_rng(seed)
    config = SwerveConfig.square(0.5, SwerveModuleConfig(x=0, y=0))
    volts, steer = rng.uniform(-12, 12, 4), rng.uniform(-6, 6, 4)
    swap = [1, 0, 3, 2]
    ends = []
    for mirrored in (False, True):
        drive = SwerveDrive(config)
        chassis = DriveBench(drive)
        drive.set_volts(volts[swap] if mirrored else volts, -steer[swap] if mirrored else steer)
        chassis.run(0.5)
        sign = -1.0 if mirrored else 1.0
        ends.append((chassis.x, sign * chassis.y, sign * chassis.yaw))
    assert ends[0] == pytest.approx(ends[1], abs=1e-6)


@given(st.floats(-13, 13), st.floats(-13, 13), st.integers(2, 4), st.floats(0.3, 2.0), st.floats(5.0, 200.0), steps)
@settings(max_examples=30)
def test_a_tank_drive_keeps_within_its_grip_and_its_current_limit(left, right, wheels, tread, limit, h):
    xs = tuple(np.linspace(0.3, -0.3, wheels))
    drive = TankDrive(TankConfig(wheel_xs=xs, wheel_cof=tread, stator_limit=limit), battery=Battery())
    chassis = DriveBench(drive)
    chassis.reset(vx=2.0, vy=-1.0, omega=1.0)
    for k in range(60):
        drive.set_volts(left if k < 40 else -left, right)
        chassis.step(h)
        grip = tread * np.array(chassis.loads)
        assert (np.linalg.norm(drive.wheel_forces, axis=1) <= grip * (1 + 1e-9)).all()
        assert max(map(abs, drive.drive_motors.current)) <= limit * (1 + 1e-9)
        assert math.isfinite(chassis.x + chassis.y + chassis.yaw)
