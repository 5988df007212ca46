"""A motor behind current limits, gears and friction."""

from __future__ import annotations

import math

import pytest

from simcore.robot.dc_motor import motor
from simcore.robot.limited_motor import LOCKED, LimitedMotor, limited_volts, solve_shaft, solve_supply, torque_line


class TestSolution:
    M = LimitedMotor.of(motor("Kraken X60"), gearing=6.75, efficiency=0.9, friction_volts=0.1)

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


class TestLaw:
    """What a controller puts on a motor of 0.03 ohm at a given speed."""

    R, BUS, STATOR, SUPPLY = 0.03, 12.0, 60.0, 40.0

    def volts(self, wanted, emf):
        return limited_volts(wanted, emf, self.R, bus=self.BUS, stator_limit=self.STATOR, supply_limit=self.SUPPLY)

    @pytest.mark.parametrize("wanted", [-40.0, -12.0, -4.0, 0.0, 0.3, 7.0, 12.0, 40.0])
    @pytest.mark.parametrize("emf", [-11.0, -3.0, 0.0, 2.0, 9.5])
    def test_limits_hold_in_all_four_quadrants(self, wanted, emf):
        v = self.volts(wanted, emf)
        current = (v - emf) / self.R
        assert abs(current) <= self.STATOR * (1 + 1e-9)
        assert abs(v * current) <= self.SUPPLY * self.BUS * (1 + 1e-9)

    def test_a_request_within_the_limits_passes(self):
        assert self.volts(5.0, 4.5) == pytest.approx(5.0)

    def test_the_supply_limit_is_used_in_full(self):
        v = limited_volts(12.0, 6.0, self.R, bus=12.0, stator_limit=math.inf, supply_limit=40.0)
        assert v * (v - 6.0) / self.R == pytest.approx(480.0)
        back = limited_volts(4.0, 8.0, self.R, bus=12.0, stator_limit=math.inf, supply_limit=20.0)
        assert back * (back - 8.0) / self.R == pytest.approx(-240.0)
        assert back > 4.0, "less braking torque, not more"

    @pytest.mark.parametrize(("volts", "w"), [(12.0, 20.0), (3.0, 60.0), (-12.0, 10.0), (6.0, -30.0)])
    def test_the_torque_line_is_the_same_law(self, volts, w):
        """The line's current at the speed where it was taken, times the torque per current, less friction."""
        m = LimitedMotor.of(motor("Kraken X60"), gearing=6.75, efficiency=1.0)
        constants = (m.emf, m.resistance, m.torque_driving, m.torque_driven, m.friction)
        _, _, t0, t1 = torque_line(volts, 12.0, 0.0, w, 60.0, 40.0 * 12.0, m.conductance, constants)
        emf = m.emf * w
        v = limited_volts(volts, emf, m.resistance, bus=12.0, stator_limit=60.0, supply_limit=40.0)
        assert t0 - t1 * w == pytest.approx(m.torque_driving * (v - emf) * m.conductance)
