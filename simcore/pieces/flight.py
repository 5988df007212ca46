"""Flights of balls, many at once, by the loop that moves the balls of a match (`simcore.loop.balls`).

Each flies among what stands on the field, past all others and all that moves. `fly_shots` follows shots until it is
clear whether they score. A ball that leaves a muzzle in a match must be free there, which `muzzle_obstacle` says.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from simcore.loop.state import IN_FLIGHT, Balls, make_balls, make_memory
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.shot_opening import ShotOpening
from simcore.typing import BoolArray, FloatArray
from simcore.world.ball_dynamics import StandingField
from simcore.world.rotation import Vector
from simcore.world.world import PhysicsWorld
from simcore.world.zones import Zone

__all__ = [
    "FLIGHT_STEP",
    "LONGEST",
    "SQUEEZE",
    "ShotOutcomes",
    "cannot_rise",
    "fly_shots",
    "flying_balls",
    "muzzle_obstacle",
]

FLIGHT_STEP = 0.005
"""How finely flights are looked at [s]; the loop's own steps are shorter."""
PER_TICK = 4
"""Such steps in a tick, at whose end it is seen what has scored."""
LONGEST = 1200
"""Such steps after which a shot has missed: 6 s, as long as one to a height of 40 m."""
SQUEEZE = 0.9
"""Of a piece's radius that must be free where it leaves: a foam piece gives by the rest."""
_LEFT = 0.75  # of the balls still in flight, below which the others are left out of the arrays


def flying_balls(
    kind: GamePieceConfig, pos: FloatArray, vel: FloatArray, spin: FloatArray, *, mass: float | FloatArray = 1.0,
    diameter: float | FloatArray = 1.0, drag: float | FloatArray = 1.0,
) -> Balls:  # fmt: skip
    """Balls of a kind as they leave; what is no ball flies as the largest ball in it.

    As in a match the diameter changes what air does to a ball, and not its body.

    Args:
        kind: Of all.
        pos: Centers, field frame [m], shape (n, 3).
        vel: [m/s], shape (n, 3).
        spin: Angular velocities, field frame [rad/s], shape (n, 3).
        mass: Over that of the kind [-], of all or shape (n,).
        diameter: The same.
        drag: The same, of the drag coefficient.
    """
    balls, air = make_balls(np.full(len(pos), IN_FLIGHT, np.uint8), pos.copy(), vel.copy()), kind.air
    balls.is_ball[:], balls.spin[:], balls.radius[:], balls.foam[:] = 1, spin, kind.inner_radius, kind.foam
    balls.surface[:] = kind.friction, kind.restitution, kind.rolling
    balls.mass[:] = kind.mass * mass
    balls.air[:] = air
    balls.air[:, 0] *= drag * diameter**2 / mass
    balls.air[:, 1] *= diameter**3 / mass
    return balls


def cannot_rise(balls: Balls, height: float, gravity: float) -> BoolArray:
    """Which balls, squeezed by nothing, have not the energy to come to a height [m] any more, shape (n,)."""
    vel, rim = balls.vel, balls.radius[:, None] * balls.spin
    energy = 0.5 * np.einsum("ij,ij->i", vel, vel) + 0.2 * np.einsum("ij,ij->i", rim, rim)  # of a solid ball
    spent: BoolArray = (energy + gravity * (balls.pos[:, 2] - height) < 0.0) & (balls.contacts == 0)
    return spent


@dataclass(slots=True, kw_only=True)
class ShotOutcomes:
    """What became of n shots, one a row."""

    goes_in: BoolArray
    """Which of them scored."""
    by_board: BoolArray
    """Which touched something behind and above the opening before they came through it."""
    by_rim: BoolArray
    """Which touched anything else before: the rim, or what is in the way."""
    time: FloatArray
    """From the muzzle to the first way through the opening [s], NaN for those that do not come through it."""
    place: FloatArray
    """Where they come through the plane of the opening then [m], NaN for the others, shape (n, 3)."""
    vel: FloatArray
    """Velocity there [m/s], shape (n, 3)."""


