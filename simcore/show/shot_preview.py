"""Where a shot would land if a piece left a shooter now, and whether it would score.

Through the air the piece flies by the equations that the engine's flights follow. From shortly before it touches
something on, a second engine with the same field plays it, with bounces, until it scores or lies. Pieces that lie on
the field are in nobody's way, and robots only in the air.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from simcore.match.match import Match
from simcore.match.motion import Motion
from simcore.match.scoring import ScoringTracker
from simcore.physics.world import PhysicsWorld
from simcore.pieces.aerodynamics import fly
from simcore.pieces.muzzle_clearance import free_share
from simcore.pieces.piece_manager import GamePieceManager
from simcore.pieces.shooter import Shooter
from simcore.pieces.shot_schedule import Launch
from simcore.robot.robot import Robot
from simcore.typing import FloatArray
from simcore.units import TICK

__all__ = ["ShotPath", "ShotPreview"]

_LONGEST_FLIGHT = 200  # ticks
_LONGEST_ROLL = 75  # ticks, from the first touch on


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotPath:
    """What a shot would do now."""

    robot: int
    """Number of the robot."""
    points: FloatArray
    """Centers of the piece from the muzzle to its first touch, or on to where it scores, field frame [m], (n, 3)."""
    landing: FloatArray
    """Where it first touches something, or scores, field frame [m], shape (3,)."""
    zone: str = ""
    """Name of the zone in which it scores; empty: it misses."""
    worth: int = 0
    """Points that this brings now."""

    def __str__(self) -> str:
        """One line."""
        if self.zone:
            return f"scores in {self.zone}, {self.worth} point{'' if self.worth == 1 else 's'}"
        x, y, z = self.landing.tolist()
        return f"misses, touches at x {x:.1f}, y {y:.1f}, height {z:.1f} m"


class ShotPreview:
    """Previews of all shooters of a match, worked out piece by piece beside the run. Close it.

    Args:
        match: Which is played; it is only looked at.
    """

    def __init__(self, match: Match) -> None:
        self._match = match
        self._world = PhysicsWorld(engine=match.world.engine.name)
        self._world.add_field(match.field.elements, drivable=match.game.field.drivable_in(match.field))
        kinds = [supply.kind for supply in match.game.pieces]
        self._pieces = GamePieceManager(self._world, [(kind, 1) for kind in kinds], field_size=match.game.field.size)
        for kind in kinds:
            self._pieces.hold(self._pieces.stage(kind.name, 1), 0)
        self._tracker = ScoringTracker(match.game.zones, kinds=[kind.name for kind in kinds])
        self._lowest_zone = min((zone.zone.bottom for zone in match.game.zones), default=0.0)
        self._found: dict[tuple[int, int], ShotPath] = {}
        self._steps = self._all()

    @property
    def paths(self) -> list[ShotPath]:
        """The newest of each shooter whose wheels turn fast enough to shoot."""
        return list(self._found.values())

    def work(self, seconds: float) -> None:
        """Go on for some wall time [s], at least by one step; the previews are renewed one after the other."""
        end = perf_counter() + seconds
        for _ in self._steps:
            if perf_counter() >= end:
                break

    def complete(self) -> list[ShotPath]:
        """Work out all previews for this very moment."""
        for robot in self._match.robots:
            for number, shooter in enumerate(robot.shooters):
                for _ in self._one(robot, number, shooter):
                    pass
        self._steps = self._all()
        return self.paths

    def close(self) -> None:
        """Free the engine; may be called twice."""
        self._world.close()

    # --- inside -------------------------------------------------------------------------------------------------

    def _all(self) -> Iterator[None]:
        while True:
            yield
            for robot in self._match.robots:
                for number, shooter in enumerate(robot.shooters):
                    yield from self._one(robot, number, shooter)

    def _one(self, robot: Robot, number: int, shooter: Shooter) -> Iterator[None]:
        if shooter.wheel_speed < shooter.config.min_wheel_speed:
            self._found.pop((robot.number, number), None)
            return
        slot = self._kind_of_next(robot, shooter)
        kind = self._pieces.types[slot]
        now = Launch(barrel=0, delay=TICK, aim=shooter.aim)
        piece = shooter.released(now, radius=kind.bounding_radius, robot=robot.motion_at(1.0))
        pos, vel = piece.pos, piece.vel
        points, zone = [pos], ""
        for _ in range(_LONGEST_FLIGHT):
            after, faster = fly(pos, vel, piece.spin, TICK, gravity=self._world.gravity, factors=kind.air)
            share = free_share(self._match.world, pos, after, kind.inner_radius, robot=robot.chassis.row)
            landing = np.array(pos) + share * (np.array(after) - pos)
            zone = self._scored(slot, np.array(pos), landing)
            if zone or share < 1.0:
                break
            points.append(after)
            pos, vel = after, faster
            yield
        points.append((float(landing[0]), float(landing[1]), float(landing[2])))
        if not zone:
            self._pieces.launch(0, pos, vel, piece.spin, slot=slot)
            tail = []
            for _ in range(_LONGEST_ROLL):
                before, here = self._step(slot)
                tail.append((float(here[0]), float(here[1]), float(here[2])))
                zone = self._scored(slot, before, here)
                if zone or (here[2] < 1.5 * kind.rest_height and self._lowest_zone > kind.bounding_radius):
                    break
                yield
            self._pieces.hold(np.array([slot]), 0)
            if zone:
                points += tail
                landing = np.array(tail[-1])
        worth = next((self._match.rules.worth(one) for one in self._match.game.zones if one.name == zone), 0)
        self._found[robot.number, number] = ShotPath(
            robot=robot.number, points=np.array(points), landing=landing, zone=zone, worth=worth
        )

    def _kind_of_next(self, robot: Robot, shooter: Shooter) -> int:
        """Number of the kind of piece that the shooter has next, or would have."""
        held = robot.storage_of(shooter.config).in_turn
        if held:
            return int(self._match.pieces.state.kind[held[0]])
        names = [kind.name for kind in self._pieces.types]
        return names.index(shooter.config.kinds[0]) if shooter.config.kinds else 0

    def _step(self, slot: int) -> tuple[FloatArray, FloatArray]:
        """A tick of the second engine; where the piece was and is [m]."""
        pieces = self._pieces
        Motion(self._world, pieces=pieces).tick()
        return pieces.state.before[slot].copy(), pieces.state.pos[slot].copy()

    def _scored(self, slot: int, start: FloatArray, end: FloatArray) -> str:
        events = self._tracker.update(0.0, np.array([slot]), start[None], end[None])
        self._tracker.reset()
        return events[0].zone if events else ""
