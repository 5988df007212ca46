"""Laws that every shaft obeys under any command."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from simcore.loop.robot_state import STEP
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import ShaftSim

pytestmark = pytest.mark.engines("bullet")

volts = st.floats(-14.0, 14.0)


def shafts_with(limits, frictions, stops) -> st.SearchStrategy[ShaftSim]:
    """Draw shafts of any inertia and gearing, with stator limit [A], friction [N m] and stops [rad] from lists."""
    return st.builds(
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
        st.sampled_from(limits),
        st.sampled_from(frictions),
        st.floats(math.log(1e-4), math.log(10.0)).map(math.exp),
        st.sampled_from(stops),
    )


FINE = 5e-5
"""Step of the reference run, whose own error is as large as its step [s]."""
LIMITS, FRICTIONS, STOPS = (math.inf, 20.0, 80.0), (0.0, 0.05, 2.0), (math.inf, 0.1, 3.0)
shafts = shafts_with(LIMITS, FRICTIONS, STOPS)


@settings(max_examples=200)
@given(shafts, st.lists(st.tuples(volts, st.floats(0.0005, 0.1), st.floats(3.0, 13.0)), min_size=1, max_size=20))
def test_a_shaft_gives_no_more_energy_than_it_takes_and_keeps_its_limits(sim, orders):
    energy_in = 0.0
    limit = sim.gearbox.stator_current_limit * sim.motors * (1.0 + 1e-9)
    for asked, dt, battery in orders:
        sim.set_volts(asked)
        sim.step(dt, battery)
        energy_in += sim.supply_current * battery * dt
        assert math.isfinite(sim.position) and math.isfinite(sim.velocity)
        assert abs(sim.current) <= limit
        lower, upper = sim.stops
        assert lower <= sim.position <= upper
        assert sim.kinetic_energy <= energy_in + 1e-7 * (1.0 + abs(energy_in))


@settings(max_examples=150)
@given(
    *(shafts_with([math.inf], [0.0], [math.inf]), volts),
    *(st.floats(-300.0, 300.0), st.floats(-3.0, 3.0), st.integers(2, 7)),
)
def test_one_long_step_equals_many_short_steps(sim, asked, speed, load, parts):
    """The loop's steps are exact for a motor at constant voltage, so the division of a span must not matter."""
    results = []
    for count in (1, parts, 200):
        path = _run(sim, asked, speed, load, 0.04, count)
        results.append(path[-1])
    for other in results[1:]:
        assert results[0] == pytest.approx(other, rel=1e-7, abs=1e-6)


@settings(max_examples=100)
@given(shafts_with(LIMITS, FRICTIONS, [math.inf]), volts, st.floats(-300.0, 300.0), st.floats(-3.0, 3.0))
def test_limits_and_friction_engage_within_one_step(sim, asked, speed, load):
    """Speed is monotonic at constant voltage, so an event h late shifts speed and charge by at most h."""
    ((x, w, charge),) = _run(sim, asked, speed, load, 0.04, 1)
    path = np.array(_run(sim, asked, speed, load, 0.04 + STEP, round((0.04 + STEP) / FINE)))
    end, around = round(0.04 / FINE), round(STEP / FINE)
    speeds = path[end - around - 1 : end + around, 1]
    box = sim.gearbox
    first = (np.clip(asked, -12.0, 12.0) - box.volts_per_speed * speed) / box.resistance
    first = box.motors * np.clip(first, -box.stator_current_limit, box.stator_current_limit)
    span = np.ptp([first, *np.diff(path[:, 2]) / FINE])
    assert speeds.min() - 1e-6 * (1.0 + abs(w)) <= w <= speeds.max() + 1e-6 * (1.0 + abs(w))
    assert x == pytest.approx(path[end - 1, 0], abs=(STEP + FINE) * abs(path[end - 1, 1] - speed) + 1e-6)
    assert charge == pytest.approx(path[end - 1, 2], abs=(STEP + FINE) * span + 1e-6)


@settings(max_examples=100)
@given(shafts_with(LIMITS, FRICTIONS, [0.1, 3.0]), volts, st.floats(-300.0, 300.0), st.floats(-3.0, 3.0))
def test_a_shaft_meets_its_stop_within_one_step(sim, asked, speed, load):
    """Position agrees with fine steps within the change of speed times one step."""
    ((x, w, _),) = _run(sim, asked, speed, load, 0.04, 1)
    path = np.array(_run(sim, asked, speed, load, 0.04, round(0.04 / FINE)))
    span = np.ptp([speed, *path[:, 1]])
    assert x == pytest.approx(path[-1, 0], abs=(STEP + FINE) * span + 1e-6)
    lower, upper = sim.stops
    assert x < upper or w <= 0.0
    assert x > lower or w >= 0.0


def _run(sim, asked, speed, load, seconds, count):
    """Return position, velocity and charge after each of `count` equal steps."""
    sim.reset(velocity=speed)
    sim.set_load(load)
    sim.set_volts(asked)
    path, charge, h = [], 0.0, seconds / count
    for _ in range(count):
        sim.step(h)
        charge += sim.current * h
        path.append((sim.position, sim.velocity, charge))
    return path


@settings(max_examples=100)
@given(shafts, st.lists(volts, min_size=1, max_size=10), st.floats(-100.0, 100.0))
def test_mirroring_the_inputs_mirrors_the_result(sim, orders, speed):
    ends = []
    for sign in (1.0, -1.0):
        sim.reset(velocity=sign * speed)
        for asked in orders:
            sim.set_volts(sign * asked)
            sim.step(0.02)
        ends.append((sign * sim.position, sign * sim.velocity, sign * sim.current, sim.supply_current))
    assert ends[0] == ends[1]
