"""Motion profiles stay within their limits and reach goals from any state, whole or in parts."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("phoenix6", reason="needs phoenix6: pip install .[phoenix6]")

from simcore.robotcode.emulator.control_laws import Expo, SCurve, VelocityRamp

number = st.floats(-20.0, 20.0)
DT = 0.005


@given(start=number, v0=st.floats(-8.0, 8.0), goals=st.lists(number, min_size=1, max_size=3),
       cruise=st.floats(1.0, 10.0), a=st.floats(2.0, 50.0), jerk=st.sampled_from([0.0, 20.0, 400.0]))  # fmt: skip
def test_a_profile_reaches_its_last_goal_within_its_limits(start, v0, goals, cruise, a, jerk):
    profile = SCurve()
    profile.start(start, v0)
    last = v0
    for goal in goals:
        for _ in range(60):
            profile.advance(goal, cruise, a, jerk, DT)
            assert abs(profile.v) <= max(cruise, abs(v0)) + 1.3 * (a * a / jerk if jerk else 0.0) + 1e-6
            assert abs(profile.v - last) <= a * DT * (1.0 + 1e-6) + 1e-9
            last = profile.v
    for _ in range(4000):
        profile.advance(goals[-1], cruise, a, jerk, 0.02)
    assert profile.done
    assert (profile.p, profile.v) == (goals[-1], 0.0)


def test_a_trapezoid_takes_the_textbook_time():
    """d / v + v / a."""
    profile = SCurve()
    steps = 0
    while steps == 0 or not profile.done:
        profile.advance(10.0, 4.0, 8.0, 0.0, 0.001)
        steps += 1
    assert steps * 0.001 == pytest.approx(10.0 / 4.0 + 4.0 / 8.0, abs=0.0011)


def test_an_s_curve_takes_the_textbook_time():
    """d / v + v / a + a / j."""
    profile = SCurve()
    steps = 0
    while steps == 0 or not profile.done:
        profile.advance(10.0, 4.0, 8.0, 40.0, 0.001)
        steps += 1
    assert steps * 0.001 == pytest.approx(10.0 / 4.0 + 4.0 / 8.0 + 8.0 / 40.0, abs=0.0011)


@given(goal=st.floats(-50.0, 50.0), v0=st.floats(-60.0, 60.0), kv=st.floats(0.1, 1.0), ka=st.floats(0.01, 1.0),
       cruise=st.sampled_from([0.0, 5.0, 30.0]))  # fmt: skip
def test_an_exponential_profile_stays_within_the_voltage_of_its_motor(goal, v0, kv, ka, cruise):
    """|kV v + kA a| <= 12 V all along, except while it brakes from above the cruise velocity."""
    profile = Expo()
    v0 = max(min(v0, 11.0 / kv), -11.0 / kv)
    profile.start(0.0, v0)
    for _ in range(200):
        profile.advance(goal, kv, ka, cruise, DT)
        assert abs(kv * profile.v + ka * profile.acc) <= 12.0 + 1e-6
        if cruise:
            assert abs(profile.v) <= max(cruise, abs(v0)) + 1e-6
    for _ in range(40000):
        profile.advance(goal, kv, ka, cruise, 0.02)
        if profile.done:
            break
    assert (profile.p, profile.v) == (goal, 0.0)


def test_an_exponential_profile_accelerates_like_its_motor_at_12_volts():
    """v = 12 / kV (1 - exp(-t kV / kA))."""
    profile = Expo()
    for k in range(1, 101):
        profile.advance(1000.0, 0.12, 0.1, 0.0, DT)
        assert profile.v == pytest.approx(100.0 * -math.expm1(-1.2 * k * DT), rel=1e-6)


@given(goals=st.lists(number, min_size=1, max_size=3), a=st.floats(1.0, 100.0), jerk=st.sampled_from([0.0, 50.0]))
def test_a_velocity_ramp_reaches_its_goal(goals, a, jerk):
    ramp = VelocityRamp()
    for goal in goals:
        for _ in range(3000):
            ramp.advance(goal, a, jerk, 0.02)
            assert abs(ramp.acc) <= a + 1e-9
        assert (ramp.v, ramp.acc) == (goal, 0.0)


@given(goal=number, parts=st.integers(2, 5))
def test_several_short_steps_equal_one_long_step(goal, parts):
    whole, pieces = SCurve(), SCurve()
    for _ in range(100):
        whole.advance(goal, 3.0, 9.0, 60.0, DT)
        for _ in range(parts):
            pieces.advance(goal, 3.0, 9.0, 60.0, DT / parts)
        assert pieces.p == pytest.approx(whole.p, abs=1e-9)
