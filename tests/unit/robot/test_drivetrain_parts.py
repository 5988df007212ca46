"""Motor table, electrical limits, tire law, loads, control, encoders, gyro: each part by itself."""

from __future__ import annotations

import logging
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from simcore.errors import ConfigError, NonFiniteError, UnknownNameError
from simcore.robot.cots import MODULES, TREADS, swerve_module, tread
from simcore.robot.electrical import LOCKED, ShaftMotor, bus_voltage, solve_shaft, solve_supply
from simcore.robot.encoders import EncoderCache
from simcore.robot.gyro import GYROS, Gyro, GyroConfig, gyro_config
from simcore.robot.module_targets import desaturate, module_targets, optimize
from simcore.robot.motor import MOTOR_NAMES, MotorModel, motor
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig, plate_inertia
from simcore.robot.tire import on_friction_circle, slip_scale, tire_force
from simcore.robot.wheel_loads import load_shares, normal_loads
from simcore.units import GRAVITY

SQUARE = SwerveConfig.square(0.527, SwerveModuleConfig(x=0, y=0))


class TestMotor:
    def test_table_is_all_of_wpilib(self):
        from wpimath.system.plant import DCMotor

        factories = {n for n in dir(DCMotor) if isinstance(getattr(DCMotor, n), object) and not n.startswith("_")}
        made = set()
        for name in factories:
            try:
                made.add(name) if isinstance(getattr(DCMotor, name)(1), DCMotor) else None
            except (TypeError, AttributeError):
                continue
        assert len(MOTOR_NAMES) == len(made - {"withReduction"})

    @pytest.mark.parametrize(
        ("name", "torque", "amps", "rpm"),
        [("Kraken X60", 7.09, 366, 6000), ("Kraken X60 FOC", 9.37, 483, 5800), ("NEO Vortex", 3.6, 211, 6784)],
    )
    def test_figures_are_the_datasheet(self, name, torque, amps, rpm):
        m = motor(name)
        assert (m.stall_torque, m.stall_current) == (torque, amps)
        assert m.free_speed * 60 / math.tau == pytest.approx(rpm)
        assert m.kt * amps == pytest.approx(torque)
        # At free speed and nominal voltage exactly the free current flows.
        assert (12.0 - m.free_speed / m.kv) / m.resistance == pytest.approx(m.free_current)

    def test_names_are_forgiving_and_errors_helpful(self):
        assert motor("kraken-x60") is motor("Kraken X60")
        with pytest.raises(UnknownNameError, match="Kraken X60"):
            motor("Kraken X6")

    @pytest.mark.parametrize(
        "wrong", [{"stall_current": math.inf}, {"stall_torque": 0.0}, {"nominal_voltage": 0.0}, {"free_current": 400.0}]
    )
    def test_a_motor_without_resistance_cannot_be_written(self, wrong):
        with pytest.raises(ConfigError):
            replace(motor("Kraken X60"), **wrong)


