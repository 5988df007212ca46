"""Preview of shots: predicted path and score of a piece that leaves a shooter now.

The preview uses the loop that moves the balls of the match. The piece touches the static field, but not robots or other
pieces. The predicted path ends when the piece scores or can no longer score.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from simcore.loop.state import make_memory
from simcore.match.match import Match
from simcore.pieces.flight import FLIGHT_STEP, LONGEST, PER_TICK, cannot_rise, flying_balls
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.launch import Launch
from simcore.robot.robot import Robot
from simcore.robot.shooter import Shooter
from simcore.typing import FloatArray
from simcore.units import TICK

__all__ = ["ShotPath", "ShotPreview"]

_AT_ONCE = 40  # number of flight steps between two checks of the wall time


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotPath:
    """Predicted path and result of a shot that leaves the shooter now."""

    robot: int
    """Number of the robot that shoots."""
    points: FloatArray
    """Path of the piece's center from the muzzle to the first contact or the score, field frame [m], shape (n, 3)."""
    landing: FloatArray
    """Last point of the path, field frame [m], shape (3,)."""
    zone: str = ""
    """Name of the zone in which the piece scores; empty for a miss."""
    worth: int = 0
    """Points that the piece would score now."""

    def __str__(self) -> str:
        """Return the result of the shot as one line of text."""
        if self.zone:
            return f"scores in {self.zone}, {self.worth} point{'' if self.worth == 1 else 's'}"
        x, y, z = self.landing.tolist()
        return f"misses, touches at x {x:.1f}, y {y:.1f}, height {z:.1f} m"


class ShotPreview:
    """Previews of all shooters of a match, computed in small steps during the run.

    Args:
        match: Match in progress; the previews do not change the match.
    """

    def __init__(self, match: Match) -> None:
        self._match = match
        self._found: dict[tuple[int, int], ShotPath] = {}
        self._steps = self._all()

    @property
    def paths(self) -> list[ShotPath]:
        """Latest preview of each shooter whose wheels are fast enough to shoot."""
        return list(self._found.values())

    def work(self, seconds: float) -> None:
        """Continue the computation of the previews for up to `seconds` of wall time [s], but at least by one step."""
        end = perf_counter() + seconds
        for _ in self._steps:
            if perf_counter() >= end:
                break

    def complete(self) -> list[ShotPath]:
        """Compute and return all previews for the current state."""
        for _ in self._once():
            pass
        self._steps = self._all()
        return self.paths

    # --- inside -------------------------------------------------------------------------------------------------

    def _all(self) -> Iterator[None]:
        while True:
            yield
            yield from self._once()

    def _once(self) -> Iterator[None]:
        for robot in self._match.robots:
            for number, shooter in enumerate(robot.shooters):
                if shooter.wheel_speed < shooter.config.min_wheel_speed:
                    self._found.pop((robot.number, number), None)
                else:
                    yield from self._one(robot, number, shooter)

    def _one(self, robot: Robot, shooter_number: int, shooter: Shooter) -> Iterator[None]:
        kind = self._kind_of_next(robot, shooter)
        now = Launch(barrel=0, delay=TICK, aim=shooter.aim)
        piece = shooter.released(now, radius=kind.bounding_radius, robot=robot.motion_at(1.0))
        pos, vel, spin = (np.array([one]) for one in (piece.pos, piece.vel, piece.rate))
        ball, memory, points = flying_balls(kind, pos, vel, spin), make_memory(1), [pos[0]]
        field, scored = self._match.world.balls.standing, None
        zones = [one for one in self._match.game.zones if not one.kinds or kind.name in one.kinds]
        lowest = min((one.zone.box[0][2] for one in zones), default=math.inf)
        for number in range(1, LONGEST + 1):
            before, was_touched = ball.pos.copy(), bool(ball.is_touched[0])
            field.fly(ball, memory, FLIGHT_STEP)
            falls = ball.pos[0, 2] < before[0, 2]
            hit = [one for one in zones if (falls or not one.downward) and one.zone.crossed(before, ball.pos)[0]]
            scored = hit[0] if hit else None
            if not was_touched and (scored or ball.is_touched[0] or number % PER_TICK == 0):
                points.append(ball.pos[0].copy())
            if scored or (ball.is_touched[0] and cannot_rise(ball, lowest, field.floor.gravity)[0]):
                break
            if number % _AT_ONCE == 0:
                yield
        self._found[robot.number, shooter_number] = ShotPath(
            robot=robot.number,
            points=np.array(points),
            landing=points[-1],
            zone="" if scored is None else scored.name,
            worth=0 if scored is None else self._match.rules.worth(scored),
        )

    def _kind_of_next(self, robot: Robot, shooter: Shooter) -> GamePieceConfig:
        """Return the kind of the next piece in the shooter's storage or, if it is empty, a kind the shooter accepts."""
        kinds = self._match.pieces.types
        held = robot.storage_of(shooter.config).in_turn
        if held:
            kind: GamePieceConfig = kinds[self._match.pieces.state.kind[held[0]]]
            return kind
        return next((kind for kind in kinds if kind.name in shooter.config.kinds), kinds[0])
