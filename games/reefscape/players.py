"""Scripted players of REEFSCAPE, written for a blue robot."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Generator
from dataclasses import dataclass, field, replace
from typing import TypeAlias, TypeVar

import numpy as np

from games.reefscape import dimensions as dim
from games.reefscape.field import FIELD
from games.reefscape.handling import (
    NET_X,
    SETTINGS,
    before_algae,
    before_branch,
    before_station,
    hang,
    lower_claw,
    lower_wheel,
    make_ready,
    place_coral,
    process,
    put_in_net,
    raise_to,
    raise_to_net,
    take_algae,
    tuck,
)
from games.reefscape.places import BRANCH_ROWS, level_of
from games.reefscape.robot import ALGAE_REACH, PIVOT
from games.reefscape.rules import COOP_ALGAE, CORAL_A_LEVEL, MATCH, ReefscapeRules
from games.reefscape.staging import reef_algae_places
from simcore.match.game import Role
from simcore.match.players.player import SKILLS, Defense, Place, Player, idle, make_role
from simcore.match.scripted import Steps
from simcore.typing import BoolArray, FloatArray
from simcore.world.symmetry import Pose

__all__ = ["ROLES"]

Branch: TypeAlias = tuple[int, str, int]
"""Number of a reef face, side of the face (`left`, `middle` or `right`), and level."""
Spot: TypeAlias = tuple[str, float]
"""Station (`left` or `right`), and lateral offset from the station's center [m]."""
_T = TypeVar("_T")

_ROWS = {1: "trough", **BRANCH_ROWS}
_SPOTS: tuple[Spot, ...] = tuple((side, aside) for side in ("left", "right") for aside in (-0.48, 0.48))
_NET_YS = (4.9, 5.7, 6.5, 7.3)  # [m]
_PARKING_X = 8.05  # [m]; front bumper in the barge zone, robot in front of the cages
_THERE = 0.15  # [m]; distance from a place at which a player begins to handle a piece
_ROOM = 0.95  # [m]; distance between centers of robots that do not touch
_MARGIN = 0.45  # [m]; distance from walls at which a robot can take pieces
_OWN_SIDE = dim.FIELD_CENTER[0] - 1.0  # [m]; a robot that collects up to here does not go beyond the barge
_PLACING, _LOADING = 2.5, 2.0  # [s] in addition to the travel time
_LEVER = 0.4  # [m]; lateral placement error per heading error: a level 1 player then misses every second branch
_FOR_RANKING = 2.0  # bonus of a planning player for a coral on a level that a ranking point still needs [points]
_ALIGNING = 5.0  # time to align at a branch, in reaction times
_WAITS = 4.0  # [s] at a station
_CLIMB_TIME = 15.0  # [s] before the end
_PASSAGE = (dim.CAGE_YS[1] + dim.CAGE_YS[2]) / 2.0  # [m]; between two of the player's own cages
_REEF = FIELD.symmetry.flip_point(*dim.REEF_CENTER)  # center of the opponents' reef
_NEAR_ZONE = dim.REEF_ZONE_APOTHEM / math.cos(math.radians(30.0)) + 1.5  # [m] from the reef's center


@dataclass(slots=True)
class _Memory:
    """Failures of a player; the player tries places without failures first."""

    failed: Counter[Branch | Spot | int] = field(default_factory=Counter)
    """Number of failures at a branch, a station or a face's algae."""
    lying_until: float = -math.inf
    """Match time before which the player ignores coral on the carpet [s]."""


def _holds(player: Player, kind: str) -> bool:
    pieces = player.match.pieces
    return any(pieces.kind_name(slot) == kind for slot in player.robot.held)


def _is_free(player: Player, place: Place) -> bool:
    """Return whether the centers of all other robots are at least 0.95 m from a position."""
    return all(math.dist(other.place, place) > _ROOM for other in player.others)


def _travel_time(player: Player, place: Place) -> float:
    """Estimate the travel time to a position, with a detour if the reef is in the way [s]."""
    (x, y), reef = player.pose[:2], dim.REEF_CENTER
    along = (reef[0] - x) * (place[0] - x) + (reef[1] - y) * (place[1] - y)
    share = along / (player.away(place) ** 2 + 1e-9)
    nearest = (x + share * (place[0] - x), y + share * (place[1] - y))
    detour = max(0.0, 1.6 - math.dist(nearest, reef)) if 0.0 < share < 1.0 else 0.0
    return (player.away(place) + detour) / player.skill.speed