class TestElectrical:
    M = ShaftMotor.of(motor("Kraken X60"), gearing=6.75, efficiency=0.9, friction_volts=0.1)

    def solve(self, k, a, volts, limit=math.inf):
        m = self.M
        g = m.conductance
        return solve_shaft(k, a, volts * g, m.emf * g, limit, m.torque_driving, m.torque_driven, m.friction)

    @pytest.mark.parametrize("volts", [-12.0, -3.0, 0.0, 0.05, 5.0])
    @pytest.mark.parametrize("a", [-80.0, -1.0, 0.0, 2.0, 60.0])
    @pytest.mark.parametrize("limit", [10.0, math.inf])
    def test_solution_satisfies_its_own_equation(self, volts, a, limit):
        w, i, t0, t1 = self.solve(0.7, a, volts, limit)
        assert abs(i) <= limit
        if t1 == LOCKED:
            assert w == 0.0
        else:
            assert 0.7 * w == pytest.approx(a + t0 - t1 * w, abs=1e-9)
            f = self.M.torque_driving if i * w >= 0 else self.M.torque_driven
            assert a + f * i - math.copysign(self.M.friction, w) == pytest.approx(0.7 * w, abs=1e-9)

    def test_friction_voltage_just_turns_the_shaft(self):
        assert self.solve(1.0, 0.0, 0.0999)[0] == 0.0
        assert self.solve(1.0, 0.0, 0.1001)[0] > 0.0

    def test_friction_is_geared(self):
        m = motor("Kraken X60")
        assert self.M.friction == pytest.approx(6.75 * m.kt * 0.1 / m.resistance * 0.9)

    @pytest.mark.parametrize(("a", "volts"), [(0.0, 12.0), (300.0, 3.0), (-300.0, -3.0), (-300.0, 6.0)])
    def test_supply_limit_holds_drawing_and_feeding_back(self, a, volts):
        m = self.M
        w, i, *_ = self.solve(0.7, a, volts)
        power = (m.emf * w + i * m.resistance) * i
        limit = 0.5 * abs(power)
        constants = (m.emf, m.resistance, m.torque_driving, m.torque_driven, m.friction)
        w2, i2, *_ = solve_supply(0.7, a, i, power, math.inf, constants, 0.0, 0.0, limit)
        assert abs((m.emf * w2 + i2 * m.resistance) * i2) <= limit * (1 + 1e-9)

    def test_bus_voltage_of_four_stalled_krakens(self):
        """Motors at full duty are R/4: 13.5 V * (R/4) / (R/4 + 0.02)."""
        r4 = self.M.resistance / 4
        bus = bus_voltage(13.5, 13.5, 0.02, 0.0, [self.M] * 4, [12.0] * 4, [math.inf] * 4, [0.0] * 4)
        assert bus == pytest.approx(13.5 * r4 / (r4 + 0.02), abs=0.02)

    def test_bus_voltage_with_a_current_limit_is_constant_power(self):
        bus = bus_voltage(12.6, 12.6, 0.02, 10.0, [self.M] * 4, [12.0] * 4, [60.0] * 4, [3.0] * 4)
        power = 4 * 60.0 * (3.0 + 60.0 * self.M.resistance)
        assert bus == pytest.approx(12.6 - 0.02 * (10.0 + power / bus), abs=0.02)

    def test_dead_battery_gives_zero(self):
        assert bus_voltage(0.0, 0.0, 0.02, 0.0, [self.M], [12.0], [60.0], [0.0]) == 0.0


class TestTire:
    def test_linear_then_coulomb(self):
        slip = np.array([[0.01, 0.0], [3.0, 4.0], [0.0, 0.0]])
        force = tire_force(slip, np.full(3, 100.0), np.full(3, 0.02))
        assert force == pytest.approx(np.array([[50.0, 0.0], [60.0, 80.0], [0.0, 0.0]]))

    def test_circle_keeps_direction(self):
        force = on_friction_circle(np.array([[30.0, 40.0], [1.0, 0.0]]), np.array([10.0, 10.0]))
        assert force == pytest.approx(np.array([[6.0, 8.0], [1.0, 0.0]]))

    def test_scale_grows_with_speed(self):
        assert slip_scale(-2.0, 0.01, 0.002) == pytest.approx(0.022)


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
        shares = load_shares(replace(SQUARE, center_of_mass=(0.1, 0.0, 0.2)))
        assert shares.sum() == pytest.approx(1.0)
        assert (shares * [m.x for m in SQUARE.modules]).sum() == pytest.approx(0.1)


class TestControl:
    def test_optimize_turns_at_most_a_quarter(self):
        assert optimize(2.0, 3.0, 0.0) == pytest.approx((-2.0 * math.cos(3.0 - math.pi), 3.0 - math.pi))
        assert optimize(2.0, 0.3, 4 * math.pi) == pytest.approx((2.0 * math.cos(0.3), 0.3))

    def test_desaturate_keeps_ratios(self):
        assert desaturate([4.0, -8.0], 4.0) == [2.0, -4.0]
        assert desaturate([1.0], 4.0) == [1.0]

    def test_turning_on_the_spot(self):
        positions = [(0.3, 0.3), (-0.3, 0.3)]
        speeds, angles = module_targets(positions, 0.0, 0.0, 2.0, 5.0, [0.0, 0.0])
        assert speeds == pytest.approx([0.6 * math.sqrt(2)] * 2)
        assert angles == pytest.approx([math.radians(135), math.radians(-135)])

    def test_no_wish_keeps_the_angles(self):
        assert module_targets([(0.3, 0.3)], 0.0, 0.0, 0.0, 5.0, [1.2]) == ([0.0], [1.2])


