"""Shots at an opening among field elements: equation of motion, and effects of rim and boards."""

import math
from dataclasses import replace

import numpy as np
import pytest
from each_case import each

from simcore.errors import ConfigError
from simcore.pieces.flight import fly_shots, flying_balls
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.shot_opening import ShotOpening
from simcore.units import GRAVITY
from simcore.world.ball_dynamics import StandingField
from simcore.world.contact_law import CARPET, TerrainSurface
from simcore.world.field import box_element
from simcore.world.shapes import Sphere
from simcore.world.zones import BoxZone, CylinderZone

RADIUS, HEIGHT, THICKNESS = 0.1, 2.0, 0.02
SQUARE = ((4.5, -0.5, HEIGHT), (5.5, -0.5, HEIGHT), (5.5, 0.5, HEIGHT), (4.5, 0.5, HEIGHT))
ZONE = CylinderZone((5.0, 0.0), 0.45, 1.0, 1.8)
BALL = GamePieceConfig(name="Ball", shape=Sphere(RADIUS), mass=0.2, friction=0.0, restitution=0.5)
STIFF = TerrainSurface(name="STIFF", friction=0.0, restitution=1.0)


def wall(low, high):
    return replace(box_element("wall", low, high), surface=STIFF)


BIN = tuple(
    wall((x0, y0, 0.0), (x1, y1, HEIGHT))
    for x0, y0, x1, y1 in (
        (4.5 - THICKNESS, -0.5, 4.5, 0.5),
        (5.5, -0.5, 5.5 + THICKNESS, 0.5),
        (4.5, -0.5 - THICKNESS, 5.5, -0.5),
        (4.5, 0.5, 5.5, 0.5 + THICKNESS),
    )
)
NET = wall((5.5, -1.0, HEIGHT), (5.6, 1.0, 4.0))


def shots(vel, drag=0.0, pos=(0.0, 0.0, 0.5)):
    vel = np.atleast_2d(np.array(vel, dtype=float))
    balls = flying_balls(BALL, np.repeat([pos], len(vel), axis=0), vel, np.zeros((len(vel), 3)))
    balls.air[:, 0] = drag
    return balls


def fly(balls, *more, **how):
    field = StandingField.of((*BIN, *more), CARPET)
    return fly_shots(field, balls, ShotOpening(corners=SQUARE, approach=0.0), ZONE, **how)


def through(x, rise):
    """Return the velocity, without drag, of a shot with a rise [m] that falls through the opening's plane at x."""
    up = math.sqrt(2.0 * GRAVITY * rise)
    time = up / GRAVITY + math.sqrt(2.0 * (rise - (HEIGHT - 0.5)) / GRAVITY)
    return (x / time, 0.0, up)


def test_a_scoring_ball_clears_the_rim_at_the_front_and_back():
    """A steep shot must pass both edges by a radius inside, a little more on the near side where it descends."""
    reach = np.linspace(4.3, 5.7, 281)
    found = fly(shots([through(x, 6.0) for x in reach]))
    inside = reach[found.goes_in & ~found.by_rim]
    steep = through(5.0, 6.0)
    down = math.sqrt(2.0 * GRAVITY * 4.5)  # speed of the fall from 6 m to the opening, 4.5 m below
    slope = steep[0] / down  # horizontal distance per meter of fall
    spare = RADIUS * math.sqrt(1.0 + slope * slope)  # horizontal distance from a straight path to the edge
    assert inside.min() == pytest.approx(4.5 + spare, abs=0.008)  # the step, and the curvature of the path
    # at the back it may touch the wall below the rim after coming through
    assert inside.max() == pytest.approx(5.5 - RADIUS, abs=0.02)
    assert not fly(shots([(0.0, 0.0, 5.0)])).goes_in.any()