def fly_shots(
    field: StandingField, balls: Balls, opening: ShotOpening, zone: Zone, *, downward: bool = True, clean: bool = False
) -> ShotOutcomes:
    """Fly shots until they score, or cannot any more.

    Args:
        field: Among what.
        balls: From their muzzles on; they are moved.
        opening: What they are to come through.
        zone: Where they score.
        downward: Whether only falling pieces score.
        clean: Whether what misses the opening, or touches the rim or something in the way, need not be followed on.
    """
    n = len(balls.status)
    found = ShotOutcomes(
        goes_in=np.zeros(n, dtype=bool), by_board=np.zeros(n, dtype=bool), by_rim=np.zeros(n, dtype=bool),
        time=np.full(n, np.nan), place=np.full((n, 3), np.nan), vel=np.full((n, 3), np.nan),
    )  # fmt: skip
    middle, inward = opening.middle, opening.inward
    ahead = np.array([math.cos(opening.approach), math.sin(opening.approach), 0.0])
    row, memory = np.arange(n), make_memory(n)
    for number in range(LONGEST):
        if number % PER_TICK == 0:
            as_it_began, is_over = balls.pos.copy(), np.zeros(len(row), dtype=bool)
        before, depth_before = balls.pos.copy(), (balls.pos - middle) @ inward
        field.fly(balls, memory, FLIGHT_STEP)
        depth = (balls.pos - middle) @ inward
        is_early = (balls.is_touched > 0) & np.isnan(found.time[row])
        balls.is_touched[:] = 0
        is_behind = (depth < -balls.radius) & ((balls.pos - middle) @ ahead > 0.0)
        found.by_board[row[is_early & is_behind]] = True
        found.by_rim[row[is_early & ~is_behind]] = True
        passes = np.nonzero((depth_before < 0.0) & (depth >= 0.0))[0]
        if len(passes):
            share = depth_before[passes] / (depth_before - depth)[passes]
            place = before[passes] + share[:, None] * (balls.pos - before)[passes]
            within = opening.holds(place)
            first = within & np.isnan(found.time[row[passes]])  # not again after a bounce out of it
            there = row[passes[first]]
            found.place[there], found.vel[there] = place[first], balls.vel[passes[first]]
            found.time[there] = FLIGHT_STEP * (number + share[first])
            is_over[passes[~within]] = clean
        if (number + 1) % PER_TICK == 0:
            falls = balls.pos[:, 2] < as_it_began[:, 2]
            scores = zone.crossed(as_it_began, balls.pos) & (falls | (not downward)) & (balls.status > 0)
            found.goes_in[row[scores]] = True
            is_over |= scores | (found.by_rim[row] & clean) | cannot_rise(balls, zone.box[0][2], field.floor.gravity)
            balls.status[is_over] = 0
            left = balls.status > 0
            if not left.any():
                break
            if np.count_nonzero(left) < _LEFT * len(row):
                balls, memory, row = balls.only(left), memory.only(left), row[left]
    return found


# --- what is in the way of a muzzle -----------------------------------------------------------------------------------


def _ball() -> FloatArray:
    """Center of a unit ball, and 14 points around it: along the axes and along the diagonals, shape (15, 3)."""
    corners = np.array(np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0])).reshape(3, -1).T / math.sqrt(3.0)
    return np.vstack([np.zeros((1, 3)), np.eye(3), -np.eye(3), corners])


_BALL = _ball()


def muzzle_obstacle(world: PhysicsWorld, inside: Vector, muzzle: Vector, radius: float, *, robot: int) -> int:
    """Row of the part of the field or the robot that keeps a piece from being at a muzzle, -1 if it is free.

    A wall may be between robot and muzzle, or the muzzle in it. So nothing may be met on the ways from a place inside
    of the robot, where no wall can be, to the piece's center and to points around it.

    Args:
        world: What may be in the way.
        inside: A place in the robot's body, field frame [m].
        muzzle: Center of the piece, field frame [m].
        radius: Of the largest ball in the piece [m].
        robot: Row of the robot that shoots.
    """
    ends = np.array(muzzle) + SQUEEZE * radius * _BALL
    _, rows = world.first_obstacles(np.repeat(np.array([inside]), len(ends), axis=0), ends, ignore=robot)
    return int(rows.max())
