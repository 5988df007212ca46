"""Motor with current limits, gears and friction."""

import math

import pytest
from each_case import each

from simcore.loop.motor import (
    LOCKED,
    end_weight,
    line_in_force,
    solve_limited,
    solve_shaft,
    supply_line,
    torque_line,
    within,
)
from simcore.robot.dc_motor import motor
from simcore.robot.wheel_config import LimitedMotor


class TestSolution:
    M = LimitedMotor.of(motor("Kraken X60"), gearing=6.75, efficiency=0.9, friction_volts=0.1)

    def solve(self, k, a, volts, limit=math.inf):
        m = self.M
        g = m.conductance
        return solve_shaft(k, a, volts * g, m.emf * g, limit, m.torque_driving, m.torque_driven, m.friction)

    @each("volts", [-12.0, -3.0, 0.0, 0.05, 5.0])
    @each("a", [-80.0, -1.0, 0.0, 2.0, 60.0])
    @each("limit", [10.0, math.inf])
    def test_the_solved_speed_and_current_satisfy_the_shaft_equation(self, volts, a, limit):
        w, i, t0, t1 = self.solve(0.7, a, volts, limit)
        assert abs(i) <= limit
        if t1 == LOCKED:
            assert w == 0.0
        else:
            assert 0.7 * w == pytest.approx(a + t0 - t1 * w, abs=1e-9)
            f = self.M.torque_driving if i * w >= 0 else self.M.torque_driven
            assert a + f * i - math.copysign(self.M.friction, w) == pytest.approx(0.7 * w, abs=1e-9)

    def test_the_friction_voltage_just_turns_the_shaft(self):
        assert self.solve(1.0, 0.0, 0.0999)[0] == 0.0
        assert self.solve(1.0, 0.0, 0.1001)[0] > 0.0

    def test_friction_torque_includes_the_gearing(self):
        m = motor("Kraken X60")
        assert self.M.friction == pytest.approx(6.75 * m.kt * 0.1 / m.resistance * 0.9)

    @each(("a", "volts"), [(0.0, 12.0), (300.0, 3.0), (-300.0, -3.0), (-300.0, 6.0)])
    def test_the_supply_limit_holds_while_drawing_and_while_feeding_back(self, a, volts):
        """The limit is half of the unlimited power; the limited current also satisfies the shaft's equation."""
        m = self.M
        w, i, *_ = self.solve(0.7, a, volts)
        limit = 0.5 * abs((m.emf * w + i * m.resistance) * i)
        constants = (m.emf, m.resistance, m.torque_driving, m.torque_driven, m.friction)
        i0, i1 = volts * m.conductance, m.emf * m.conductance
        w2, i2, at, *_ = solve_limited(0.7, a, i0, i1, math.inf, *constants, 0.0, 0.0, limit)
        assert at == pytest.approx(m.emf * w2 + i2 * m.resistance, rel=1e-12)
        assert abs(at * i2) <= limit * (1 + 1e-9)
        f = m.torque_driving if i2 * w2 >= 0 else m.torque_driven
        assert a + f * i2 - math.copysign(m.friction, w2) == pytest.approx(0.7 * w2, abs=1e-9)


