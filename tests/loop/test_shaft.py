"""Shaft against closed forms: exponential spin-up, limits, friction and stops."""

import math

import pytest
from each_case import each
from scipy.optimize import brentq

from simcore.errors import ConfigError, NonFiniteError
from simcore.loop.robot_state import STEP
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import ShaftSim

KRAKEN = motor("Kraken X60")


def gearbox(**changes) -> GearboxConfig:
    return GearboxConfig(**{"motor": KRAKEN, "motors": 2, "gearing": 5.0, **changes})


def run(sim: ShaftSim, seconds: float, dt: float) -> None:
    for _ in range(round(seconds / dt)):
        sim.step(dt)


def fine_euler(sim: ShaftSim, volts: float, seconds: float, h: float = 1e-5) -> tuple[float, float, float]:
    """Integrate the law with limit and Coulomb friction in fine steps; return position, velocity, charge per motor."""
    box = sim.gearbox
    x, w, charge = sim.position, sim.velocity, 0.0
    for _ in range(round(seconds / h)):
        amps = (volts - box.volts_per_speed * w) / box.resistance
        amps = max(-box.stator_current_limit, min(box.stator_current_limit, amps))
        drive = box.torque_per_amp * amps + sim.load_torque
        static = abs(w) < 1e-9 or (abs(drive) * h / sim.inertia > abs(w) > 0 and w * drive < 0)
        if static and abs(drive) <= box.friction_torque:
            w_next = 0.0
        else:
            sign = math.copysign(1.0, w if abs(w) > 1e-9 else drive)
            w_next = w + h * (drive - sign * box.friction_torque) / sim.inertia
        x += 0.5 * h * (w + w_next)
        w = w_next
        charge += amps * h
    return x, w, charge


def test_the_speed_approaches_the_free_speed_exponentially_for_any_step():
    """w = w_free (1 - exp(-t / tau)) is exact, so rounding is the only error."""
    sims = {dt: ShaftSim(gearbox(), 0.05) for dt in (0.001, 0.02, 0.25)}
    for dt, sim in sims.items():
        sim.set_volts(9.0)
        run(sim, 0.5, dt)
        free = gearbox().free_speed(9.0)
        tau = sim.time_constant
        assert sim.velocity == pytest.approx(free * (1.0 - math.exp(-0.5 / tau)), rel=1e-12)
        assert sim.position == pytest.approx(free * (0.5 - tau * (1.0 - math.exp(-0.5 / tau))), rel=1e-12)


def test_a_shaft_has_the_stall_torque_and_free_speed_of_its_motors():
    box = gearbox(motors=1, gearing=1.0)
    assert box.stall_torque(12.0) == pytest.approx(KRAKEN.stall_torque)
    assert box.free_speed(12.0) == pytest.approx(KRAKEN.kv * 12.0)
    sim = ShaftSim(box, 1e3)  # too heavy to turn: stalled
    sim.set_volts(12.0)
    sim.step(0.02)
    assert sim.current == pytest.approx(KRAKEN.stall_current, rel=1e-6)
    assert sim.supply_current == pytest.approx(KRAKEN.stall_current, rel=1e-6)


def test_the_shaft_current_is_the_sum_over_all_motors():
    one, four = (ShaftSim(gearbox(motors=n), 0.05 * n) for n in (1, 4))
    for sim in (one, four):
        sim.set_volts(6.0)
        sim.step(0.02)
    assert four.velocity == pytest.approx(one.velocity)
    assert four.current == pytest.approx(4.0 * one.current)
    assert four.supply_current == pytest.approx(4.0 * one.supply_current)


def test_the_voltage_is_limited_by_the_battery():
    weak, asked = ShaftSim(gearbox(), 0.05), ShaftSim(gearbox(), 0.05)
    weak.set_volts(12.0)
    asked.set_volts(6.0)
    weak.step(0.02, battery_voltage=6.0)
    asked.step(0.02)
    assert weak.velocity == asked.velocity
    assert weak.volts == 12.0
    assert weak.supply_current == pytest.approx(2.0 * asked.supply_current)  # equal power at half the voltage


