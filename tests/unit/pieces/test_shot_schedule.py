"""When the shooter fires: exact mean rate, first shot at once, no bursts, never more than is held."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from simcore.errors import ConfigError, NonFiniteError
from simcore.pieces.launch import Aim, Launch, LaunchParameters
from simcore.pieces.shooter import Shooter, ShooterConfig

DUAL = LaunchParameters(height=0.55, forward=0.168, barrels=(0.08, -0.08))
SINGLE = LaunchParameters(height=0.55)
OPEN, CLOSED = 10.0, 0.0  # speed of the feeder [rad/s]


def shooter(launch=SINGLE, rate=8.0):
    """A shooter with wheels at 9 m/s and an open gate, and its mechanisms."""
    parts = {name: SimpleNamespace(velocity=OPEN, position=0.0, inertia=0.01) for name in ("wheel", "feeder", "hood")}
    parts["wheel"].velocity = 360.0
    config = ShooterConfig(
        wheels=("wheel",), wheel_radius=0.05, exit_efficiency=0.5, elevation=1.1, launch=launch, shot_rate=rate,
        gate=("feeder",), hood="hood", turret="hood", min_wheel_speed=0.0,
    )  # fmt: skip
    return Shooter(config, parts), parts


@pytest.mark.parametrize("rate", [1.0, 3.0, 8.0, 7.77, 49.9, 60.0, 130.0])
def test_the_mean_rate_is_exact_over_1000_seconds(rate):
    made, _ = shooter(rate=rate)
    shots = sum(len(made.update(held=1000)) for _ in range(50_000))
    assert shots == math.ceil(round(1000.0 * rate, 6))


def test_shots_are_a_period_apart_inside_the_ticks_too():
    made, _ = shooter(rate=8.0)
    times = [tick * 0.02 + launch.delay for tick in range(500) for launch in made.update(held=9)]
    assert times == pytest.approx([0.125 * n for n in range(len(times))], abs=1e-9)
    assert len(times) == 80


def test_dual_barrels_fire_together():
    made, _ = shooter(DUAL)
    aim = Aim(1.1, 9.0, 0.0, OPEN)
    assert made.update(held=30) == [Launch(0, 0.0, aim), Launch(1, 0.0, aim)]
    assert made.update(held=28) == []


def test_no_more_leave_than_are_held():
    made, _ = shooter(DUAL, rate=200.0)  # four events a tick
    assert len(made.update(held=5)) == 5
    assert made.update(held=0) == []
    assert made.update(held=-1) == []


def test_first_shot_comes_at_once_after_the_gate_was_closed():
    made, parts = shooter()
    parts["feeder"].velocity = CLOSED
    for _ in range(500):
        assert made.update(held=10) == []
    parts["feeder"].velocity = OPEN
    assert len(made.update(held=10)) == 1
    assert sum(len(made.update(held=10)) for _ in range(5)) == 0  # nothing saved up


def test_shots_after_a_gate_that_opens_in_the_course_of_a_tick_are_a_period_apart():
    """The gate opens after 3/5 of a tick; 25 ms later the next one leaves, open or not."""
    made, parts = shooter(rate=40.0)
    parts["feeder"].velocity = made.config.gate_speed - 3.0
    made.begin_tick()
    parts["feeder"].velocity = made.config.gate_speed + 2.0
    (first,) = made.update(held=10)
    (second,) = made.update(held=10)
    assert (first.delay, 0.02 + second.delay) == pytest.approx((0.012, 0.012 + 0.025))


def test_a_gate_that_flickers_does_not_shoot_faster():
    made, parts = shooter()
    shots = 0
    for tick in range(5000):
        parts["feeder"].velocity = OPEN if tick % 2 == 0 else CLOSED
        shots += len(made.update(held=10))
    assert shots <= 800


def test_an_empty_robot_saves_no_shots_up():
    made, _ = shooter()
    for _ in range(500):
        made.update(held=0)
    assert [len(made.update(held=10)) for _ in range(7)] == [1, 0, 0, 0, 0, 0, 1]


def test_wheels_that_hardly_turn_keep_the_piece():
    made, parts = shooter()
    parts["wheel"].velocity = 19.0
    assert made.gate_open and made.update(held=10) == []
    parts["wheel"].velocity = 320.0
    assert [launch.aim.speed for launch in made.update(held=10)] == [8.0]


def test_a_piece_whose_muzzle_is_blocked_stays_and_leaves_when_it_is_free():
    made, _ = shooter(DUAL)
    for _ in range(30):
        assert made.update(held=9, is_free=lambda launch: False) == []
    assert len(made.update(held=9)) == 2
    assert sum(len(made.update(held=7)) for _ in range(5)) == 0  # nothing saved up


def test_a_free_barrel_shoots_while_the_other_is_blocked():
    made, _ = shooter(DUAL)
    launches = [launch for _ in range(14) for launch in made.update(9, lambda launch: launch.barrel == 1)]
    assert [launch.barrel for launch in launches] == [1, 1, 1]


def test_an_aim_of_nan_is_named_when_it_matters():
    made, parts = shooter()
    parts["hood"].position = math.nan
    with pytest.raises(NonFiniteError, match="nan"):
        made.update(held=1)
    parts["feeder"].velocity = CLOSED
    assert made.update(held=1) == []


@pytest.mark.parametrize("rate", [0.0, -8.0, math.nan])
def test_the_rate_must_be_positive(rate):
    with pytest.raises(ConfigError, match="shot_rate"):
        shooter(rate=rate)