def _drive_to_best(
    player: Player, available: Callable[[], dict[_T, float]], pose: Callable[[_T], Pose], *, timeout: float = 8.0
) -> Generator[None, None, _T | None]:
    """Drive to the place with the highest value, or to the next best place if this place becomes unavailable.

    Args:
        player: Player that drives.
        available: Function that returns the value of each available place.
        pose: Function that returns the robot's pose at a place.
        timeout: Time limit [s].

    Returns:
        Place that the robot has reached; None if the robot has reached no place within the time limit.
    """
    chosen: _T | None = None

    def goal() -> Pose | None:
        nonlocal chosen
        worth = available()
        if chosen not in worth:
            chosen = max(worth, key=worth.__getitem__, default=None)
        return None if chosen is None else pose(chosen)

    yield from player.pursue(goal, near=_THERE, timeout=timeout)
    player.stop()
    return chosen if chosen is not None and player.away(pose(chosen)[:2]) < 1.5 * _THERE else None


# --- coral --------------------------------------------------------------------------------------------------------


def _branches(player: Player, memory: _Memory) -> dict[Branch, float]:
    """Return the value of each free branch and trough without a robot or coral in front of the place.

    The value is the number of points per second, reduced after failures. A planning player adds a bonus to the points
    on levels that a ranking point still needs.
    """
    counts, worth = player.match.pieces.places.counts(), {}
    highest = min(4, 2 + SKILLS.index(player.skill))
    in_the_way = player.seen_pieces["Coral"][:, :2]
    for level, row in _ROWS.items():
        taken = counts[level_of(player.alliance, row)]
        points = level + 1 + _FOR_RANKING * player.skill.planning * (taken.sum() < CORAL_A_LEVEL)
        for free in np.nonzero(taken == 0)[0].tolist():  # also for troughs, where one coral would block the next
            number = free if level > 1 else 2 * free
            side = "middle" if level == 1 else "right" if number % 2 else "left"
            branch = (-(number // 2) % 6, side, level)
            x, y, yaw = before_branch(*branch)
            before = x + 0.8 * math.cos(yaw), y + 0.8 * math.sin(yaw)  # between the robot and the reef
            if level > highest or not _is_free(player, (x, y)) or (np.hypot(*(in_the_way - before).T) < 0.45).any():
                continue
            worth[branch] = points / (_PLACING + _travel_time(player, (x, y))) * 0.4 ** memory.failed[branch]
    return worth


def _score(player: Player, memory: _Memory) -> Steps:
    """Drive to the best branch or trough, and place the coral there; record a failure."""

    def pose(branch: Branch) -> Pose:
        place = before_branch(*branch)
        if player.away(place[:2]) < 1.2:
            raise_to(player, branch[2])
        return place

    tuck(player)
    branch = yield from _drive_to_best(player, lambda: _branches(player, memory), pose)
    if branch is None:
        yield from player.wait(player.skill.reaction)
        return
    yield from player.wait(_ALIGNING * player.skill.reaction)
    error = player.skill.aim * _LEVER * float(player.rng.standard_normal())
    yield from place_coral(player, *branch, error=error)
    if branch[2] > 1 or _holds(player, "Coral"):  # counts all attempts: only a branch that failed is free again
        memory.failed[branch] += 1


def _can_be_taken(places: FloatArray) -> BoolArray:
    """Return whether a blue player may take pieces at each position (n, 2) [m], shape (n,).

    The player takes pieces on the blue side of the field, away from walls.
    """
    x, y = places.T
    inside: BoolArray = (x > _MARGIN) & (x < _OWN_SIDE) & (y > _MARGIN) & (y < dim.FIELD_WIDTH - _MARGIN)
    return inside


def _stations(player: Player, memory: _Memory) -> dict[Spot, float]:
    """Return the value of each free spot at the stations; the value decreases with travel time and failures."""
    return {
        spot: 0.5 ** memory.failed[spot] / (_LOADING + _travel_time(player, place))
        for spot in _SPOTS
        for place in [before_station(*spot)[:2]]
        if _is_free(player, place)
    }


def _fetch(player: Player, memory: _Memory) -> Steps:
    """Fetch a coral: off the carpet if a coral there is nearer than the stations, otherwise from a station."""
    make_ready(player)
    lying = player.seen_pieces["Coral"][:, :2]
    lying = lying[_can_be_taken(lying)]
    nearest = min((_travel_time(player, (x, y)) for x, y in lying.tolist()), default=math.inf)
    stations = _stations(player, memory)
    if player.time > memory.lying_until and nearest < 1.0 / max(stations.values(), default=0.01):
        lower_claw(player)
        yield from player.collect(_can_be_taken, until=lambda: _holds(player, "Coral"), timeout=5.0, kind="Coral")
        if not _holds(player, "Coral"):
            memory.lying_until = player.time + 8.0
        player.intake(False)
        tuck(player)
        return
    tuck(player)
    player.intake(True)
    spot = yield from _drive_to_best(player, lambda: _stations(player, memory), lambda spot: before_station(*spot))
    if spot is not None:
        pose = before_station(*spot)
        ends = player.match.time + _WAITS
        while player.match.time < ends and not _holds(player, "Coral"):
            player.steer_along([pose[:2]], pose[2], speed=0.6)
            yield
        yield from player.wait(player.skill.reaction)
        memory.failed[spot] = 0 if _holds(player, "Coral") else memory.failed[spot] + 1
    player.intake(False)


def scorer(player: Player, until: float = math.inf) -> Steps:
    """Bring coral from the stations and the carpet to the reef, until a match time [s]."""
    memory = _Memory()
    make_ready(player)
    yield
    while player.time < until:
        yield from _cycle(player, memory)
        yield


def _cycle(player: Player, memory: _Memory) -> Steps:
    yield from _score(player, memory) if _holds(player, "Coral") else _fetch(player, memory)


# --- algae --------------------------------------------------------------------------------------------------------


def _algae_at(places: FloatArray, place: FloatArray) -> bool:
    return bool((np.linalg.norm(places - place, axis=1) < 0.15).any()) if len(places) else False


def _faces(player: Player, memory: _Memory) -> dict[int, float]:
    """Return the value of each face of the reef with an algae and without a robot in front.

    The value decreases with travel time and failures.
    """
    places = player.piece_positions("Algae")
    return {
        face: 0.3 ** memory.failed[face] / (1.0 + _travel_time(player, before_algae(face)[:2]))
        for face, place in enumerate(reef_algae_places())
        if _algae_at(places, place) and _is_free(player, before_algae(face)[:2])
    }


def _lying_algae(player: Player) -> list[tuple[float, float, float]]:
    """Return the positions of algae on the carpet and on the coral at the marks, nearest first, field frame [m]."""
    places = player.piece_positions("Algae")
    low = places[(places[:, 2] < 0.6) & _can_be_taken(places[:, :2])]
    return sorted(((x, y, z) for x, y, z in low.tolist()), key=lambda place: player.away(place[:2]))


def _take_lying(player: Player) -> Steps:
    """Drive to the nearest loose algae, and take the algae with the algae wheel."""

    def goal() -> Pose | None:
        places = _lying_algae(player)
        if not places or _holds(player, "Algae"):
            return None
        x, y, z = places[0]
        lower_wheel(player, z)
        yaw, out = math.atan2(y - player.pose[1], x - player.pose[0]), PIVOT[0] + ALGAE_REACH - 0.05
        return x - out * math.cos(yaw), y - out * math.sin(yaw), yaw

    yield from player.pursue(goal, speed=player.skill.collecting_speed, near=0.0, timeout=6.0)
    player.stop()
    tuck(player)


def _bring_algae(player: Player) -> Steps:
    """Bring the algae to the processor, or to the net.

    A player with foresight uses the net after the alliance has met the coopertition criterion. A player without
    foresight always uses the processor.
    """

    def before_net(y: float) -> Pose:
        if player.away((NET_X, y)) < 1.8:
            raise_to_net(player)
        return NET_X - 0.6, y, 0.0

    rules = player.match.rules
    assert isinstance(rules, ReefscapeRules)
    if player.skill.foresight == 0.0 or rules.processed(player.alliance) < COOP_ALGAE:
        yield from player.travel(dim.PROCESSOR_X, 1.3, -math.pi / 2, near=_THERE)
        yield from process(player)
        yield from player.drive_to(dim.PROCESSOR_X, 1.2, -math.pi / 2, speed=2.0, tolerance=0.12)
    else:
        y = yield from _drive_to_best(
            player,
            lambda: {y: -player.away((NET_X, y)) for y in _NET_YS if _is_free(player, (NET_X - 0.5, y))},
            before_net,
        )
        if y is not None:
            yield from put_in_net(player, y)
            yield from player.drive_to(NET_X - 0.6, y, 0.0, speed=2.0, tolerance=0.12)
    tuck(player)


def algae(player: Player) -> Steps:
    """Bring algae from the reef and the carpet to the processor and the net, and score coral when no algae are left."""
    memory = _Memory()
    make_ready(player)
    yield
    while True:
        if _holds(player, "Algae"):
            yield from _bring_algae(player)
        elif _holds(player, "Coral"):
            yield from _score(player, memory)
        elif faces := _faces(player, memory):
            player.set_volts("claw", 0.0)
            lying = _lying_algae(player)
            if lying and player.away(lying[0][:2]) / player.skill.speed + 1.0 < 1.0 / max(faces.values()):
                yield from _take_lying(player)
            else:
                face = yield from _drive_to_best(player, lambda: _faces(player, memory), before_algae)
                if face is not None:
                    yield from take_algae(player, face)
                    memory.failed[face] += not _holds(player, "Algae")
        elif _lying_algae(player):
            yield from _take_lying(player)
        else:
            yield from _fetch(player, memory)
        yield


# --- end of the match, and defense --------------------------------------------------------------------------------


def parker(player: Player) -> Steps:
    """Score coral, and park in the barge zone at the end of the match."""
    yield from scorer(player, until=MATCH.duration - 4.0 - 7.0 / player.skill.speed)
    player.intake(False)
    tuck(player)
    while True:
        yield from _drive_to_best(
            player,
            lambda: {y: -player.away((_PARKING_X, y)) for y in _NET_YS if _is_free(player, (_PARKING_X, y))},
            lambda y: (_PARKING_X, y, 0.0),
        )
        yield from player.wait(1.0)


def climber(player: Player) -> Steps:
    """Score coral, and hang on a cage at the end of the match."""
    yield from scorer(player, until=MATCH.duration - _CLIMB_TIME - 7.0 / player.skill.speed)
    player.intake(False)
    tuck(player)
    player.set_position("elevator", 0.0)
    y = None
    while y is None:
        y = yield from _drive_to_best(
            player,
            lambda: {y: -player.away((dim.CAGE_X, y)) for y in dim.CAGE_YS if _is_free(player, (dim.CAGE_X - 0.5, y))},
            lambda y: (dim.CAGE_X - 1.3, y, math.pi),
        )
        yield
    yield from hang(player, y)
    while True:
        yield


def _spares_opponent(player: Player, place: Place) -> bool:
    """Return whether a defender stays away from an opponent at a position.

    The defender avoids opponents near the opponents' reef (G427), and opponents between this reef and midfield.
    """
    ahead = 0.8 * player.skill.reaction
    return math.dist(place, _REEF) < _NEAR_ZONE + ahead or place[0] < _REEF[0]


_DEFENSE = Defense(goal=_REEF, retreat=(16.4, 4.03), is_left_alone=_spares_opponent)


def defender(player: Player) -> Steps:
    """Block opponents that drive to the opponents' reef, without fouls G403, G425 and G427.

    In auto, the defender scores the preload on the blue side. In teleop, the defender crosses midfield between two blue
    cages.
    """
    memory = _Memory()
    make_ready(player)
    yield
    while player.time < MATCH.start("teleop"):
        if _holds(player, "Coral"):
            yield from _score(player, memory)
        yield
    tuck(player)
    while player.pose[0] < dim.FIELD_CENTER[0] + 1.0:
        yield from player.travel(7.7, _PASSAGE, 0.0, near=0.05, timeout=6.0)
        yield from player.drive_to(dim.FIELD_CENTER[0] + 1.2, _PASSAGE, 0.0, speed=1.5, timeout=4.0)
    yield from player.travel(_REEF[0], 7.3, 0.0, near=0.4)
    yield from _DEFENSE.play(player)


_SETTINGS = replace(SETTINGS, intake_x=0.5)  # a robot that collects from the carpet drives forward

ROLES: dict[str, Role] = {
    role.name: role
    for role in (
        make_role(scorer, "brings coral from stations and carpet to its reef, as high as it can", _SETTINGS),
        make_role(algae, "brings algae to its processor and its net", _SETTINGS),
        make_role(defender, "pushes opponents away from their reef, without fouls G403, G425 and G427", _SETTINGS),
        make_role(parker, "a scorer that stands in its barge zone as the match ends", _SETTINGS),
        make_role(climber, "a scorer that hangs on a cage as the match ends", _SETTINGS),
        make_role(idle, "stands still", _SETTINGS),
    )
}
"""Roles of scripted players, by name."""
