"""Human players at the outposts, who open the chute for waiting robots and throw fuel at the alliance's hub.

A user who controls a human player can also push fuel out through the corral's opening.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial

import numpy as np

from games.rebuilt import dimensions as dim
from games.rebuilt.field import FIELD, HUB_TARGET
from games.rebuilt.fuel import FUEL
from games.rebuilt.fuel_ways import own_first
from simcore.match.game import PlayedMatch
from simcore.match.human_actions import Feeder, HumanAction
from simcore.match.scoring import Alliance
from simcore.pieces.pool import PieceStatus
from simcore.units import degrees

__all__ = ["HUMAN_PLAYERS", "HumanPlayers"]

_AWAKE, _ASLEEP = int(PieceStatus.AWAKE), int(PieceStatus.ASLEEP)
HUMAN_PLAYERS = "human_players"
"""Name of the option with human players, who play the outposts' fuel, and field staff, who return lost fuel."""

# Estimates.
_DUMP_PERIOD = 0.12  # [s] between two fuel through the open door: 24 in 3 s
_DOOR_OPEN = 1.0  # [s]; time for which one request of a user opens the door: nine fuel
_PUSH_PERIOD = 0.5  # [s] between two fuel pushed out of the corral
_AT_WALL = 0.05  # [m]; fuel this close to the corral's opening rolls in
# Fuel out of each opening: distance from the wall [m], height [m], speed [m/s], downward angle [rad].
_CHUTE = (FUEL.bounding_radius, dim.OUTPOST_OPENING_BOTTOM + 0.08, 1.2, degrees(15.0))
_CORRAL = (FUEL.bounding_radius + 2.0 * _AT_WALL, FUEL.bounding_radius, 2.0, 0.0)
_DOOR_Y = 0.5 * dim.OUTPOST_OPENING_WIDTH - FUEL.bounding_radius
_WAITING, _REACH = 0.7, 1.3  # [m/s], [m]; top speed and distance from the wall of a robot that waits for fuel
_THROW_PERIOD = 1.3  # [s]
_THROW_FROM = (-0.45, 1.5, 2.05)  # [m]; in the outpost area, with the arms up over the alliance wall
_THROW_ELEVATION = degrees(55.0)
_THROW_ERROR = 0.07  # standard deviation, [rad] and relative to the speed: 79 of 200 throws were hits
_KEEPS = 8  # fuel kept in the chute while there are robots to feed