@each("start", [-150.0, 0.0, 40.0, 110.0, 260.0])
@each("volts", [-12.0, 0.0, 3.0, 12.0])
def test_limit_and_friction_agree_with_fine_integration(start, volts):
    sim = ShaftSim(gearbox(stator_current_limit=60.0, friction_torque=1.5), 0.05)
    sim.reset(velocity=start)
    expected = fine_euler(sim, volts, 0.2)
    sim.set_volts(volts)
    charge = 0.0
    for _ in range(10):
        sim.step(0.02)
        charge += sim.current * 0.02 / sim.motors
        assert abs(sim.current) <= 60.0 * sim.motors * (1 + 1e-9)
    scale = 300.0  # rad/s; Euler's error is of first order in h / tau
    assert sim.velocity == pytest.approx(expected[1], abs=1e-3 * scale)
    assert sim.position == pytest.approx(expected[0], abs=1e-3 * scale * 0.2)
    assert charge == pytest.approx(expected[2], abs=1e-3 * 60.0)


def test_a_load_above_the_limited_torque_drives_the_shaft_back():
    sim = ShaftSim(gearbox(stator_current_limit=20.0), 0.05)
    sim.set_load(-2.0 * gearbox(stator_current_limit=20.0).stall_torque(12.0))
    sim.set_volts(12.0)
    expected = fine_euler(sim, 12.0, 0.1)
    run(sim, 0.1, 0.02)
    assert sim.velocity < 0.0
    assert sim.velocity == pytest.approx(expected[1], rel=1e-3)


def test_friction_holds_the_shaft_until_the_torque_exceeds_it():
    box = gearbox(friction_torque=2.0)
    sim = ShaftSim(box, 0.05)
    sim.set_volts(0.99 * box.holding_volts(2.0))
    run(sim, 0.2, 0.02)
    assert sim.velocity == sim.position == 0.0
    assert sim.current == pytest.approx(2 * sim.volts / box.resistance)
    sim.set_volts(1.01 * box.holding_volts(2.0))
    run(sim, 0.2, 0.02)
    assert sim.velocity > 0.0


def test_friction_stops_a_coasting_wheel_at_the_predicted_time():
    """J dw/dt = -friction: rest after J w / friction seconds and J w^2 / (2 friction) radians."""
    sim = ShaftSim(gearbox(friction_torque=0.5), 0.05)
    sim.reset(velocity=20.0)
    sim.coast()
    run(sim, 1.9, 0.02)
    assert sim.velocity == pytest.approx(20.0 - 1.9 * 10.0)
    assert sim.current == sim.supply_current == 0.0
    run(sim, 1.0, 0.02)
    assert sim.velocity == 0.0
    assert sim.position == pytest.approx(20.0)


def test_friction_stops_a_wheel_that_hardly_turns():
    """At 5e-324 rad/s the product of the old and new speeds is zero, and friction once pushed the wheel backward."""
    sim = ShaftSim(gearbox(friction_torque=0.5), 0.05)
    sim.reset(velocity=5e-324)
    sim.step(0.02)
    assert (sim.position, sim.velocity) == (0.0, 0.0)


def test_coasting_ends_when_a_voltage_is_set():
    sim = ShaftSim(gearbox(), 0.05)
    sim.reset(velocity=20.0)
    sim.coast()
    sim.step(0.02)
    assert sim.velocity == 20.0
    sim.set_volts(0.0)
    sim.step(0.02)
    assert sim.velocity < 20.0


def test_a_hard_stop_holds_the_shaft_and_stalls_the_motors():
    box = gearbox(stator_current_limit=50.0)
    sim = ShaftSim(box, 0.05, lower_stop=-1.0, upper_stop=2.0)
    sim.set_volts(12.0)
    run(sim, 1.0, 0.02)
    assert (sim.position, sim.velocity) == (2.0, 0.0)
    assert sim.current == pytest.approx(2 * 50.0)
    sim.set_volts(-12.0)
    sim.step(0.02)
    assert sim.position < 2.0
    run(sim, 1.0, 0.02)
    assert (sim.position, sim.velocity) == (-1.0, 0.0)


def test_a_weight_without_friction_or_limit_rests_on_its_only_stop():
    """An elevator with only a lower stop once sank below it and was thrown out on its return."""
    lift = ShaftSim(gearbox(), 0.01, lower_stop=0.0)
    lift.set_load(-2.0)
    lift.set_volts(0.0)
    run(lift, 1.0, 0.005)
    assert lift.position == 0.0 and lift.velocity == 0.0
    lift.set_volts(6.0)
    run(lift, 0.2, 0.005)
    lift.coast()
    run(lift, 3.0, 0.005)
    assert lift.position == 0.0 and lift.velocity == 0.0


