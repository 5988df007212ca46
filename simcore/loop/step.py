"""Main loop: advance the robots and balls of a world in steps of 1 ms.

In each step `advance_robots` applies forces to the velocities of all robots and swinging bodies, and these bodies drift
at their velocities. In the middle of the step `advance_balls` applies contact impulses to balls, and the opposite
impulses to robots and swinging bodies.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from simcore.loop.balls import advance_balls, any_moves, depth_at, drift_balls, end_balls, list_contacts
from simcore.loop.body import drift, kick_and_drift, update_axes
from simcore.loop.compiled import compiled, inner, preparing
from simcore.loop.robot_state import BODY, ROBOT, SPRING, SPRINGS, STEP, Fleet, Records, no_robots, records
from simcore.loop.robots import advance_robots, begin_robots, end_robots, settle
from simcore.loop.solids import NO_SOLIDS, Solids, find_in_box, first_hits
from simcore.loop.state import Balls, Floor, Memory, make_balls, make_memory

__all__ = ["advance", "prepare"]

_LISTED = 0.005  # longest use of one list of neighbors [s]


@compiled
def advance(fleet: Fleet, bodies: Records, balls: Balls, memory: Memory, solids: Solids, floor: Floor, h: float) -> int:
    """Advance all robots, swinging bodies and balls by h [s]; other bodies drift at constant velocity.

    Args:
        fleet: All robots.
        bodies: Robots, swinging bodies, and bodies of the engine, which drift at constant velocity.
        balls: All balls; only balls on the field move.
        memory: Contact memory of the balls.
        solids: Solids of the field and of bodies.
        floor: Floor and gravity.
        h: Duration [s].

    Returns:
        Index of the first robot with a position or velocity that is not finite, in which case nothing moves; -1 if all
            positions and velocities are finite.
    """
    lost = begin_robots(fleet, bodies)
    if lost >= 0:
        return lost
    for b in range(len(bodies)):
        if not bodies[b].model.is_robot and bodies[b].is_active:
            update_axes(bodies[b])
            for k in range(6):
                bodies[b].impulse[k] = 0.0
                bodies[b].mean_twist[k] = 0.0
    parts = max(1, math.ceil(h / _LISTED - 1e-9))
    for _ in range(parts):
        _advance_listed(fleet, bodies, balls, memory, solids, floor, h / parts, h)
    end_robots(fleet, h)
    for b in range(len(bodies)):
        for k in range(3):
            bodies[b].torque[k] = 0.0
    return -1


@compiled
def _advance_listed(fleet, bodies, balls, memory, solids, floor, h, call):
    """Advance robots and balls by h [s] with one list of possible contacts; the whole call lasts `call` [s]."""
    steps = math.ceil(h / STEP - 1e-9)
    dt = h / steps
    has_balls = any_moves(balls, bodies)
    listed, pairs = list_contacts(balls, bodies, solids, floor.with_pairs, h if has_balls else 0.0, dt)
    has_balls = has_balls and listed.size > 0
    force = np.zeros((balls.pos.shape[0] if has_balls else 0, 8))
    if has_balls:
        drift_balls(balls, listed, 0.5 * dt)
    for number in range(steps):
        advance_robots(fleet, bodies, solids, floor.is_there, floor.gravity, dt, dt / call)
        _part_robots(fleet, bodies)
        _drift_bodies(bodies, 0.5 * dt, call)
        if has_balls:
            ahead = dt if number + 1 < steps else 0.5 * dt
            advance_balls(balls, memory, solids, bodies, floor, listed, pairs, force, dt, ahead)
        _drift_bodies(bodies, 0.5 * dt, call)
    if has_balls:
        end_balls(balls, listed, h)


@inner
def _part_robots(fleet, bodies):
    """Shift robots out of initial overlaps with walls and other robots, without a change of velocity."""
    for r in range(len(fleet.robots)):
        body = bodies[fleet.robots[r].model.body]
        for k in range(3):
            body.com[k] += fleet.robots[r].shift[k]
            body.pos[k] += fleet.robots[r].shift[k]


@inner
def _drift_bodies(bodies, h, call):
    """Advance the poses of active bodies by h [s] at constant velocity, except sleeping swinging bodies.

    The function also updates the bodies' mean velocities over the call, which lasts `call` [s].
    """
    part = h / call
    for b in range(len(bodies)):
        body = bodies[b]
        if body.is_active and (body.is_awake or not body.model.swings):
            for k in range(3):
                body.mean_twist[k] += part * body.vel[k]
                body.mean_twist[3 + k] += part * body.rate[k]
            drift(body, h)


@cache
def prepare() -> None:
    """Compile the loop, or load the machine code from the cache, so that no tick waits for the compiler."""
    fleet = no_robots()._replace(robots=records(ROBOT), springs=records(SPRING, SPRINGS).reshape(1, SPRINGS))
    bodies, start = records(BODY), np.zeros((1, 3))
    for name in ("mass", "inertia"):
        bodies["model"][name] = 1.0
    bodies["quat"] = 0.0, 0.0, 0.0, 1.0
    balls, memory = make_balls(np.zeros(1, np.uint8), np.zeros((1, 3)), np.zeros((1, 3))), make_memory(1)
    floor = Floor(9.8, True, 1.0, 0.5, 0.0, True)
    with preparing("step.advance"):
        advance(fleet, bodies, balls, memory, NO_SOLIDS, floor, STEP)
        settle(fleet, 0, bodies, NO_SOLIDS, True, 9.8, 1.0)
        kick_and_drift(bodies, 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, STEP)
        depth_at(NO_SOLIDS, 0.0, 0.0, 0.0, 0.1)
        first_hits(NO_SOLIDS, bodies, True, start, start, False, -1, False, np.ones(1), np.zeros(1, np.int64))
        find_in_box(NO_SOLIDS, 0.0, 0.0, 0.0, 0.1, 0.1, 0.0, 0.1, np.zeros(0, np.uint8))
