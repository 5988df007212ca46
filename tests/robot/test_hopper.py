"""Balls in a hopper: feed rate, fill, effects of acceleration, jams and how they clear, and invalid input."""

import math

import numpy as np
import pytest
from each_case import each

from games.rebuilt.fuel import FUEL
from simcore.errors import CapacityError, ConfigError
from simcore.pieces.flight import flying_balls
from simcore.robot.hopper import Hopper, HopperConfig
from simcore.robot.storage import Storage, StorageConfig
from simcore.units import GRAVITY, TICK

R = 0.075
DOWN, NONE = (0.0, 0.0, -GRAVITY), (0.0, 0.0, 0.0)
ROOM = {"low": (-0.36, -0.305, 0.18), "high": (0.17, 0.305, 0.76)}
BELT = 0.6  # [m/s]
WEIGHT = FUEL.mass * GRAVITY


def fuel():
    """Return the balls of a match that has only fuel."""
    return flying_balls(FUEL, *np.zeros((3, 600, 3)))


def hopper(places, *, low=(-0.6, -0.305, 0.0), high=(0.3, 0.305, 0.16), **config) -> Hopper:
    """Return a hopper with balls at rest at the given places on its floor [m]."""
    made = Hopper(HopperConfig(**{"outlet_width": 0.4, "outlet_height": 0.16, **config}), low, high, fuel)
    made.follow(list(range(len(places))), [R] * len(places), [(0.0, 0.0, R)])
    slope = config.get("slope", 0.0)
    made.pos = np.array([(x, y, low[2] + R / math.cos(slope) + math.tan(slope) * (high[0] - x)) for x, y in places])
    made.vel[:] = 0.0
    return made


def scattered(seed: int, count: int, half: float) -> list[tuple[float, float]]:
    """Return random places at which the balls of one layer do not touch."""
    rng, places = np.random.default_rng(seed), []
    while len(places) < count:
        x, y = rng.uniform(-0.6 + R, 0.3 - R), rng.uniform(-half + R, half - R)
        if all(math.hypot(x - a, y - b) > 2.0 * R for a, b in places):
            places.append((x, y))
    return places


def run(made: Hopper, ticks: int, *, belt: float = 0.0, pull=DOWN, spin=NONE, gate: bool = True) -> list[int]:
    """Advance the hopper, take balls at the outlet if the gate is open, and return the ticks in which balls left."""
    left = []
    for tick in range(ticks):
        made.advance(pull, spin, NONE, belt)
        for slot in made.at_outlet() if gate else []:
            rest = [one for one in made.slots if one != slot]
            made.follow(rest, [R] * len(rest), [])
            left.append(tick)
    return left


def filled(radius: float, **room) -> Storage:
    """Return a storage filled by intakes, at most four balls at once, until none has entered for two seconds."""
    storage = Storage(StorageConfig(capacity=500, hopper=HopperConfig(outlet_width=0.01), **room), fuel)
    idle = 0
    while idle < 100:
        count, more = len(storage.pieces), min(4, storage.room_for(radius))
        storage.add(list(range(count, count + more)))
        storage.follow([radius] * (count + more))
        storage.hopper.advance(DOWN, NONE, NONE, 0.0)
        idle = 0 if more else idle + 1
    return storage


def deepest(pos, radius: float) -> float:
    return 2.0 * radius - float((np.linalg.norm(pos[:, None] - pos[None], axis=2) + 9.0 * np.eye(len(pos))).min())


# --- rates and fill -------------------------------------------------------------------------------------------------