class HumanPlayers:
    """Human players at both outposts; each outpost starts with half of the fuel that is staged off the field.

    Args:
        match: Match with staged pieces.
    """

    def __init__(self, match: PlayedMatch) -> None:
        self._match = match
        self._feeders: dict[Alliance, Feeder] = {}
        self.actions = tuple(
            HumanAction(name=name, summary=summary, feeders=self._feeders, act=act, period=period, lasts=lasts)
            for name, summary, act, period, lasts in (
                ("OpenDoor", "open the chute's door", partial(self._roll, *_CHUTE), _DUMP_PERIOD, _DOOR_OPEN),
                ("ThrowFuel", "throw a fuel at the hub", self._throw, _THROW_PERIOD, 0.0),
                ("PushFuel", "push a fuel out of the corral", partial(self._roll, *_CORRAL), _PUSH_PERIOD, 0.0),
            )
        )
        """Actions of human players that the manual allows (G425)."""
        waiting = np.nonzero(match.pieces.state.status == PieceStatus.STAGED)[0].tolist()
        half = (len(waiting) + 1) // 2
        for number, (alliance, rng) in enumerate(own_first(match)):
            slots = waiting[half:] if number else waiting[:half]
            clumsiness = match.draws.factor("human_players", number)
            self._feeders[alliance] = Feeder(match, slots, clumsiness=clumsiness, rng=rng)

    @property
    def stock(self) -> Mapping[Alliance, int]:
        """Number of fuel in each alliance's chute and corral."""
        return {alliance: feeder.stock for alliance, feeder in self._feeders.items()}

    def act(self) -> None:
        """Take fuel from the corrals, feed waiting robots, and throw fuel while the alliance's hub is active.

        For a human player that a user controls, only take fuel from the corral. Call this method once a tick.
        """
        match, (door, throw, _), rolled_in = self._match, self.actions, self._in_corrals()
        for alliance, feeder in self._feeders.items():
            feeder.take_off(rolled_in[alliance])
            if alliance in match.persons:
                continue
            kept = _KEEPS if alliance in match.alliances else 0
            if self._is_awaited(alliance):
                door.take(match.timer, alliance)
            elif feeder.stock > kept and self._wants_throws(alliance):
                throw.take(match.timer, alliance)

    # --- internals --------------------------------------------------------------------------------------------------

    def _wants_throws(self, alliance: Alliance) -> bool:
        """Return whether fuel that enters the alliance's hub now counts."""
        zone = next(zone for zone in self._match.game.zones if zone.alliance == alliance)
        return bool(self._match.rules.worth(zone))

    def _is_awaited(self, alliance: Alliance) -> bool:
        """Return whether a robot of an alliance waits, with room for fuel, in front of the alliance's outpost."""
        match = self._match
        x, y = (0.0, dim.OUTPOST_Y) if alliance == "blue" else FIELD.symmetry.flip_point(0.0, dim.OUTPOST_Y)
        for robot, owner in zip(match.robots, match.alliances, strict=True):
            rx, ry, _ = robot.chassis.pose
            is_there = abs(rx - x) < _REACH and abs(ry - y) < 0.5 * dim.OUTPOST_OPENING_WIDTH
            if owner == alliance and is_there and robot.chassis.speed < _WAITING and robot.storage.room:
                return True
        return False

    def _throw(self, alliance: Alliance) -> None:
        """Throw a fuel at the hub, with random errors of direction and speed."""
        flip = FIELD.symmetry if alliance == "red" else None
        self._feeders[alliance].throw(
            _THROW_FROM, HUB_TARGET, elevation=_THROW_ELEVATION, error=_THROW_ERROR, flip=flip
        )

    def _roll(self, x: float, z: float, speed: float, dip: float, alliance: Alliance) -> None:
        """Release a fuel through an opening of an outpost at a random lateral position.

        Args:
            x: Distance from the alliance wall [m].
            z: Height [m].
            speed: Speed [m/s].
            dip: Angle of the velocity below the horizontal [rad].
            alliance: Alliance of the outpost.
        """
        feeder = self._feeders[alliance]
        aside = min(max(0.15 * float(feeder.errors(1)[0]), -_DOOR_Y), _DOOR_Y)
        place = np.array([[x, dim.OUTPOST_Y + aside, z]])
        vel = np.array([[speed * math.cos(dip), 0.0, -speed * math.sin(dip)]])
        if alliance == "red":
            place, vel = FIELD.symmetry.flip_points(place), FIELD.symmetry.flip_vectors(vel)
        feeder.put(place[0], velocity=vel[0])

    def _in_corrals(self) -> dict[Alliance, list[int]]:
        """Return the slots of fuel in the opening of each alliance's corral."""
        state, (length, width) = self._match.pieces.state, FIELD.size
        on_field = (state.status == _AWAKE) | (state.status == _ASLEEP)
        at_wall = np.abs(state.pos[:, 0] - 0.5 * length) > 0.5 * length - FUEL.bounding_radius - _AT_WALL
        slots = np.nonzero(on_field & at_wall)[0]
        found: dict[Alliance, list[int]] = {"blue": [], "red": []}
        for slot, (x, y, z) in zip(slots.tolist(), state.pos[slots].tolist(), strict=True):
            aside = (y if x < 0.5 * length else width - y) - dim.OUTPOST_Y
            if (
                abs(aside) < 0.5 * dim.CORRAL_OPENING_WIDTH
                and z < dim.CORRAL_OPENING_BOTTOM + dim.CORRAL_OPENING_HEIGHT
            ):
                found["blue" if x < 0.5 * length else "red"].append(slot)
        return found
