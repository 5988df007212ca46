"""Laws that every shaft keeps, whatever it is asked to do."""

from __future__ import annotations

import math

from hypothesis import given, settings
from hypothesis import strategies as st

from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.shaft import ShaftSim

volts = st.floats(-14.0, 14.0)
shafts = st.builds(
    lambda motors, gearing, limit, friction, inertia, stop: ShaftSim(
        GearboxConfig(
            motor=motor("Kraken X60"),
            motors=motors,
            gearing=gearing,
            stator_current_limit=limit,
            friction_torque=friction,
        ),
        inertia,
        lower_stop=-stop,
        upper_stop=stop,
    ),
    st.integers(1, 4),
    st.floats(0.5, 100.0),
    st.sampled_from([math.inf, 20.0, 80.0]),
    st.sampled_from([0.0, 0.05, 2.0]),
    st.floats(1e-4, 10.0),
    st.sampled_from([math.inf, 0.1, 3.0]),
)


@settings(max_examples=200)
@given(shafts, st.lists(st.tuples(volts, st.floats(0.0005, 0.1), st.floats(3.0, 13.0)), min_size=1, max_size=20))
def test_energy_out_is_not_above_energy_in_and_limits_hold(sim, orders):
    energy_in = 0.0
    limit = sim.gearbox.stator_current_limit * sim.motors * (1.0 + 1e-9)
    for asked, dt, battery in orders:
        sim.set_volts(asked)
        sim.step(dt, battery)
        energy_in += sim.supply_current * battery * dt
        assert math.isfinite(sim.position) and math.isfinite(sim.velocity)
        assert abs(sim.current) <= limit
        assert sim._lower <= sim.position <= sim._upper
        assert sim.kinetic_energy <= energy_in + 1e-7 * (1.0 + abs(energy_in))


@settings(max_examples=150)
@given(shafts, volts, st.floats(-300.0, 300.0), st.floats(-3.0, 3.0), st.integers(2, 7))
def test_one_long_step_equals_many_short_ones(sim, asked, speed, load, parts):
    """Exact integration: how a span is cut must not matter."""
    results = []
    for count in (1, parts):
        sim.reset(velocity=speed)
        sim.set_load(load)
        sim.set_volts(asked)
        charge = 0.0
        for _ in range(count):
            sim.step(0.04 / count)
            charge += sim.current * 0.04 / count
        results.append((sim.position, sim.velocity, charge))
    (x1, w1, q1), (x2, w2, q2) = results
    assert math.isclose(x1, x2, rel_tol=1e-7, abs_tol=1e-7)
    assert math.isclose(w1, w2, rel_tol=1e-7, abs_tol=1e-6)
    assert math.isclose(q1, q2, rel_tol=1e-7, abs_tol=1e-6)


@settings(max_examples=100)
@given(shafts, st.lists(volts, min_size=1, max_size=10), st.floats(-100.0, 100.0))
def test_a_mirrored_run_gives_the_mirrored_result(sim, orders, speed):
    ends = []
    for sign in (1.0, -1.0):
        sim.reset(velocity=sign * speed)
        for asked in orders:
            sim.set_volts(sign * asked)
            sim.step(0.02)
        ends.append((sign * sim.position, sign * sim.velocity, sign * sim.current, sim.supply_current))
    assert ends[0] == ends[1]
