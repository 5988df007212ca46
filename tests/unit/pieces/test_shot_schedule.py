"""When the shooter fires: exact mean rate, first shot at once, no bursts, never more than is held."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from simcore.errors import ConfigError, NonFiniteError
from simcore.pieces.launch import Aim, LaunchParameters
from simcore.pieces.shot_schedule import Launch, ShotSchedule

DUAL = LaunchParameters(height=0.55, forward=0.168, barrels=(0.08, -0.08))
SINGLE = LaunchParameters(height=0.55)


def shooter(launch=SINGLE, rate=8.0):
    inputs = SimpleNamespace(elevation=1.1, speed=9.0, open=True, turret=0.0)
    sim = ShotSchedule(
        launch,
        shot_rate=rate,
        aim=lambda share: Aim(inputs.elevation, inputs.speed, inputs.turret),
        gate_open=lambda: inputs.open,
    )
    return sim, inputs


@pytest.mark.parametrize("rate", [1.0, 3.0, 8.0, 7.77, 49.9, 60.0, 130.0])
def test_the_mean_rate_is_exact_over_1000_seconds(rate):
    sim, _ = shooter(rate=rate)
    shots = sum(len(sim.update(0.02, held=1000)) for _ in range(50_000))
    assert shots == math.ceil(round(1000.0 * rate, 6))


def test_shots_are_a_period_apart_inside_the_ticks_too():
    sim, _ = shooter(rate=8.0)
    times = [tick * 0.02 + launch.delay for tick in range(500) for launch in sim.update(0.02, held=9)]
    assert times == pytest.approx([0.125 * n for n in range(len(times))], abs=1e-9)
    assert len(times) == 80


def test_dual_barrels_fire_together():
    sim, _ = shooter(DUAL)
    assert sim.update(0.02, held=30) == [Launch(0, 0.0, Aim(1.1, 9.0)), Launch(1, 0.0, Aim(1.1, 9.0))]
    assert sim.update(0.02, held=28) == []


def test_no_more_leave_than_are_held():
    sim, _ = shooter(DUAL, rate=200.0)  # four events a tick
    assert len(sim.update(0.02, held=5)) == 5
    assert sim.update(0.02, held=0) == []
    assert sim.update(0.02, held=-1) == []
    assert sim.shots == 5


def test_first_shot_comes_at_once_after_the_gate_was_closed():
    sim, inputs = shooter()
    inputs.open = False
    for _ in range(500):
        assert sim.update(0.02, held=10) == []
    inputs.open = True
    assert len(sim.update(0.02, held=10)) == 1
    assert sum(len(sim.update(0.02, held=10)) for _ in range(5)) == 0  # nothing saved up


def test_a_gate_that_opens_in_the_course_of_a_tick_lets_the_first_shot_through_then():
    sim, _ = shooter(rate=40.0)
    (first,) = sim.update(0.02, held=10, opened=0.012)
    (second,) = sim.update(0.02, held=10, opened=0.005)
    assert (first.delay, 0.02 + second.delay) == pytest.approx((0.012, 0.012 + 0.025)), "25 ms apart, open or not"
    assert sim.update(0.02, held=10) == sim.update(0.02, held=0) == sim.update(0.02, held=10, opened=0.02) == []
    assert sim.update(0.02, held=10)[0].delay == 0.0


def test_a_gate_that_flickers_does_not_shoot_faster():
    sim, inputs = shooter()
    shots = 0
    for tick in range(5000):
        inputs.open = tick % 2 == 0
        shots += len(sim.update(0.02, held=10))
    assert shots <= 800


def test_an_empty_robot_saves_no_shots_up():
    sim, _ = shooter()
    for _ in range(500):
        sim.update(0.02, held=0)
    assert [len(sim.update(0.02, held=10)) for _ in range(7)] == [1, 0, 0, 0, 0, 0, 1]


def test_wheels_that_stand_still_keep_the_piece():
    sim, inputs = shooter()
    inputs.speed = 0.0
    assert sim.update(0.02, held=10) == []
    inputs.speed = 8.0
    assert [launch.aim.speed for launch in sim.update(0.02, held=10)] == [8.0]


def test_a_piece_whose_muzzle_is_blocked_stays_and_leaves_when_it_is_free():
    sim, _ = shooter(DUAL)
    for _ in range(30):
        assert sim.update(0.02, held=9, is_free=lambda launch: False) == []
    assert len(sim.update(0.02, held=9)) == 2
    assert sum(len(sim.update(0.02, held=7)) for _ in range(5)) == 0  # nothing saved up


def test_a_free_barrel_shoots_while_the_other_is_blocked():
    sim, _ = shooter(DUAL)
    launches = [launch for _ in range(14) for launch in sim.update(0.02, 9, lambda launch: launch.barrel == 1)]
    assert [launch.barrel for launch in launches] == [1, 1, 1]


@pytest.mark.parametrize("name", ["elevation", "speed", "turret"])
def test_a_supplier_that_gives_nan_is_named_when_it_matters(name):
    sim, inputs = shooter()
    setattr(inputs, name, math.nan)
    with pytest.raises(NonFiniteError, match="nan"):
        sim.update(0.02, held=1)
    inputs.open = False
    assert sim.update(0.02, held=1) == []


@pytest.mark.parametrize("dt", [0.0, -0.02, math.nan])
def test_a_tick_must_have_a_length(dt):
    with pytest.raises(ConfigError, match="dt"):
        shooter()[0].update(dt, held=1)


@pytest.mark.parametrize("rate", [0.0, -8.0, math.nan])
def test_the_rate_must_be_positive(rate):
    with pytest.raises(ConfigError, match="shot_rate"):
        shooter(rate=rate)
