"""Human players at the outposts: they open the chute's door for robots that wait, and throw fuel at their hub."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from games.rebuilt import dimensions as dim
from games.rebuilt.field import FIELD, HUB_TARGET
from games.rebuilt.fuel import FUEL
from games.rebuilt.fuel_ways import own_first
from simcore.match.feeder import Feeder
from simcore.match.game import PlayedMatch
from simcore.match.scoring import Alliance
from simcore.pieces.pool import PieceStatus
from simcore.units import degrees

__all__ = ["HUMAN_PLAYERS", "HumanPlayers"]

HUMAN_PLAYERS = "human_players"
"""Option: human players feed and throw the fuel of their outposts, and what leaves the field is carried back."""

# Estimates.
_DUMP_PERIOD = 0.12  # [s] between two fuel through the open door: 24 in 3 s
_DUMP_SPEED = 1.2  # [m/s] at the end of a chute of 15 degrees
_DOOR_Y = 0.5 * dim.OUTPOST_OPENING_WIDTH - FUEL.bounding_radius
_WAITING, _REACH = 0.7, 1.3  # [m/s] and [m] from the wall, of a robot that waits for fuel
_THROW_PERIOD = 1.3  # [s]
_THROW_FROM = (-0.45, 1.5, 2.05)  # in the outpost area, with the arms up over the alliance wall [m]
_THROW_ELEVATION = degrees(55.0)
_THROW_ERROR = 0.07  # standard deviation, [rad] and share of the speed: 79 of 200 throws were hits
_AT_WALL = 0.05  # [m]; fuel this near to the opening of the corral rolls into it
_KEEPS = 8  # fuel that stays in the chute for robots while there are robots to feed


class HumanPlayers:
    """One at each outpost.

    Args:
        match: In which.
    """

    def __init__(self, match: PlayedMatch) -> None:
        self._match = match
        self._feeders: dict[Alliance, Feeder] = {}

    def begin(self) -> None:
        """Take the fuel that waits off the field, half of it each."""
        match = self._match
        waiting = np.nonzero(match.pieces.state.status == PieceStatus.STAGED)[0].tolist()
        half = (len(waiting) + 1) // 2
        for number, (alliance, rng) in enumerate(own_first(match)):
            slots = waiting[half:] if number else waiting[:half]
            clumsiness = match.draws.factor("human_players", number)
            self._feeders[alliance] = Feeder(match, slots, clumsiness=clumsiness, rng=rng)

    @property
    def stock(self) -> Mapping[Alliance, int]:
        """Fuel in each alliance's chute and corral."""
        return {alliance: feeder.stock for alliance, feeder in self._feeders.items()}

    def act(self) -> None:
        """Take what has come into the corrals, feed who waits, and throw while the own hub counts; once a tick."""
        match = self._match
        for alliance, feeder in self._feeders.items():
            feeder.take_off(self._in_corral(alliance))
            if not (match.timer.is_enabled and feeder.stock):
                continue
            if self._is_awaited(alliance):
                if feeder.is_due(_DUMP_PERIOD, "door"):
                    self._dump(alliance, feeder)
            elif feeder.stock > self._kept(alliance) and self._wants_throws(alliance):
                if feeder.is_due(_THROW_PERIOD, "throw"):
                    flipped = alliance == "red"
                    feeder.throw(
                        _THROW_FROM, HUB_TARGET, elevation=_THROW_ELEVATION, error=_THROW_ERROR, flipped=flipped,
                        hand="throw",
                    )  # fmt: skip

    # --- inside -----------------------------------------------------------------------------------------------------

    def _kept(self, alliance: Alliance) -> int:
        return _KEEPS if alliance in self._match.alliances else 0

    def _wants_throws(self, alliance: Alliance) -> bool:
        """Whether a throw of now will count; it flies for a second."""
        zone = next(zone for zone in self._match.game.zones if zone.alliance == alliance)
        return bool(self._match.rules.worth(zone))

    def _is_awaited(self, alliance: Alliance) -> bool:
        """Whether a robot of an alliance waits in front of its outpost."""
        match = self._match
        x, y = (0.0, dim.OUTPOST_Y) if alliance == "blue" else FIELD.symmetry.flip_point(0.0, dim.OUTPOST_Y)
        for robot, owner in zip(match.robots, match.alliances, strict=True):
            rx, ry, _ = robot.chassis.pose
            is_there = abs(rx - x) < _REACH and abs(ry - y) < 0.5 * dim.OUTPOST_OPENING_WIDTH
            if owner == alliance and is_there and robot.chassis.speed < _WAITING and robot.storage.room:
                return True
        return False

    def _dump(self, alliance: Alliance, feeder: Feeder) -> None:
        """Let a fuel roll out of the chute."""
        aside = min(max(0.15 * float(feeder.errors(1)[0]), -_DOOR_Y), _DOOR_Y)
        place = np.array([[FUEL.bounding_radius, dim.OUTPOST_Y + aside, dim.OUTPOST_OPENING_BOTTOM + 0.08]])
        down = degrees(15.0)
        vel = np.array([[_DUMP_SPEED * math.cos(down), 0.0, -_DUMP_SPEED * math.sin(down)]])
        if alliance == "red":
            place, vel = FIELD.symmetry.flip_points(place), FIELD.symmetry.flip_vectors(vel)
        feeder.put(place[0], velocity=vel[0], hand="door")

    def _in_corral(self, alliance: Alliance) -> list[int]:
        """Slots of the fuel in the corral's opening, which lies behind the wall."""
        state = self._match.pieces.state
        x, y = state.pos[:, 0], state.pos[:, 1]
        if alliance == "red":
            x, y = FIELD.size[0] - x, FIELD.size[1] - y
        near = (x < FUEL.bounding_radius + _AT_WALL) & (abs(y - dim.OUTPOST_Y) < 0.5 * dim.CORRAL_OPENING_WIDTH)
        near &= state.pos[:, 2] < dim.CORRAL_OPENING_BOTTOM + dim.CORRAL_OPENING_HEIGHT
        on_field = (state.status == PieceStatus.AWAKE) | (state.status == PieceStatus.ASLEEP)
        return [int(slot) for slot in np.nonzero(near & on_field)[0]]