@each("speed", (0.3, 0.7, 1.5))
def test_a_lane_feeds_balls_at_the_belt_speed_over_the_diameter(speed):
    """n / (t_n - t_0) = v / d once the belt moves them; each time is known to one tick."""
    lane = hopper(
        [(1.0 - R - 2.0 * R * number, 0.0) for number in range(30)],
        low=(-4.0, -R - 0.001, 0.0), high=(1.0, R + 0.001, 0.16), outlet_width=0.152, belt="belt",
    )  # fmt: skip
    times = run(lane, 1000, belt=speed)[8:]
    assert len(times) == 22
    took = 21 * 2.0 * R / speed
    assert (times[-1] - times[0]) * TICK == pytest.approx(took, abs=1.5 * TICK + 0.01 * took)


def test_the_foremost_ball_leaves_first_for_any_order_of_arrival():
    """The outlet is at x = 0.3 m: the ball that came in third is the farthest through it."""
    storage = Storage(StorageConfig(capacity=4, hopper=HopperConfig(outlet_width=0.4), high=(0.3, 0.305, 0.5)), fuel)
    storage.add([7, 8, 9, 5])
    storage.follow([R] * 4)
    storage.hopper.pos[:, 0] = (0.31, 0.29, 0.33, 0.32)
    assert storage.in_turn == [9, 5, 7]
    assert [storage.take() for _ in range(3)] == [9, 5, 7] and storage.pieces == [8]


def test_a_closed_gate_holds_balls_until_it_opens():
    made = hopper(scattered(1, 8, 0.305), belt="belt", funnel=0.5)
    assert run(made, 150, belt=BELT, gate=False) == [] and made.at_outlet()
    assert len(run(made, 150, belt=BELT)) == 8


@pytest.mark.parametrize(("radius", "least", "most"), [(R, 0.35, 0.55), (0.05, 0.42, 0.64)])
def test_a_hopper_fills_to_a_loose_packing_of_spheres(radius, least, most):
    """Random packings of spheres fill 0.55 to 0.64 of a large box, and less of a box of four to eight diameters."""
    storage = filled(radius, **ROOM)
    size = np.subtract(ROOM["high"], ROOM["low"])
    assert least < len(storage.pieces) * 4.0 / 3.0 * math.pi * radius**3 / np.prod(size) < most
    assert storage.room > 0 and storage.room_for(radius) == 0, "the intake has no free place"
    pos = storage.hopper.pos
    # k balls on a wall squeeze it by k m g over the stiffness, and more in a heap's middle; a pair is half as stiff
    layers = (size[2] - 2.0 * radius) / (math.sqrt(2.0) * radius)
    squeeze = 2.0 * layers * WEIGHT / FUEL.foam[0]
    assert (pos >= np.add(ROOM["low"], radius) - squeeze).all()
    assert (pos <= np.subtract(ROOM["high"], radius) + squeeze).all()
    assert deepest(pos, radius) < 2.0 * squeeze
    assert np.median(np.abs(storage.hopper.vel)) < 0.01, "and they lie still"


def test_two_intakes_share_the_space_at_an_inlet():
    storage = Storage(StorageConfig(capacity=50, hopper=HopperConfig(outlet_width=0.4), **ROOM), fuel)
    assert storage.room_for(R) == 4
    storage.add([1, 2, 3])
    assert storage.room_for(R) == 1, "before the hopper has been told"
    storage.add([4])
    assert storage.room_for(R) == 0
    storage.follow([R] * 4)
    assert storage.room_for(R) == 0


# --- what the robot does to the balls ---------------------------------------------------------------------------------


@each(("pull", "side"), [((-4.0, 0.0), (0, -1)), ((4.0, 0.0), (0, 1)), ((0.0, 4.0), (1, 1))])
def test_pieces_move_against_the_acceleration_of_the_robot(pull, side):
    """Pieces move to the rear of a robot that accelerates forward; on a stopped belt, pieces roll."""
    made = hopper(scattered(2, 6, 0.305), belt="belt", outlet_width=0.1)
    before = made.pos.mean(axis=0)
    run(made, 75, pull=(*pull, -GRAVITY))
    axis, sign = side
    assert sign * (made.pos.mean(axis=0) - before)[axis] > 0.1


