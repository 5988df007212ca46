"""Speed, spin, direction and timing of shots from wheels, hood, turret and gate."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from each_case import each

from simcore.errors import ConfigError, NonFiniteError, UnknownNameError
from simcore.pieces.launch import Aim, Launch, LaunchParameters
from simcore.robot.shooter import Shooter, ShooterConfig, ShotErrors
from simcore.world.linkage import PartState
from simcore.world.rotation import from_yaw, rotate

STILL = PartState((1.0, 2.0, 0.0), (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
RADIUS = 0.075


def part(velocity=0.0, position=0.0, inertia=0.01):
    return SimpleNamespace(velocity=velocity, position=position, inertia=inertia, stops=(0.0, 1.0))


def shooter(**change):
    config = dict(
        wheels=("lower", "upper"), wheel_radius=0.05, exit_efficiency=0.9, elevation=1.0, shot_rate=8.0,
        launch=LaunchParameters(height=0.5, forward=0.2),
    )  # fmt: skip
    parts = {name: part() for name in ("lower", "upper", "hood", "turret", "feeder")}
    return Shooter(ShooterConfig(**{**config, **change}), parts), parts


def shot(made):
    (launch,) = made.update(1)
    return made.released(launch, radius=RADIUS, robot=STILL)


def test_two_wheels_throw_at_their_mean_speed_and_spin_by_their_difference():
    """The lower rim is faster and so carries the underside along more: backspin, about the axis to the right."""
    made, parts = shooter()
    parts["lower"].velocity, parts["upper"].velocity = 300.0, 200.0
    assert made.wheel_speed == 250.0
    assert made.aim.speed == pytest.approx(250.0 * 0.05 * 0.9)
    assert shot(made).rate == pytest.approx((0.0, -0.5 * 100.0 * 0.05 * 0.9 / RADIUS, 0.0))
    assert made.config.wheel_speed_for(made.aim.speed) == pytest.approx(250.0)


def test_wheels_of_two_radii_throw_at_the_mean_speed_of_their_rims():
    """A roller of 25 mm behind the hood: rims at 15 and 7.5 m/s; each wheel acts by its own radius."""
    made, parts = shooter(second_wheel_radius=0.025)
    parts["lower"].velocity, parts["upper"].velocity = 300.0, 300.0
    assert made.aim.speed == pytest.approx(0.5 * (15.0 + 7.5) * 0.9)
    assert shot(made).rate == pytest.approx((0.0, -0.5 * (15.0 - 7.5) * 0.9 / RADIUS, 0.0))
    speed, share = made.aim.speed, 0.2 * 0.5 * 7.5 * 0.9
    assert made.config.wheel_speed_for(speed) == pytest.approx(300.0)
    made.after_shot(0.2, speed)
    assert 300.0 - parts["lower"].velocity == pytest.approx(0.2 * (0.5 * speed + share) * 0.05 / 0.01)
    assert 300.0 - parts["upper"].velocity == pytest.approx(0.2 * (0.5 * speed - share) * 0.025 / 0.01)


def test_a_faster_left_wheel_spins_a_piece_clockwise_about_its_upright_axis():
    made, parts = shooter(wheel_places="left and right", elevation=0.4)
    parts["lower"].velocity, parts["upper"].velocity = 300.0, 200.0
    piece, rate = shot(made), 0.5 * 100.0 * 0.05 * 0.9 / RADIUS
    assert piece.rate == pytest.approx((rate * math.sin(0.4), 0.0, -rate * math.cos(0.4)))
    assert np.dot(piece.rate, piece.vel) == pytest.approx(0.0, abs=1e-12)


def test_the_gate_is_open_while_every_feeder_turns_in_its_configured_direction():
    made, parts = shooter(gate=("feeder", "hood"), gate_reversed=("hood",))
    parts["lower"].velocity = parts["upper"].velocity = 300.0
    for feeder, kicker, is_open in ((20.0, -20.0, True), (20.0, 20.0, False), (-20.0, -20.0, False)):
        parts["feeder"].velocity, parts["hood"].velocity = feeder, kicker
        assert made.gate_open is is_open


def test_a_piece_rolls_along_a_fixed_hood():
    made, parts = shooter(wheels=("lower",), exit_efficiency=0.5)
    parts["lower"].velocity = 300.0
    assert made.aim.speed == pytest.approx(7.5)
    assert shot(made).rate == pytest.approx((0.0, -7.5 / RADIUS, 0.0))


def test_the_turret_turns_the_muzzle_the_velocity_and_the_spin():
    """The mechanism is at 10 rad with a ratio of pi / 20: a quarter turn to the left."""
    made, parts = shooter(turret="turret", turret_ratio=math.pi / 20)
    parts["lower"].velocity, parts["upper"].velocity = 300.0, 200.0
    parts["turret"].position = 10.0
    piece, v = shot(made), made.aim.speed
    assert made.aim.turret_angle == pytest.approx(math.pi / 2)
    assert piece.vel == pytest.approx((0.0, v * math.cos(1.0), v * math.sin(1.0)))
    assert piece.pos == pytest.approx((1.0, 2.2, 0.5))
    assert piece.rate[0] > 0.0 and piece.rate[1:] == pytest.approx((0.0, 0.0), abs=1e-9)


def test_a_shot_within_a_tick_has_the_aim_at_the_time_of_its_release():
    """Wheels, hood and turret move evenly within the tick; at a rate of 80, the second shot leaves after 5/8 of it."""
    made, parts = shooter(shot_rate=80.0, hood="hood", turret="turret")
    parts["lower"].velocity = parts["upper"].velocity = 200.0
    parts["turret"].velocity = 10.0
    made.begin_tick()
    parts["lower"].velocity = parts["upper"].velocity = 280.0
    parts["hood"].position, parts["turret"].position = 0.08, 0.2
    first, second = made.update(2)
    assert (first.delay, second.delay) == (0.0, pytest.approx(0.0125))
    for launch, wheels, hood, turret in ((first, 200.0, 0.0, 0.0), (second, 250.0, 0.05, 0.125)):
        assert launch.aim.speed == pytest.approx(wheels * 0.05 * 0.9)
        assert launch.aim.elevation == pytest.approx(1.0 - hood)
        assert launch.aim.turret_angle == pytest.approx(turret)
        assert launch.aim.turret_rate == 10.0
    (third,) = made.update(1)
    assert third.aim == made.aim, "without a beginning of the tick: as it is now"


def test_the_x_axis_of_a_released_piece_points_along_its_velocity():
    """A piece that lies along x in the storage leaves along the muzzle."""
    made, parts = shooter(turret="turret", elevation=0.7)
    parts["lower"].velocity = parts["upper"].velocity = 300.0
    parts["turret"].position = 0.4
    (launch,) = made.update(1)
    piece = made.released(launch, radius=RADIUS, robot=STILL._replace(quat=from_yaw(1.1)))
    ahead = np.array(piece.vel) / np.linalg.norm(piece.vel)
    assert rotate(piece.quat, (1.0, 0.0, 0.0)) == pytest.approx(tuple(ahead))
    assert rotate(piece.quat, (0.0, 1.0, 0.0))[2] == pytest.approx(0.0), "it does not roll"


def test_the_hood_tilts_the_shot_and_the_gate_holds_it_back():
    made, parts = shooter(hood="hood", elevation_per_hood=-2.0, gate=("feeder",), gate_speed=3.0)
    parts["hood"].position = 0.1
    assert made.aim.elevation == pytest.approx(0.8)
    parts["lower"].velocity = parts["upper"].velocity = 300.0
    assert not made.gate_open and made.update(1) == []
    parts["feeder"].velocity = 4.0
    assert made.gate_open
    parts["lower"].velocity = parts["upper"].velocity = 20.0
    assert not made.gate_open, "slow wheels throw nothing"


def angular_impulses(made, parts, names, mass, speed):
    """Return the angular impulse that each wheel loses [N m s]."""
    before = {name: parts[name].velocity for name in names}
    made.after_shot(mass, speed)
    return [(before[name] - parts[name].velocity) * parts[name].inertia for name in names]


def test_no_shot_leaves_before_the_gate_has_opened():
    """The wheels are fast enough after 1/4 of a tick, the feeder after 3/5: the shot has the speed of that instant."""
    made, parts = shooter(gate=("feeder",), gate_speed=3.0, min_wheel_speed=100.0)
    parts["lower"].velocity = parts["upper"].velocity = 90.0
    made.begin_tick()
    parts["lower"].velocity = parts["upper"].velocity = 130.0
    parts["feeder"].velocity = 5.0
    (launch,) = made.update(1)
    assert launch.delay == pytest.approx(0.012)
    assert launch.aim.speed == pytest.approx(114.0 * 0.05 * 0.9)


def test_a_ball_on_a_fixed_hood_takes_seven_tenths_of_its_momentum_from_the_wheel():
    """Moments about the line where the ball touches the hood: 2 r J = (0.4 + 1) m r^2 w with w r = v."""
    made, parts = shooter(wheels=("lower",), exit_efficiency=0.5)
    parts["lower"].velocity = 300.0
    (lost,) = angular_impulses(made, parts, ["lower"], 0.2, 7.5)
    assert lost == pytest.approx(0.7 * 0.2 * 7.5 * 0.05)


@each("upper", [300.0, 200.0, -100.0])
def test_two_wheels_give_a_ball_its_momentum_and_its_spin(upper):
    """J_lower + J_upper = m v and (J_lower - J_upper) r = 0.4 m r^2 w; each gives half where both turn alike."""
    made, parts = shooter(exit_efficiency=1.0)
    parts["lower"].velocity, parts["upper"].velocity = 300.0, upper
    mass, speed = 0.2, made.aim.speed
    spin = -shot(made).rate[1]
    lower, upper_lost = (lost / 0.05 for lost in angular_impulses(made, parts, ["lower", "upper"], mass, speed))
    assert lower + upper_lost == pytest.approx(mass * speed)
    assert (lower - upper_lost) * RADIUS == pytest.approx(0.4 * mass * RADIUS**2 * spin, abs=1e-12)
    if upper == 300.0:
        assert lower == pytest.approx(0.5 * mass * speed)


@pytest.mark.parametrize("wheels", [("lower",), ("lower", "upper")])
def test_wheels_lose_twice_the_energy_that_a_ball_gains(wheels):
    """The rims slip at first, so J u is twice the energy that the ball gains from rest."""
    made, parts = shooter(wheels=wheels, exit_efficiency=1.0 if len(wheels) == 2 else 0.5)
    for name in wheels:
        parts[name].velocity, parts[name].inertia = 300.0, 1e3
    mass, speed = 0.2, made.aim.speed
    spin = shot(made).rate[1]
    gained = 0.5 * mass * speed**2 + 0.5 * 0.4 * mass * RADIUS**2 * spin**2
    lost = 0.0
    for impulse in angular_impulses(made, parts, wheels, mass, speed):
        lost += impulse * 300.0
    assert lost == pytest.approx(2.0 * gained)


def test_shots_have_errors_that_the_robots_readings_do_not_show():
    """Each launch draws one error of each kind; hood and turret differ from their encoders."""
    rng = np.random.default_rng(1)
    late = iter(rng.normal(0.0, 0.02, 2000).tolist())
    errors = ShotErrors(
        exit_speed=lambda: 1.1,
        elevation=lambda: 0.02,
        azimuth=lambda: -0.03,
        spin=lambda: 0.5,
        feed_time=lambda: next(late),
        hood=0.01,
        turret=0.04,
    )
    made, parts = shooter(wheels=("lower",), hood="hood", turret="turret", turret_ratio=0.5, exit_efficiency=0.5)
    off = Shooter(made.config, parts, errors)
    parts["lower"].velocity = 300.0
    (right,), (wrong,) = made.update(1), off.update(1)
    assert wrong.aim.speed == pytest.approx(1.1 * right.aim.speed)
    assert wrong.aim.elevation == pytest.approx(right.aim.elevation + 0.02 - 0.01)  # elevation_per_hood is -1
    assert wrong.aim.turret_angle == pytest.approx(-0.03 + 0.5 * 0.04)
    exact, loose = (m.released(s, radius=RADIUS, robot=STILL) for m, s in ((made, right), (off, wrong)))
    assert np.linalg.norm(loose.rate) == pytest.approx(0.5 * 1.1 * np.linalg.norm(exact.rate))
    assert off.aim == made.aim
    # feed times: 8 shots a second on average, each off its turn after the previous one by a deviation of 20 ms
    times = np.array([0.02 * tick + one.delay for tick in range(10_000) for one in off.update(9)])
    gaps = np.diff(times)
    n = len(gaps)
    assert gaps.min() >= 0.8 * 0.125 - 1e-9
    assert gaps.mean() == pytest.approx(0.125 + 0.0011, abs=4 * 0.02 / math.sqrt(n))  # the cut at -25 ms adds 1.1 ms
    assert gaps.std() == pytest.approx(0.0181, abs=4 * 0.0181 / math.sqrt(2 * n))


def test_a_thicker_piece_slips_less():
    """With a slip of 20 % at a squeeze of 15 % of the diameter, 1.5 % more diameter means a tenth more squeeze."""
    made, parts = shooter(wheels=("lower",), exit_efficiency=0.4)
    parts["lower"].velocity = 300.0
    (launch,) = made.update(1)
    assert made.gripped(launch, 1.0) is launch
    assert made.gripped(launch, 1.015).aim.speed / launch.aim.speed == pytest.approx((1.0 - 0.2 / 1.1) / 0.8)
    assert made.config.grip(0.985) < 1.0 and made.config.grip(0.5) >= 0.0
    assert shooter(exit_efficiency=1.0)[0].config.grip(0.98) == 1.0, "without slip size does not matter"


def test_slip_depends_on_piece_size_and_a_compression_loss_slows_the_wheel():
    """Exit speed = rim / 2 (1 - slip c / squeeze); the foam takes E more, by which I w^2 / 2 falls with each shot."""
    made, parts = shooter(wheels=("lower",), exit_efficiency=0.4, compression=0.3, compression_loss=5.0)
    assert made.config.slip == pytest.approx(0.2) and made.config.grip(1.03) == pytest.approx((1.0 - 0.2 / 1.1) / 0.8)
    speeds = []
    for shot in range(3):
        parts["lower"].velocity = before = 300.0 if not shot else speeds[-1]
        made.after_shot(0.2, 5.0)
        speeds.append(parts["lower"].velocity)
        driven = before - 0.7 * 0.2 * 5.0 * 0.05 / 0.01
        assert 0.5 * 0.01 * (driven**2 - speeds[-1] ** 2) == pytest.approx(5.0)
    parts["lower"].velocity = 10.0
    made.after_shot(0.2, 0.1)
    assert parts["lower"].velocity == 0.0, "no more than there is"
    made, parts = shooter(compression_loss=5.0)
    parts["lower"].velocity = parts["upper"].velocity = 300.0
    made.after_shot(0.0, 0.0)
    left = 0.5 * 0.01 * (parts["lower"].velocity ** 2 + parts["upper"].velocity ** 2)
    assert 0.01 * 300.0**2 - left == pytest.approx(5.0), "from two wheels together"


@each(
    ("change", "said"),
    [
        ({"wheels": ()}, "one or two mechanisms"),
        ({"wheels": ("lower",), "second_wheel_radius": 0.03}, "second_wheel_radius needs two wheels"),
        ({"wheel_places": "above"}, "wheel_places must be"),
        ({"gate": ("feeder",), "gate_reversed": ("hood",)}, "gate_reversed must name mechanisms of gate"),
        ({"hood": "hod"}, "for a shooter"),
        ({"compression": 1.2}, "compression must be"),
        *(({"shot_rate": rate}, "shot_rate") for rate in (0.0, -8.0, math.nan)),
    ],
)
def test_invalid_shooters_are_refused(change, said):
    with pytest.raises((ConfigError, UnknownNameError), match=said):
        shooter(**change)


# --- when the shooter fires: exact mean rate, first shot at once, no bursts, never more than it holds -----------------


DUAL = LaunchParameters(height=0.55, forward=0.168, barrels=(0.08, -0.08))
SINGLE = LaunchParameters(height=0.55)
OPEN, CLOSED = 10.0, 0.0  # speed of the feeder [rad/s]


def firing_shooter(launch=SINGLE, rate=8.0):
    """Return a shooter with wheels at 9 m/s and an open gate, and its mechanisms."""
    parts = {name: SimpleNamespace(velocity=OPEN, position=0.0, inertia=0.01) for name in ("wheel", "feeder", "hood")}
    parts["wheel"].velocity = 360.0
    config = ShooterConfig(
        wheels=("wheel",), wheel_radius=0.05, exit_efficiency=0.5, elevation=1.1, launch=launch, shot_rate=rate,
        gate=("feeder",), hood="hood", turret="hood", min_wheel_speed=0.0,
    )  # fmt: skip
    return Shooter(config, parts), parts


@each("rate", [1.0, 7.77, 49.9, 130.0])
def test_the_mean_shot_rate_is_exact_over_1000_seconds(rate):
    made, _ = firing_shooter(rate=rate)
    shots = sum(len(made.update(held=1000)) for _ in range(50_000))
    assert shots == math.ceil(round(1000.0 * rate, 6))


def test_shots_are_exactly_one_period_apart_even_within_ticks():
    made, _ = firing_shooter(rate=8.0)
    times = [tick * 0.02 + launch.delay for tick in range(500) for launch in made.update(held=9)]
    assert times == pytest.approx([0.125 * n for n in range(len(times))], abs=1e-9)
    assert len(times) == 80


def test_two_barrels_fire_together():
    made, _ = firing_shooter(DUAL)
    aim = Aim(1.1, 9.0, 0.0, OPEN)
    assert made.update(held=30) == [Launch(0, 0.0, aim), Launch(1, 0.0, aim)]
    assert made.update(held=28) == []


def test_no_more_pieces_leave_than_are_held():
    made, _ = firing_shooter(DUAL, rate=200.0)  # four shots a tick
    assert len(made.update(held=5)) == 5
    assert made.update(held=0) == []
    assert made.update(held=-1) == []


def test_the_first_shot_comes_at_once_after_the_gate_was_closed():
    made, parts = firing_shooter()
    parts["feeder"].velocity = CLOSED
    for _ in range(500):
        assert made.update(held=10) == []
    parts["feeder"].velocity = OPEN
    assert len(made.update(held=10)) == 1
    assert sum(len(made.update(held=10)) for _ in range(5)) == 0  # no shots were saved up


def test_shots_after_a_gate_opens_within_a_tick_are_a_period_apart():
    """The gate opens after 3/5 of a tick; the next shot leaves 25 ms later, in the next tick."""
    made, parts = firing_shooter(rate=40.0)
    parts["feeder"].velocity = made.config.gate_speed - 3.0
    made.begin_tick()
    parts["feeder"].velocity = made.config.gate_speed + 2.0
    (first,) = made.update(held=10)
    (second,) = made.update(held=10)
    assert (first.delay, 0.02 + second.delay) == pytest.approx((0.012, 0.012 + 0.025))


def test_a_flickering_gate_does_not_shoot_faster():
    made, parts = firing_shooter()
    shots = 0
    for tick in range(5000):
        parts["feeder"].velocity = OPEN if tick % 2 == 0 else CLOSED
        shots += len(made.update(held=10))
    assert shots <= 800


def test_an_empty_robot_accumulates_no_shots():
    made, _ = firing_shooter()
    for _ in range(500):
        made.update(held=0)
    assert [len(made.update(held=10)) for _ in range(7)] == [1, 0, 0, 0, 0, 0, 1]


def test_a_shooter_does_not_fire_until_its_wheels_turn_fast_enough():
    made, parts = firing_shooter()
    parts["wheel"].velocity = 19.0
    assert made.gate_open and made.update(held=10) == []
    parts["wheel"].velocity = 320.0
    assert [launch.aim.speed for launch in made.update(held=10)] == [8.0]


def test_a_blocked_piece_stays_and_leaves_when_its_muzzle_is_free():
    made, _ = firing_shooter(DUAL)
    for _ in range(30):
        assert made.update(held=9, is_free=lambda launch: False) == []
    assert len(made.update(held=9)) == 2
    assert sum(len(made.update(held=7)) for _ in range(5)) == 0  # no shots were saved up


def test_a_free_barrel_shoots_while_the_other_is_blocked():
    made, _ = firing_shooter(DUAL)
    launches = [launch for _ in range(14) for launch in made.update(9, lambda launch: launch.barrel == 1)]
    assert [launch.barrel for launch in launches] == [1, 1, 1]


def test_a_nan_aim_is_an_error_when_a_shot_is_due():
    made, parts = firing_shooter()
    parts["hood"].position = math.nan
    with pytest.raises(NonFiniteError, match="nan"):
        made.update(held=1)
    parts["feeder"].velocity = CLOSED
    assert made.update(held=1) == []