class TestLaw:
    """Output of a controller on a motor of 0.03 ohm at a given speed."""

    R, BUS, STATOR, SUPPLY = 0.03, 12.0, 60.0, 40.0
    EMF = 0.1
    HEAVY = 1e9
    """Inertia of a shaft that keeps its speed within 1e-6 rad/s [N m s]."""

    def at_speed(self, wanted, emf, *, stator=STATOR, supply=SUPPLY):
        """Return voltage and current."""
        volts, resistance = line_in_force(wanted, self.BUS, emf, stator, self.R, self.R)
        w = emf / self.EMF
        _, current, at, _, _ = solve_limited(
            *(self.HEAVY, self.HEAVY * w, volts / resistance, self.EMF / resistance, stator),
            *(self.EMF, resistance, 1.0, 1.0, 0.0, 0.0, w, supply * self.BUS),
        )
        return at, current

    @each("wanted", [-40.0, -12.0, -4.0, 0.0, 0.3, 7.0, 12.0, 40.0])
    @each("emf", [-11.0, -3.0, 0.0, 2.0, 9.5])
    def test_current_limits_hold_in_all_four_quadrants(self, wanted, emf):
        v, current = self.at_speed(wanted, emf)
        assert v == pytest.approx(emf + current * self.R, abs=1e-6)
        assert abs(current) <= self.STATOR * (1 + 1e-9)
        assert abs(v * current) <= self.SUPPLY * self.BUS * (1 + 1e-9)

    def test_the_supply_limit_is_used_in_full(self):
        v, current = self.at_speed(12.0, 6.0, stator=math.inf)
        assert v * current == pytest.approx(480.0) and current == pytest.approx((v - 6.0) / self.R)
        back, current = self.at_speed(4.0, 8.0, stator=math.inf, supply=20.0)
        assert back * current == pytest.approx(-240.0) and current == pytest.approx((back - 8.0) / self.R)
        assert back > 4.0, "less braking torque, not more"

    @each(("wanted", "emf"), [(12.0, 2.0), (3.0, 6.0), (-12.0, 1.0), (6.0, -3.0), (12.0, 11.5)])
    def test_the_torque_line_agrees_with_the_motor_current_at_its_speed(self, wanted, emf):
        """At the speed at which the line was taken, its torque is the motor current times the torque per current."""
        w = emf / self.EMF
        *_, t0, t1 = torque_line(
            *(False, wanted, self.BUS, 0.0, w, self.STATOR, self.SUPPLY * self.BUS),
            *(self.EMF, self.R, 0.7, 0.7, 0.0),
        )
        assert t0 - t1 * w == pytest.approx(0.7 * self.at_speed(wanted, emf)[1])

    def test_at_an_open_circuit_only_friction_acts_on_the_shaft(self):
        for w, torque in ((50.0, -0.4), (-50.0, 0.4)):
            assert torque_line(True, 9.0, 12.0, 0.0, w, 60.0, 480.0, 0.1, 0.03, 0.7, 0.8, 0.4) == (0, 0, torque, 0)
        assert torque_line(True, 9.0, 12.0, 0.0, 0.0, 60.0, 480.0, 0.1, 0.03, 0.7, 0.8, 0.4)[3] == LOCKED

    @pytest.mark.parametrize("current", [50.0, -50.0])
    def test_the_line_of_a_supply_limit_touches_its_curve_from_below(self, current):
        """(e + I R) I = P at the speed at which it was taken, and less at any other speed."""
        i0, i1 = supply_line(
            math.copysign(4.0, current), 0.1, math.copysign(40.0, current), self.R, 300.0, current, 1.0
        )
        assert i1 > 0.0
        for speed in (5.0, 20.0, 35.0, 40.0, 45.0, 80.0):
            w = math.copysign(speed, current)
            amps = i0 - i1 * w
            power = (0.1 * w + amps * self.R) * amps
            assert amps * current > 0.0
            assert power == pytest.approx(300.0) if speed == 40.0 else power < 300.0


@each("z", [1e-6, 9.99e-4, 1.01e-3, 0.1, 1.0, 10.0, 500.0])
def test_the_end_weight_makes_a_step_with_back_emf_exact(z):
    """(w1 - w0) / h = -rate (w0 + weight (w1 - w0)) gives w1 = w0 exp(-rate h)."""
    weight = end_weight(0.001, z / 0.001)
    assert 0.5 <= weight < 1.0
    assert (1.0 - z * (1.0 - weight)) / (1.0 + z * weight) == pytest.approx(math.exp(-z), rel=1e-9, abs=1e-12)


def test_the_function_within_clamps_a_value_to_the_nearest_allowed_number():
    assert [within(value, 2.0) for value in (-3.0, -2.0, 0.5, 2.5)] == [-2.0, -2.0, 0.5, 2.0]
    assert within(1e300, math.inf) == 1e300