def test_a_spinning_robot_throws_pieces_to_the_walls():
    made = hopper(scattered(3, 6, 0.305), outlet_width=0.1)
    before = np.hypot(*made.pos[:, :2].T).mean()
    run(made, 75, spin=(0.0, 0.0, 6.0))
    assert np.hypot(*made.pos[:, :2].T).mean() > before + 0.05


def test_a_frictionless_ball_accelerates_down_a_slope_by_the_textbook_formula():
    """s = g sin(slope) t^2 / 2 along the floor; a robot that accelerates by g tan(slope) holds the ball where it is."""
    slope, time = 0.2, 0.4
    room = {"slope": slope, "high": (0.3, 0.305, 0.5), "friction": 0.0, "outlet_width": 0.01}
    for ahead, way in ((0.0, 0.5 * GRAVITY * math.sin(slope) * time**2), (-GRAVITY * math.tan(slope), 0.0)):
        made = hopper([(-0.5, 0.0)], **room)
        run(made, round(time / TICK), pull=(ahead, 0.0, -GRAVITY))
        assert made.pos[0, 0] + 0.5 == pytest.approx(way * math.cos(slope), abs=0.003)


def test_a_frictionless_ball_in_a_spinning_robot_moves_straight_in_the_field_frame():
    """A ball at rest in the robot at r leaves at omega r along the tangent while the robot turns by omega t."""
    spin, start, ticks = 3.0, 0.1, 20
    made = hopper([(start, 0.0)], friction=0.0, outlet_width=0.01)
    for _ in range(ticks):
        made.advance(DOWN, (0.0, 0.0, spin), NONE, 0.0)
    turned = spin * ticks * TICK
    far, ahead = start * math.hypot(1.0, turned), math.atan(turned) - turned
    assert made.pos[0, :2] == pytest.approx((far * math.cos(ahead), far * math.sin(ahead)), abs=1e-3)


def test_balls_lag_behind_a_robot_that_starts_to_spin():
    """Frictionless balls keep their place over the field: the robot turns by alpha t^2 / 2 below them."""
    alpha, start, ticks = 2.0, 0.15, 25
    made = hopper([(start, 0.0)], friction=0.0, outlet_width=0.01)
    for tick in range(ticks):
        made.advance(DOWN, (0.0, 0.0, alpha * TICK * (tick + 1)), (0.0, 0.0, alpha), 0.0)
    turned = 0.5 * alpha * (ticks * TICK) ** 2
    assert made.pos[0, :2] == pytest.approx((start * math.cos(turned), -start * math.sin(turned)), abs=1e-3)


def test_hoppers_with_a_sloping_floor_or_a_bottom_outlet_need_no_belt():
    assert len(run(hopper([(-0.4, 0.0), (-0.2, 0.1)], slope=0.2, high=(0.3, 0.305, 0.5), funnel=0.5), 150)) == 2
    assert len(run(hopper([(0.0, 0.0), (0.1, 0.0)], outlet="bottom", outlet_height=0.4), 150)) >= 1


# --- jams -----------------------------------------------------------------------------------------------------------


@each(("width", "least", "most"), [(1.2, 6, 11), (1.5, 4, 9), (1.9, 1, 3), (2.2, 0, 0), (3.0, 0, 0)])
def test_narrow_outlets_jam_sometimes_and_wide_outlets_never_do(width, least, most):
    """Four balls start at many places in a channel of 2.7 diameters: the narrower the outlet, the more jams.

    A run is long enough for balls that an edge holds back while they roll on the belt.
    """
    jams = []
    for seed in range(12):
        made = hopper(
            scattered(seed, 4, 0.2), low=(-0.6, -0.2, 0.0), high=(0.3, 0.2, 0.16),
            outlet_width=width * 2.0 * R, belt="belt", funnel=0.4,
        )  # fmt: skip
        left = len(run(made, 600, belt=BELT))
        jams.append(made.is_jammed)
        assert made.is_jammed or left == 4
    assert least <= sum(jams) <= most