class TestEncoders:
    def test_samples_lie_on_the_grid_and_on_the_line(self):
        cache = EncoderCache(1)
        t = angle = 0.0
        for _ in range(8):
            t += 0.0025
            angle += 10.0 * 0.0025
            cache.record(t, 0.0025, [angle], [10.0], [-angle], [-10.0])
        samples = cache.drain()
        assert samples.time == pytest.approx([0.004, 0.008, 0.012, 0.016, 0.020])
        assert samples.wheel_angle[:, 0] == pytest.approx(10.0 * samples.time)
        assert samples.steer_angle[:, 0] == pytest.approx(-10.0 * samples.time)
        assert cache.drain().time.shape == (0,)

    def test_forgotten_samples_are_counted(self):
        cache = EncoderCache(1, capacity=3)
        cache.record(0.04, 0.04, [0.0], [0.0], [0.0], [0.0])
        assert cache.dropped == 7
        assert len(cache.drain().time) == 3


class TestGyro:
    def run(self, config, seed, seconds=30.0, rate=0.0, dt=0.02):
        gyro = Gyro(config, np.random.default_rng(seed))
        yaw = 0.0
        for _ in range(round(seconds / dt)):
            yaw += rate * dt
            gyro.step(dt, math.remainder(yaw, math.tau), 0.0, 0.0, (0.0, 0.0, rate))
        return gyro, yaw

    def test_ideal_gyro_tells_the_truth_over_many_turns(self):
        gyro, yaw = self.run(gyro_config("ideal"), 1, rate=7.0)
        assert gyro.yaw == pytest.approx(yaw)
        assert gyro.rates == pytest.approx([0.0, 0.0, 7.0])

    @pytest.mark.parametrize("dt", [0.02, 0.1])
    def test_drift_is_its_name_whatever_the_step(self, dt):
        """The sample deviation of 200 runs is within 15 % (3 sigma) of the true one."""
        config = GyroConfig(drift_deg_per_30s=2.0)
        ends = [math.degrees(self.run(config, seed, dt=dt)[0].yaw) for seed in range(200)]
        assert np.std(ends) == pytest.approx(2.0, rel=0.15)

    def test_scale_error_is_its_name(self):
        config = GyroConfig(scale_error=0.01)
        ends = [
            self.run(config, seed, seconds=1.0, rate=math.tau, dt=0.05)[0].yaw / math.tau - 1 for seed in range(400)
        ]
        assert np.std(ends) == pytest.approx(0.01, rel=0.11)

    def test_rate_noise_is_its_name(self):
        config = GyroConfig(rate_noise=0.02)
        gyro = Gyro(config, np.random.default_rng(3))
        rates = []
        for _ in range(2000):
            gyro.step(0.004, 0.0, 0.0, 0.0, (0.0, 0.0, 5.0))
            rates.append(gyro.rates[2])
        assert np.mean(rates) == pytest.approx(5.0, abs=0.01)
        assert np.std(rates) == pytest.approx(0.1, rel=0.05)

    def test_impact_jump_is_its_name(self):
        config = GyroConfig(impact_deg=1.0)
        jumps = []
        for seed in range(400):
            gyro = Gyro(config, np.random.default_rng(seed))
            gyro.step(0.004, 0.0, 0.0, 0.0, (0.0, 0.0, 0.0))
            gyro.step(0.004, 0.0, 0.0, 0.0, (0.0, 0.0, 2.0))  # 500 rad/s^2
            jumps.append(math.degrees(gyro.yaw))
        assert np.std(jumps) == pytest.approx(1.0, rel=0.11)

    def test_equal_seeds_read_the_same_and_samples_come_at_250_hz(self):
        a, b = (self.run(GYROS["pigeon2"], 5, seconds=0.2, rate=1.0)[0] for _ in range(2))
        assert a.yaw == b.yaw
        times, yaws = a.drain()
        assert np.diff(times) == pytest.approx(0.004)
        assert len(times) == 50
        assert yaws[-1] == pytest.approx(a.yaw)

    def test_set_yaw_moves_the_reading_only(self):
        gyro, _ = self.run(gyro_config("ideal"), 1, seconds=0.1, rate=1.0)
        gyro.set_yaw(2.0)
        gyro.step(0.02, 0.12, 0.0, 0.0, (0.0, 0.0, 1.0))
        assert gyro.yaw == pytest.approx(2.02)

    def test_bad_input(self):
        gyro = Gyro(GyroConfig(), np.random.default_rng(0))
        with pytest.raises(NonFiniteError, match="gyro"):
            gyro.step(0.02, math.nan, 0.0, 0.0, (0.0, 0.0, 0.0))
        with pytest.raises(UnknownNameError, match="pigeon2"):
            gyro_config("pidgeon2")
        with pytest.raises(ConfigError, match="drift"):
            GyroConfig(drift_deg_per_30s=-1.0)


