"""Routes are short paths that keep the robot clear of field elements and of other robots."""

import math
from itertools import pairwise

import numpy as np
import pytest

from simcore.match.game import Game
from simcore.match.players.player import RouteMap
from simcore.world.field import box_element

WALL = box_element("wall", (7.9, 0.0, 0.0), (8.1, 5.0, 1.0))
GATE = box_element("gate", (3.9, 0.0, 0.7), (4.1, 8.0, 1.2))
RAMP = box_element("ramp", (11.0, 0.0, 0.0), (12.0, 8.0, 0.15))


def route_map(*elements, flipped=False, drivable=()):
    field = Game.bare(elements=elements, drivable=drivable).field
    return RouteMap(field, field.load().elements, height=0.5, flipped=flipped)


def length(start, way):
    return sum(math.dist(a, b) for a, b in pairwise([start, *way]))


def nearest(start, way, place):
    """Return the smallest distance of a route from a place [m]."""
    points = np.concatenate([np.linspace(a, b, 200) for a, b in pairwise([start, *way])])
    return float(np.hypot(*(points - place).T).min())


def test_a_route_in_the_open_or_under_a_gate_is_a_straight_line():
    assert route_map(WALL, GATE).route((2.0, 3.0), (6.0, 5.0)) == [(6.0, 5.0)]


def test_a_route_around_a_wall_is_as_long_as_the_tangents_to_its_end():
    """The way is two tangents to circles of 0.6 m about the corners of the wall's end, the arcs, and 0.2 m between.

    The grid's steps of 45 degrees may make it 8 % longer.
    """
    start, goal = (6.0, 2.0), (10.0, 2.0)
    way = route_map(WALL).route(start, goal)
    clear, away = 0.6, math.dist(start, (7.9, 5.0))
    turn = math.atan2(3.0, 1.9) + math.asin(clear / away)
    shortest = 2.0 * (math.sqrt(away**2 - clear**2) + clear * turn) + 0.2
    assert way[-1] == goal
    assert nearest(start, way, (8.0, 5.0)) > 0.4
    assert shortest * 0.97 < length(start, way) < shortest * 1.08


def test_a_route_avoids_other_robots_except_a_robot_at_its_goal():
    routes, start, goal, other = route_map(), (4.0, 4.0), (8.0, 4.0), (6.0, 4.05)
    assert nearest(start, routes.route(start, goal, [other]), other) > 0.8
    assert routes.route(start, goal, [(8.3, 4.0)]) == [goal]


def test_a_red_route_is_as_long_and_as_clear_as_the_flipped_blue_route():
    blue, red = route_map(WALL), route_map(WALL, flipped=True)
    start, goal = (6.1, 2.1), (10.1, 1.7)
    seen_start, seen_goal = ((16.0 - x, 8.0 - y) for x, y in (start, goal))
    way, seen = blue.route(start, goal), red.route(seen_start, seen_goal)
    assert length(seen_start, seen) == pytest.approx(length(start, way), rel=0.01), "of equal ways it may take another"
    assert nearest(seen_start, seen, (8.0, 3.0)) == pytest.approx(nearest(start, way, (8.0, 5.0)), abs=0.02)


def test_a_route_leads_out_of_an_obstacle():
    way = route_map(WALL).route((8.0, 1.0), (5.0, 1.0))
    assert way[-1] == (5.0, 1.0)


def test_the_map_reports_which_places_are_ramps_and_which_are_free():
    routes = route_map(WALL, RAMP, drivable=("ramp",))
    assert routes.is_ramp((11.5, 4.0)) and not routes.is_ramp((10.5, 4.0))
    assert routes.is_free((11.5, 4.0)) and routes.is_free((4.0, 4.0))
    assert not any(routes.is_free(place) for place in ((8.0, 2.0), (7.7, 2.0), (0.2, 4.0), (-1.0, 4.0)))
