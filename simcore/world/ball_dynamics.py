"""Balls of a world: state arrays, queries, and the exchange of impulses with the engine's bodies."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from simcore.loop.balls import depth_at
from simcore.loop.robot_state import BODY, no_robots, records
from simcore.loop.solids import Solids
from simcore.loop.state import Balls, Floor, Memory, make_balls, make_memory
from simcore.loop.step import advance, prepare
from simcore.typing import FloatArray
from simcore.units import GRAVITY
from simcore.world.bodies import Bodies
from simcore.world.contact_law import TerrainSurface
from simcore.world.engine import Engine
from simcore.world.rotation import IDENTITY, Vector, matrix
from simcore.world.solids_builder import SolidsBuilder

if TYPE_CHECKING:
    from simcore.world.field import FieldElement

__all__ = ["BallDynamics", "StandingField", "factors"]

_NO_ROBOTS, _NO_BODIES = no_robots(), records(BODY, 0)


def factors(surface: TerrainSurface) -> Vector:
    """Return friction [-], restitution [-] and rolling lever [m] of a surface, for contacts with balls."""
    return surface.friction, surface.restitution, surface.rolling


class StandingField(NamedTuple):
    """Static field for simulated test flights, without moving bodies and without contacts between balls."""

    solids: Solids
    floor: Floor

    @classmethod
    def of(cls, elements: Iterable[FieldElement], floor: TerrainSurface) -> StandingField:
        """Make a static field from field elements and the surface of the floor at z = 0."""
        prepare()
        builder = SolidsBuilder()
        for element in elements:
            builder.add(element.shape, element.position, IDENTITY, factors(element.surface))
        return cls(builder.solids, Floor(GRAVITY, True, *factors(floor), False))

    def fly(self, balls: Balls, memory: Memory, h: float) -> None:
        """Advance test balls, with their contact memory, by h [s]."""
        advance(_NO_ROBOTS, _NO_BODIES, balls, memory, self.solids, self.floor, h)


class BallDynamics:
    """Dynamics of all balls of a world.

    Args:
        bodies: Bodies that balls can touch.
        solids: Builder of the solids that balls can touch, other than the floor.
        floor: Surface of the floor at z = 0; None for no floor.
        gravity: Gravitational acceleration, downward [m/s^2].
    """

    def __init__(self, bodies: Bodies, solids: SolidsBuilder, floor: TerrainSurface | None, gravity: float) -> None:
        self._bodies, self._builder = bodies, solids
        friction, restitution, rolling = (0.0, 0.0, 0.0) if floor is None else factors(floor)
        self.floor = Floor(float(gravity), floor is not None, float(friction), float(restitution), float(rolling), True)
        self._others: list[int] = []  # numbers of the bodies other than robots that balls can touch in this tick
        self._fixed: set[int] = set()  # numbers of the sleeping bodies among `_others`
        self._turned: dict[
            int, FloatArray
        ] = {}  # last angular velocities of carriers, changed by the impulses of the loop
        self.balls = make_balls(np.zeros(0, np.uint8), np.zeros((0, 3)), np.zeros((0, 3)))
        """State of all balls."""
        self.memory = make_memory(0)
        """Contact memory of all balls."""

    def set_balls(self, balls: Balls) -> None:
        """Replace all balls of the world, and clear the contact memory."""
        if len(balls.status):
            prepare()
        self.balls, self.memory = balls, make_memory(len(balls.status))

    def depth(self, pos: Vector, radius: float) -> float:
        """Return the overlap of a ball at a position with the floor or static field [m], 0 without overlap."""
        depth = float(depth_at(self._builder.solids, *pos, radius))
        return max(depth, radius - pos[2]) if self.floor.is_there else depth

    def reach(self, row: int) -> float:
        """Return the largest distance of any point of a body from the origin of the body [m]."""
        return float(self._bodies.of(row)["model"]["reach"][0])

    def leave(self, ball: int, row: int) -> None:
        """Ignore contacts between a ball and a body until the ball no longer overlaps the body."""
        self.balls.leaves[ball] = self._bodies.number_of[row]

    def robots_touching(self, ball: int) -> list[int]:
        """Return the rows of the robots that a ball touched in this tick."""
        marks, marked = int(self.balls.bodies[ball]), self._bodies.records["model"]["mark"]
        return [self._bodies.rows[number] for number in self._bodies.robots if marks & int(marked[number])]

    # --- motion ---------------------------------------------------------------------------------------------------

    def begin_tick(self, others: list[int], fixed: list[int]) -> None:
        """Set the bodies that balls can touch in a tick, in addition to robots and bodies that carry robots.

        The method also clears the contact marks of the balls.

        Args:
            others: Rows of the bodies other than robots.
            fixed: Rows of the sleeping bodies among `others`.
        """
        self.balls.bodies[:] = 0
        bodies = self._bodies
        bodies.records["is_active"] = bodies.records["model"]["is_robot"]
        self._others = [number for number in map(bodies.number_of.__getitem__, others) if number not in bodies.carriers]
        bodies.records["is_active"][bodies.carriers] = 1
        bodies.records["is_active"][self._others] = 1
        self._fixed = {bodies.number_of[row] for row in fixed}

    def read_bodies(self, engine: Engine, h: float) -> None:
        """Read poses and velocities of the engine's bodies that balls or robots can touch, for a step of h [s].

        For bodies that carry robots, the method also computes the angular acceleration in the engine's last step.
        """
        bodies = self._bodies
        for number in (*self._others, *bodies.carriers):
            body = bodies.records[number]
            body["pos"], body["quat"] = engine.pose(bodies.rows[number])
            vel, body["rate"] = engine.velocity(bodies.rows[number])
            body["vel"] = (0.0, 0.0, 0.0) if body["model"]["swings"] else vel
            if body["model"]["carries"]:  # change by hinge and engine, without the impulses of the loop
                body["pull"] = (body["rate"] - self._turned.get(number, body["rate"])) / h
                self._turned[number] = body["rate"].copy()

    def push_bodies(self, engine: Engine) -> None:
        """Apply the impulses from the loop to the engine's bodies, before the engine's step, and wake these bodies.

        The method skips sleeping bodies that the loop treats as fixed.
        """
        bodies = self._bodies
        for number in (*self._others, *bodies.carriers):
            body = bodies.records[number]
            model, impulse = body["model"], body["impulse"]
            if number in self._fixed or not impulse.any():
                continue
            row = bodies.rows[number]
            pos, quat = engine.pose(row)
            axes = matrix(quat) @ model["principal"]
            turn = axes @ ((impulse[3:] @ axes) / model["inertia"])
            vel, rate = engine.velocity(row)
            spin = rate + turn
            linear = np.cross(spin, pos - model["center"]) if model["swings"] else vel + impulse[:3] / model["mass"]
            if model["carries"]:
                self._turned[number] += turn
            engine.wake(row)
            engine.set_velocity(row, linear.tolist(), spin.tolist())

    @property
    def standing(self) -> StandingField:
        """Static field of the world, for test flights of balls that are not part of the world."""
        return StandingField(self._builder.solids, self.floor._replace(with_pairs=False))

    def fly(self, balls: Balls, h: float) -> None:
        """Advance test balls by h [s] in the static field, without contacts with bodies or between balls."""
        self.standing.fly(balls, make_memory(len(balls.status)), h)