class TestConfig:
    def test_unusual_values_warn_once_and_go_on(self, caplog):
        with caplog.at_level(logging.WARNING):
            SwerveConfig.square(0.5, SwerveModuleConfig(x=0, y=0, tread=3.5), mass=95.0)
        assert sum("tread" in r.message for r in caplog.records) == 1
        assert sum("mass" in r.message for r in caplog.records) == 1

    @pytest.mark.parametrize(
        "wrong",
        [
            {"wheel_radius": 0.0},
            {"drive_gearing": -6.75},
            {"drive_efficiency": 1.2},
            {"tread": -1.0},
            {"x": math.nan},
            {"steer_inertia": 0.0},
            {"drive_stator_limit": -1.0},
            {"drive_supply_limit": math.nan},
            {"coupling_ratio": 30.0},
        ],
    )
    def test_impossible_modules_are_refused_by_name(self, wrong):
        with pytest.raises(ConfigError, match=next(iter(wrong))):
            SwerveModuleConfig(**{"x": 0.2, "y": 0.2, "name": "front left", **wrong})

    @pytest.mark.parametrize(
        "wrong", [{"modules": ()}, {"mass": 0.0}, {"yaw_inertia": math.inf}, {"center_of_mass": (0.0, 0.0)}]
    )
    def test_impossible_robots_are_refused(self, wrong):
        with pytest.raises(ConfigError, match=next(iter(wrong))):
            replace(SQUARE, **wrong)

    def test_plate(self):
        assert plate_inertia(55.0, 0.8, 0.8) == pytest.approx(5.87, abs=0.01)

    def test_catalogue_builds(self):
        for name, product in MODULES.items():
            for gearing in product.drive_gearings:
                assert swerve_module(name, gearing=gearing).drive_gearing == gearing
        assert len(MODULES) >= 11
        assert tread("VEX Grip V2") == TREADS["VEX Grip V2"] == 1.916
        with pytest.raises(ConfigError, match="not sold with"):
            swerve_module("SDS MK4i", gearing=9.0)
        with pytest.raises(UnknownNameError, match="MK4i"):
            swerve_module("SDS MK4j", gearing=6.75)

    def test_from_ctre_by_attribute_names(self):
        limits = SimpleNamespace(
            stator_current_limit=120.0,
            stator_current_limit_enable=True,
            supply_current_limit=70.0,
            supply_current_limit_enable=True,
        )
        constants = SimpleNamespace(
            location_x=0.25,
            location_y=-0.25,
            drive_motor_gear_ratio=6.746,
            steer_motor_gear_ratio=21.43,
            coupling_gear_ratio=3.57,
            wheel_radius=0.0508,
            slip_current=90.0,
            drive_motor_initial_configs=SimpleNamespace(current_limits=limits),
            steer_motor_initial_configs=None,
            steer_inertia=0.01,
        )
        config = SwerveConfig.from_ctre([constants] * 4, mass=50.0)
        m = config.modules[0]
        assert (m.x, m.y, m.drive_gearing, m.coupling_ratio) == (0.25, -0.25, 6.746, 3.57)
        assert (m.drive_stator_limit, m.drive_supply_limit, m.steer_stator_limit) == (90.0, 70.0, math.inf)
        assert m.drive_motor is motor("Kraken X60 FOC")
        assert m.steer_inertia == 0.004
        del constants.wheel_radius
        with pytest.raises(ConfigError, match=r"module 0.*wheel_radius"):
            SwerveConfig.from_ctre([constants])

    def test_model_is_frozen(self):
        with pytest.raises(AttributeError):
            SQUARE.mass = 3.0  # type: ignore[misc]
        assert isinstance(motor("NEO"), MotorModel)