def test_ending_flights_early_does_not_change_which_shots_go_in_cleanly():
    """Shots that go in without touching the rim are the same whether or not other flights end early."""
    vel = [through(x, rise) for x in np.linspace(4.3, 5.7, 71) for rise in (2.0, 4.0)]
    all_of_them, some = fly(shots(vel), NET), fly(shots(vel), NET, clean=True)
    assert np.array_equal(all_of_them.goes_in & ~all_of_them.by_rim, some.goes_in & ~some.by_rim)
    assert all_of_them.goes_in.sum() > some.goes_in.sum(), "some go in by the rim"


def test_a_ball_that_falls_on_an_edge_goes_to_the_side_of_its_center():
    """The ball falls straight down for 0.5 s, a fraction of its radius off the edge."""
    for side, goes_in in ((1.0, True), (-1.0, False)):
        edge = 4.5 if side > 0.0 else 4.5 - THICKNESS
        found = fly(shots([(0.0, 0.0, 0.0)], pos=(edge + side * 0.06, 0.0, HEIGHT + RADIUS + 1.2)))
        assert found.by_rim[0] and not found.by_board[0]
        assert found.goes_in[0] == goes_in


def test_a_board_returns_long_shots_into_the_opening():
    """A long shot hits the board, reverses with half of its normal speed, and drops in."""
    flat = through(6.5, 2.5)
    assert not fly(shots([flat])).goes_in[0]
    found = fly(shots([flat]), NET)
    assert found.goes_in[0] and found.by_board[0] and not found.by_rim[0]
    assert found.vel[0, 0] == pytest.approx(-0.5 * flat[0], rel=0.06)  # restitution is within 0.03
    assert not fly(shots([through(5.6, 20.0)]), NET).goes_in[0]


def test_an_obstacle_in_front_of_the_opening_stops_a_shot():
    shot = through(5.0, 2.5)
    assert fly(shots([shot])).goes_in[0]
    found = fly(shots([shot]), wall((2.0, -1.0, 0.0), (2.1, 1.0, 4.0)))
    assert not found.goes_in[0] and found.by_rim[0] and not found.by_board[0]


def test_a_zone_with_downward_false_accepts_rising_shots():
    """A slot in a wall, open to the front: the parabola meets it rising at 45 degrees, with its apex a meter higher."""
    slot = ((1.0, -0.5, 1.2), (1.0, 0.5, 1.2), (1.0, 0.5, 1.8), (1.0, -0.5, 1.8))
    opening, inside = ShotOpening(corners=slot, approach=0.0), BoxZone((1.0, -0.5, 1.2), (1.5, 0.5, 2.5))
    field, time = StandingField.of((), CARPET), 0.25
    up = 1.0 / time + 0.5 * GRAVITY * time
    vel = [(1.0 / time, 0.0, up), (0.5 / time, 0.0, up)]
    rising = fly_shots(field, shots(vel), opening, inside, downward=False)
    assert rising.goes_in.tolist() == [True, True], "the second one falls into it, after having been over the slot"
    assert rising.time[0] == pytest.approx(time, abs=2e-3) and rising.vel[0, 2] > 1.0
    assert np.isnan(rising.time[1])
    assert fly_shots(field, shots(vel), opening, inside).goes_in.tolist() == [False, True]


@each(
    "corners",
    [SQUARE[:2], (*SQUARE[:3], (4.5, 0.5, HEIGHT + 0.1)), (SQUARE[0], SQUARE[2], SQUARE[1], SQUARE[3])],
)
def test_an_opening_must_be_flat_and_convex(corners):
    with pytest.raises(ConfigError, match="corners"):
        ShotOpening(corners=corners, approach=0.0)


def test_an_opening_contains_points_within_its_rim_for_either_order_of_corners():
    points = np.array([(5.0, 0.0, 2.0), (4.6, -0.4, 7.0), (4.4, 0.0, 2.0), (5.0, 0.6, 2.0)])
    for corners in (SQUARE, SQUARE[::-1]):
        opening = ShotOpening(corners=corners, approach=0.0)
        assert opening.holds(points).tolist() == [True, True, False, False]
        assert opening.inward == pytest.approx((0.0, 0.0, -1.0))