def test_an_impulse_into_a_stop_does_not_hold_a_shaft_that_is_driven_away():
    sim = ShaftSim(gearbox(), 0.05, upper_stop=2.0, position=2.0)
    sim.velocity = 5.0
    sim.set_volts(-12.0)
    sim.step(0.02)
    assert sim.position < 2.0
    assert sim.velocity < 0.0


@pytest.mark.parametrize("h", [STEP, 1e-4])
def test_the_charge_of_a_shaft_that_meets_its_stop_agrees_with_the_closed_form(h):
    """J w = (torque per current) x charge until it hits, then it stalls; the step of the hit counts as moving."""
    sim, box = ShaftSim(gearbox(), 0.05, upper_stop=0.3), gearbox()
    free, tau, stall = box.free_speed(12.0), sim.time_constant, box.motors * 12.0 / box.resistance
    hit = brentq(lambda t: free * (t - tau * (1.0 - math.exp(-t / tau))) - 0.3, 1e-3, 0.1)
    speed = free * (1.0 - math.exp(-hit / tau))
    exact = 0.05 * speed * box.motors / box.torque_per_amp + stall * (0.1 - hit)
    charge = 0.0
    sim.set_volts(12.0)
    for _ in range(round(0.1 / h)):
        sim.step(h)
        charge += sim.current * h
    missing = h * stall * speed / free
    assert exact - 1.05 * missing < charge < exact + 1e-9
    assert sim.position == 0.3 and missing < 0.02 * exact


def test_braking_feeds_back_no_more_than_the_kinetic_energy():
    sim = ShaftSim(gearbox(stator_current_limit=60.0), 0.05)
    sim.reset(velocity=200.0)
    sim.set_volts(8.0)
    before = sim.kinetic_energy
    sim.step(0.02)
    assert sim.supply_current < 0.0
    assert -sim.supply_current * 12.0 * 0.02 < before - sim.kinetic_energy


@each("bad", [math.nan, math.inf, -math.inf])
def test_non_finite_numbers_are_refused_and_change_nothing(bad):
    sim = ShaftSim(gearbox(), 0.05)
    with pytest.raises(NonFiniteError, match="volts"):
        sim.set_volts(bad)
    with pytest.raises(NonFiniteError, match="load"):
        sim.set_load(bad)
    with pytest.raises(NonFiniteError):
        sim.reset(velocity=bad)
    with pytest.raises(ConfigError, match="dt"):
        sim.step(bad)
    with pytest.raises(ConfigError, match="battery_voltage"):
        sim.step(0.02, bad)
    assert (sim.position, sim.velocity, sim.volts) == (0.0, 0.0, 0.0)


@each(
    "change",
    [
        {"motors": 0},
        {"gearing": 0.0},
        {"gearing": math.nan},
        {"stator_current_limit": -1.0},
        {"stator_current_limit": math.nan},
        {"friction_torque": -0.1},
    ],
)
def test_a_gearbox_with_invalid_values_is_refused(change):
    with pytest.raises(ConfigError, match=next(iter(change))):
        gearbox(**change)


@each("inertia", [0.0, -1.0, math.nan])
def test_the_inertia_must_be_positive(inertia):
    with pytest.raises(ConfigError, match="inertia"):
        ShaftSim(gearbox(), inertia)


def test_the_start_position_of_a_shaft_must_be_between_its_stops():
    with pytest.raises(ConfigError, match="stop"):
        ShaftSim(gearbox(), 1.0, lower_stop=0.0, upper_stop=1.0, position=2.0)


def test_a_supply_limit_bounds_the_current_drawn_and_fed_back():
    from dataclasses import replace

    from simcore.robot.dc_motor import motor

    box = GearboxConfig(motor=motor("Kraken X60"), gearing=10.0, supply_current_limit=20.0)
    free = ShaftSim(replace(box, supply_current_limit=math.inf), 0.05)
    limited = ShaftSim(box, 0.05)
    for shaft in (free, limited):
        shaft.set_volts(12.0)
        shaft.step(0.005, 12.0)
    assert free.supply_current > 100.0
    assert 0.0 < limited.supply_current <= 20.0 * (1 + 1e-9)
    for shaft in (free, limited):
        shaft.reset(velocity=60.0)
        shaft.set_volts(5.0)
        shaft.step(0.001, 12.0)
    assert free.supply_current < -30.0
    assert -20.0 * (1 + 1e-9) <= limited.supply_current < -10.0
