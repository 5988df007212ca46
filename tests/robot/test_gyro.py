"""The errors of a gyro have their stated sizes."""

import math

import numpy as np
import pytest

from simcore.errors import ConfigError, NonFiniteError, UnknownNameError
from simcore.robot.gyro import GYROS, Gyro, GyroConfig, gyro_config


class TestGyro:
    def run(self, config, seed, seconds=30.0, rate=0.0, dt=0.02):
        gyro = Gyro(config, np.random.default_rng(seed))
        yaw = 0.0
        for _ in range(round(seconds / dt)):
            yaw += rate * dt
            gyro.step(dt, math.remainder(yaw, math.tau), 0.0, 0.0, (0.0, 0.0, rate))
        return gyro, yaw

    def test_an_ideal_gyro_is_exact_over_many_turns(self):
        gyro, yaw = self.run(gyro_config("ideal"), 1, rate=7.0)
        assert gyro.yaw == pytest.approx(yaw)
        assert gyro.rates == pytest.approx([0.0, 0.0, 7.0])

    @pytest.mark.parametrize("dt", [0.02, 0.1])
    def test_the_drift_after_30_s_has_its_stated_deviation_for_any_step(self, dt):
        """The sample deviation of 200 runs is within 15 % (3 sigma) of the true one."""
        config = GyroConfig(drift_deg_per_minute=4.0)
        ends = [math.degrees(self.run(config, seed, dt=dt)[0].yaw) for seed in range(200)]
        assert np.std(ends) == pytest.approx(2.0, rel=0.15)

    def test_the_drift_is_a_constant_rate_and_not_a_random_walk(self):
        config = GyroConfig(drift_deg_per_minute=4.0)
        half, whole = (self.run(config, 3, seconds=s)[0].yaw for s in (15.0, 30.0))
        assert half != 0.0 and whole == pytest.approx(2.0 * half)

    def test_the_bias_is_the_configured_rate(self):
        gyro = Gyro(GyroConfig(bias_dps=6.0), np.random.default_rng(0))
        for _ in range(50):
            gyro.step(0.02, 0.0, 0.0, 0.0, (0.0, 0.0, 0.0))
        assert math.degrees(gyro.yaw) == pytest.approx(6.0)
        assert np.degrees(gyro.rates) == pytest.approx((0.0, 0.0, 6.0))

    def test_the_scale_error_has_its_stated_size(self):
        config = GyroConfig(scale_error=0.01)
        ends = [
            self.run(config, seed, seconds=1.0, rate=math.tau, dt=0.05)[0].yaw / math.tau - 1 for seed in range(400)
        ]
        assert np.std(ends) == pytest.approx(0.01, rel=0.11)

    def test_the_rate_noise_has_its_stated_size(self):
        config = GyroConfig(rate_noise=0.02)
        gyro = Gyro(config, np.random.default_rng(3))
        rates = []
        for _ in range(2000):
            gyro.step(0.004, 0.0, 0.0, 0.0, (0.0, 0.0, 5.0))
            rates.append(gyro.rates[2])
        assert np.mean(rates) == pytest.approx(5.0, abs=0.01)
        assert np.std(rates) == pytest.approx(0.1, rel=0.05)

    def test_an_impact_jump_has_its_stated_size(self):
        config = GyroConfig(impact_deg=1.0)
        jumps = []
        for seed in range(400):
            gyro = Gyro(config, np.random.default_rng(seed))
            gyro.step(0.004, 0.0, 0.0, 0.0, (0.0, 0.0, 0.0))
            gyro.step(0.004, 0.0, 0.0, 0.0, (0.0, 0.0, 2.0))  # 500 rad/s^2
            jumps.append(math.degrees(gyro.yaw))
        assert np.std(jumps) == pytest.approx(1.0, rel=0.11)

    def test_gyros_with_equal_seeds_have_equal_readings(self):
        a, b = (self.run(GYROS["pigeon2"], 5, seconds=0.2, rate=1.0)[0] for _ in range(2))
        assert a.yaw == b.yaw

    def test_set_yaw_changes_only_the_reading(self):
        gyro, _ = self.run(gyro_config("ideal"), 1, seconds=0.1, rate=1.0)
        gyro.set_yaw(2.0)
        gyro.step(0.02, 0.12, 0.0, 0.0, (0.0, 0.0, 1.0))
        assert gyro.yaw == pytest.approx(2.02)

    def test_invalid_gyro_values_are_refused(self):
        gyro = Gyro(GyroConfig(), np.random.default_rng(0))
        with pytest.raises(NonFiniteError, match="gyro"):
            gyro.step(0.02, math.nan, 0.0, 0.0, (0.0, 0.0, 0.0))
        with pytest.raises(UnknownNameError, match="pigeon2"):
            gyro_config("pidgeon2")
        with pytest.raises(ConfigError, match="drift"):
            GyroConfig(drift_deg_per_minute=-1.0)
