"""Flights of many shots at once: the equation of motion, and what rim and boards do."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from simcore.errors import ConfigError
from simcore.geometry.zones import BoxZone, CylinderZone
from simcore.physics.contact_law import WALL, TerrainSurface
from simcore.pieces.aerodynamics import AirFactors
from simcore.pieces.flight import FlightState
from simcore.pieces.shot_opening import Panel, ShotOpening, fly_to_opening
from simcore.units import GRAVITY

RADIUS, HEIGHT = 0.1, 2.0
SQUARE = ((4.5, -0.5, HEIGHT), (5.5, -0.5, HEIGHT), (5.5, 0.5, HEIGHT), (4.5, 0.5, HEIGHT))
ZONE = CylinderZone((5.0, 0.0), 1.0, 1.0, 1.8)
BALL = TerrainSurface(name="BALL", friction=0.0, restitution=0.5)
STIFF = TerrainSurface(name="STIFF", friction=0.0, restitution=1.0)
NET = Panel(corners=((5.5, -1.0, 1.0), (5.5, 1.0, 1.0), (5.5, 1.0, 4.0), (5.5, -1.0, 4.0)), surface=STIFF)


def shots(vel, drag=0.0, pos=(0.0, 0.0, 0.5)):
    vel = np.atleast_2d(np.array(vel, dtype=float))
    n = len(vel)
    air = AirFactors(drag=np.full(n, drag), lift=np.zeros(n), lift_saturation=np.zeros(n))
    pos, spin = np.repeat([pos], n, axis=0), np.zeros((n, 3))
    return FlightState(pos=pos, vel=vel, spin=spin, radius=np.full(n, RADIUS), air=air)


def fly(rows, **parts):
    opening = ShotOpening(corners=SQUARE, approach=0.0, **parts)
    return fly_to_opening(rows, opening, ZONE, BALL, gravity=GRAVITY)


def through(x, rise):
    """Velocity without drag that comes down through the plane of the opening at x, after having risen so far [m]."""
    up = math.sqrt(2.0 * GRAVITY * rise)
    time = up / GRAVITY + math.sqrt(2.0 * (rise - (HEIGHT - 0.5)) / GRAVITY)
    return (x / time, 0.0, up)


def test_flights_are_those_of_the_equation_of_motion():
    """The midpoint rule stays within 1 mm of an exact integration."""
    k, vel = 0.03, (4.5, 0.3, 8.0)

    def law(t, y):
        return [*y[3:], *(-k * np.linalg.norm(y[3:]) * y[3:] - [0.0, 0.0, GRAVITY])]

    def falls_through(t, y):
        return y[2] - HEIGHT if y[5] < 0.0 else 1.0

    falls_through.terminal = True
    exact = solve_ivp(law, (0.0, 5.0), [0.0, 0.0, 0.5, *vel], rtol=1e-10, atol=1e-12, events=falls_through)
    found = fly(shots(vel, drag=k))
    # the crossing lies on the chord of a tick: g dt^2 / 8 = 0.5 mm above the arc at most
    assert found.time[0] == pytest.approx(exact.t_events[0][0], abs=2e-4)
    assert found.place[0] == pytest.approx(exact.y_events[0][0][:3], abs=1e-3)


def test_the_surface_of_a_ball_clears_the_rim_before_and_behind():
    """A steep shot must pass a radius inside of both edges, and the last one a little more on its way down."""
    reach = np.linspace(4.3, 5.7, 281)
    found = fly(shots([through(x, 6.0) for x in reach]))
    inside = reach[found.goes_in & ~found.by_rim]
    steep = through(5.0, 6.0)
    down = math.sqrt(2.0 * GRAVITY * 4.5)  # speed of the fall from 6 m to the opening, 4.5 m below
    slope = steep[0] / down  # along the floor for each meter down
    spare = RADIUS * math.sqrt(1.0 + slope * slope)  # along the floor, from a straight path to the edge
    assert inside.min() == pytest.approx(4.5 + spare, abs=0.006)  # the step, and the path's curvature
    assert inside.max() == pytest.approx(5.5 - spare, abs=0.006)
    assert not fly(shots([(0.0, 0.0, 5.0)])).goes_in.any()


def test_the_rim_bounces_a_shot_about_the_line_from_it_to_the_middle_of_the_ball():
    """Straight down on an edge, a share of the radius aside: without friction, only the speed along that line turns."""
    fall, aside = 0.5, 0.06
    found = {}
    for side in (1.0, -1.0):
        place = (4.5 + side * aside, 0.0, HEIGHT + math.sqrt(RADIUS**2 - aside**2) + 0.5 * GRAVITY * fall**2)
        found[side] = fly(shots([(0.0, 0.0, 0.0)], pos=place))
        assert found[side].by_rim[0]
    assert found[1.0].goes_in[0] and not found[-1.0].goes_in[0]
    # e = 0.5 x that of a wall along (0.6, 0.8); the rest of the way is a parabola down to the rim's height
    keep, speed = 0.5 * WALL.restitution, GRAVITY * fall
    along = 0.8 * speed * (1.0 + keep)
    vx, vz = 0.6 * along, 0.8 * along - speed
    assert found[1.0].vel[0, 0] == pytest.approx(vx, rel=0.02)
    down = math.sqrt(vz**2 + 2.0 * GRAVITY * 0.08)
    assert found[1.0].vel[0, 2] == pytest.approx(-down, rel=0.06)


def test_a_board_sends_shots_back_in():
    """What flies too far meets it, keeps half of its speed toward it the other way round, and drops in."""
    flat = through(6.5, 2.5)
    assert not fly(shots([flat])).goes_in[0]
    found = fly(shots([flat]), boards=(NET,))
    assert found.goes_in[0] and found.by_board[0]
    assert found.vel[0, 0] == pytest.approx(-0.5 * flat[0])
    over = fly(shots([through(5.6, 20.0)]), boards=(NET,))
    assert not over.goes_in[0]


def test_what_comes_up_through_the_opening_has_not_gone_in():
    """Its way leads through the wall below the rim, as that of a robot that stands under it."""
    found = fly(shots([through(0.2, 2.5)], pos=(4.8, 0.0, 0.5)))
    assert not found.goes_in[0]


def test_a_zone_that_does_not_ask_for_falling_pieces_takes_shots_on_their_way_up():
    """A slot in a wall, open to the front: the parabola is in it at 45 degrees up, and would top out a meter higher."""
    slot = ((1.0, -0.5, 1.2), (1.0, 0.5, 1.2), (1.0, 0.5, 1.8), (1.0, -0.5, 1.8))
    opening, inside = ShotOpening(corners=slot, approach=0.0), BoxZone((1.0, -0.5, 1.2), (1.5, 0.5, 2.5))
    time, up = 0.25, 1.0 / 0.25 + 0.5 * GRAVITY * 0.25
    rows = shots([(1.0 / time, 0.0, up), (0.5 / time, 0.0, up)])
    rising = fly_to_opening(rows, opening, inside, BALL, downward=False)
    assert rising.goes_in.tolist() == [True, False]
    assert rising.time[0] == pytest.approx(time, abs=2e-3) and rising.vel[0, 2] > 1.0
    assert not fly_to_opening(rows, opening, inside, BALL).goes_in.any()


@pytest.mark.parametrize(
    "corners",
    [SQUARE[:2], (*SQUARE[:3], (4.5, 0.5, HEIGHT + 0.1)), (SQUARE[0], SQUARE[2], SQUARE[1], SQUARE[3])],
    ids=["two", "not flat", "crossed"],
)
def test_an_opening_is_flat_and_convex(corners):
    with pytest.raises(ConfigError, match="corners"):
        ShotOpening(corners=corners, approach=0.0)