def jammed() -> Hopper:
    made = hopper([(0.1, 0.08), (0.1, -0.08), (-0.1, 0.0)], outlet_width=0.2, belt="belt")
    assert run(made, 100, belt=BELT) == [] and made.is_jammed
    assert run(made, 200, belt=BELT) == [] and made.is_jammed, "it stays"
    return made


def test_reversing_the_belt_clears_a_jam():
    made = jammed()
    fore = made.pos[:, 0].max()
    run(made, 25, belt=-BELT)
    assert not made.is_jammed and made.pos[:, 0].max() < fore - 0.1
    made.pos[0] = (0.2, 0.0, R)  # one ball gets ahead of the other
    assert len(run(made, 200, belt=BELT)) >= 1


def test_a_jolt_stronger_than_the_belt_clears_a_jam():
    """The belt pushes the balls with mu g = 3.9 m/s^2."""
    made = jammed()
    run(made, 5, belt=BELT, pull=(-3.0, 0.0, -GRAVITY))
    assert made.is_jammed
    run(made, 5, belt=BELT, pull=(-30.0, 0.0, -GRAVITY))
    assert not made.is_jammed


# --- invalid input ----------------------------------------------------------------------------------------------------


def test_a_hopper_and_its_storage_always_hold_the_same_pieces():
    """Pieces are taken out and put in by hand, the same one twice, and more than fit; some numbers are invalid."""
    storage = Storage(StorageConfig(capacity=100, hopper=HopperConfig(outlet_width=0.4, belt="belt"), **ROOM), fuel)
    storage.add(list(range(90)))
    storage.pieces.remove(4)
    storage.pieces.append(200)
    storage.pieces.append(200)
    assert storage.places(np.full(201, R)).shape == (91, 3)
    for speed, pull in (
        (math.nan, DOWN),
        (math.inf, DOWN),
        (1e9, DOWN),
        (0.0, (1e12, 0.0, 0.0)),
        (0.0, (math.nan,) * 3),
    ):
        storage.follow([R] * 91)
        storage.hopper.advance(pull, NONE, NONE, speed)
        assert storage.hopper.slots == storage.pieces and np.isfinite(storage.hopper.pos).all()
        assert (np.abs(storage.hopper.pos) < 1.0).all()
    storage.discard(200)
    assert 200 not in storage.in_turn
    waits = Storage(StorageConfig(hopper=HopperConfig(outlet_width=0.4)))
    waits.add([3])
    with pytest.raises(CapacityError, match="none of the 1 pieces is at the outlet of the hopper"):
        waits.take()
    assert waits.pieces == [3]


def test_invalid_hoppers_are_refused():
    for change, words in (
        ({"outlet": "top"}, "outlet must be 'front', 'back', 'left', 'right' or 'bottom'"),
        ({"inlet": "bottom"}, "inlet must not be the bottom, got 'bottom'"),
        ({"outlet_width": 0.0}, "outlet_width"),
        ({"funnel": "steep"}, "funnel must be a number from 0 to 1.2 rad"),
        ({"slope": 2.0}, "slope must be a number from 0 to 1.2 rad"),
        ({"slope": 0.2, "outlet": "bottom"}, "needs an outlet in a wall"), ({"friction": -1.0}, "friction"),
    ):  # fmt: skip
        with pytest.raises(ConfigError, match=words):
            HopperConfig(**{"outlet_width": 0.4, **change})
    with pytest.raises(ConfigError, match=r"order must be 'fifo' with a hopper.*got 'lifo'"):
        StorageConfig(order="lifo", hopper=HopperConfig(outlet_width=0.4))
    with pytest.raises(ConfigError, match="z of outlet_place must be from 0"):
        StorageConfig(hopper=HopperConfig(outlet_width=0.4, outlet_place=(0.0, 0.9)), **ROOM)
