"""Where a shot would land if a piece left a shooter now, and whether it would score.

The piece flies by the equations that the match's flights follow, until it is in a zone or something is in its way. At a
zone with an opening it goes on by `fly_to_opening`, off boards and the walls of a funnel. Pieces that lie on the field
are in nobody's way.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from simcore.match.match import Match
from simcore.match.scoring import ScoringZone
from simcore.pieces.aerodynamics import AirFactors
from simcore.pieces.flight import FlightState, free_shares, path
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.launch import Launch
from simcore.pieces.shooter import Shooter
from simcore.pieces.shot_opening import fly_to_opening
from simcore.robot.robot import Robot
from simcore.typing import FloatArray
from simcore.units import TICK

__all__ = ["ShotPath", "ShotPreview"]

_LONGEST = 200  # ticks
_AT_ONCE = 10  # ticks of a flight whose surroundings are asked for in one step of work


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotPath:
    """What a shot would do now."""

    robot: int
    """Number of the robot."""
    points: FloatArray
    """Centers of the piece from the muzzle to its first touch, or to where it scores, field frame [m], (n, 3)."""
    landing: FloatArray
    """The last of them [m], shape (3,)."""
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
    """Previews of all shooters of a match, worked out bit by bit beside the run.

    Args:
        match: Which is played; it is only looked at.
    """

    def __init__(self, match: Match) -> None:
        self._match = match
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

    def _one(self, robot: Robot, number: int, shooter: Shooter) -> Iterator[None]:
        kind = self._kind_of_next(robot, shooter)
        now = Launch(barrel=0, delay=TICK, aim=shooter.aim)
        piece = shooter.released(now, radius=kind.bounding_radius, robot=robot.motion_at(1.0))
        pos, vel, spin = (np.array([one]) for one in (piece.pos, piece.vel, piece.rate))
        air = AirFactors(*(np.array([one]) for one in kind.air))
        shot = FlightState(pos=pos, vel=vel, spin=spin, radius=np.array([kind.bounding_radius]), air=air)
        points = path(shot, _LONGEST, gravity=self._match.world.gravity)[:, 0]
        start, end, share = points[:-1], points[1:].copy(), np.ones(_LONGEST)
        for first in range(0, _LONGEST, _AT_ONCE):
            legs = slice(first, first + _AT_ONCE)
            share[legs] = free_shares(
                self._match.world, start[legs], end[legs], kind.inner_radius, robot=robot.chassis.row
            )
            if (share[legs] < 1.0).any():
                break
            yield
        last = int(np.argmax(share < 1.0)) if (share < 1.0).any() else _LONGEST - 1
        end[last] = start[last] + share[last] * (end[last] - start[last])
        zone = None
        for one in self._match.game.zones:
            if one.kinds and kind.name not in one.kinds:
                continue
            a, b = start[: last + 1], end[: last + 1]
            crossed = np.nonzero(one.zone.crossed(a, b) & ((b[:, 2] < a[:, 2]) | (not one.downward)))[0]
            if len(crossed):
                zone, last = one, int(crossed[0])
            elif zone is None and self._drops_in(shot, kind, one, end[last]):
                zone = one
        self._found[robot.number, number] = ShotPath(
            robot=robot.number,
            points=np.vstack([start[: last + 1], end[last]]),
            landing=end[last],
            zone="" if zone is None else zone.name,
            worth=0 if zone is None else self._match.rules.worth(zone),
        )

    def _drops_in(self, shot: FlightState, kind: GamePieceConfig, zone: ScoringZone, touch: FloatArray) -> bool:
        """Whether a shot that first touches something at an opening goes into it."""
        if zone.opening is None or np.linalg.norm(touch - zone.opening.middle) > zone.opening.reach:
            return False
        gravity, downward = self._match.world.gravity, zone.downward
        flown = fly_to_opening(shot, zone.opening, zone.zone, kind.surface, downward=downward, gravity=gravity)
        return bool(flown.goes_in[0])

    def _kind_of_next(self, robot: Robot, shooter: Shooter) -> GamePieceConfig:
        """The kind of piece that the shooter has next, or would have."""
        kinds = self._match.pieces.types
        held = robot.storage_of(shooter.config).in_turn
        if held:
            kind: GamePieceConfig = kinds[self._match.pieces.state.kind[held[0]]]
            return kind
        return next((kind for kind in kinds if kind.name in shooter.config.kinds), kinds[0])
