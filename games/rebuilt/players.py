"""Scripted players of REBUILT, written for a blue robot."""

from __future__ import annotations

import math

import numpy as np

from games.rebuilt import dimensions as dim
from games.rebuilt.autos import SETTINGS
from games.rebuilt.field import FIELD, HUB_TARGET
from games.rebuilt.robot import CLIMBER, climbing_robot
from games.rebuilt.rules import RebuiltRules
from games.rebuilt.scoring import MATCH
from simcore.match.game import Role
from simcore.match.players.player import Defense, Player, idle, make_role
from simcore.match.scripted import Steps
from simcore.typing import BoolArray, FloatArray
from simcore.world.symmetry import Pose

__all__ = ["ROLES"]

_HUB_X, _HUB_Y = dim.HUB_CENTER
_FLIGHT = 1.3  # [s]; time of flight from the muzzle to the hub's sensors
_ENOUGH, _FEW = 0.8, 0.4  # of the load: enough to go and shoot, and enough if the hub is about to become inactive
_ZONE_EDGE, _NEAREST, _FARTHEST = 3.6, 1.4, 3.3  # [m]; limits for shots: from the wall, and from the hub's center
_APART = 1.2  # [m]; distance between centers at which robots can turn without touching
_SHOOTING_SPOTS = ((2.5, 5.6), (2.2, 4.7), (2.2, 2.9), (2.6, 2.2))  # in the alliance zone, away from the tower
_MARGIN = 0.45  # [m]; distance from walls at which a robot can take in fuel
_THROW_FROM, _THROW_TO = (6.6, 1.9), (1.6, 2.2)  # [m]; x, and distance in y from the hub's center
_TOWER_REACH = 1.6  # [m]; in the end game, players avoid robots this close to the tower (G420)
_HOOK_UP = 35.0  # [rad]; drum angle with the hook above the low rung
_CLIMB_TIME, _HANGS = 15.0, 0.08  # [s] before the end; [m] above the carpet
_EXIT_REACH = 1.3  # [m] in front of a hub's exit: fuel there may not have had a contact yet (G408)


def _can_be_taken(places: FloatArray) -> BoolArray:
    """Return whether a blue player may take fuel at each position (n, 2) [m], shape (n,).

    The player takes fuel in the alliance zone and the neutral zone, away from walls, hubs, hub exits and the tower.
    """
    x, y = places.T
    inside = (x > _MARGIN) & (y > _MARGIN) & (y < dim.FIELD_WIDTH - _MARGIN)
    near_hub = (x > _HUB_X - 1.1) & (x < _HUB_X + 1.1)
    zone = (x < dim.FIELD_LENGTH - _HUB_X - 1.1) & ~near_hub
    tower = (x < dim.TOWER_UPRIGHT_X + 0.6) & (np.abs(y - dim.TOWER_Y) < 1.0)
    before = np.abs(x - dim.FIELD_CENTER[0]) > dim.FIELD_CENTER[0] - dim.HUB_EXIT_X - _EXIT_REACH
    at_exit = before & (np.abs(y - _HUB_Y) < 0.5 * dim.HUB_SIZE + 0.2)
    wanted: BoolArray = inside & zone & ~tower & ~at_exit
    return wanted


def _in_auto(places: FloatArray) -> BoolArray:
    """Return whether a blue player may take fuel at each position (n, 2) [m] in auto, shape (n,).

    In auto, the player also stays on the blue side of the center line (G403).
    """
    wanted: BoolArray = _can_be_taken(places) & (places[:, 0] < dim.FIELD_CENTER[0] - 0.6)
    return wanted


def _counts(player: Player, ahead: float = 0.0) -> bool:
    """Return whether fuel will count if the player shoots it after a time `ahead` [s]."""
    rules = player.match.rules
    assert isinstance(rules, RebuiltRules)
    return rules.is_active(player.alliance, player.time + ahead + _FLIGHT)


def _is_time_to_shoot(player: Player) -> bool:
    """Return whether a player should stop collecting, drive to a shooting spot and shoot."""
    way = 1.0 + player.away(_SHOOTING_SPOTS[1]) / player.skill.speed
    last = MATCH.duration - way - 4.0
    auto_ends = player.time < MATCH.start("pause") and player.time > MATCH.start("pause") - way - 3.0
    few = player.held >= _FEW * player.skill.load
    if (player.time > last or auto_ends) and few:
        return True
    if player.skill.foresight == 0.0:
        return player.room == 0
    if not _counts(player, way):
        return False
    return _is_full(player) or (few and not _counts(player, way + player.skill.foresight))


def _is_full(player: Player) -> bool:
    return player.held >= _ENOUGH * player.skill.load


def _go_and_shoot(player: Player) -> Steps:
    """Drive to the nearest free shooting spot in the alliance zone, wait until fuel counts, and shoot."""
    taken = [other.place for other in player.others]
    free = [spot for spot in _SHOOTING_SPOTS if all(math.dist(spot, place) > _APART for place in taken)]
    x, y = min(free or _SHOOTING_SPOTS, key=player.away)
    cares = player.skill.foresight > 0.0

    def spot() -> Pose | None:
        return None if _can_shoot(player) else (x, y, math.atan2(_HUB_Y - y, _HUB_X - x))

    player.spin_up(HUB_TARGET)
    yield from player.pursue(spot, near=0.3, timeout=8.0)
    player.stop()
    player.intake(False)
    yield from player.shake_off()
    while cares and not _counts(player) and player.time < MATCH.duration:
        yield
    yield from player.shoot(HUB_TARGET, until=lambda: cares and not _counts(player))


def _can_shoot(player: Player) -> bool:
    """Return whether the robot can shoot at the present position.

    The position must be in the alliance zone (G407), within range of the hub, and away from other robots.
    """
    x, _, _ = player.pose
    is_alone = all(player.away(other.place) > _APART for other in player.others)
    return is_alone and x < _ZONE_EDGE and _NEAREST < player.away((_HUB_X, _HUB_Y)) < _FARTHEST


def collector(player: Player, until: float = math.inf) -> Steps:
    """Collect fuel, and shoot the fuel into the alliance's hub while fuel counts, until a match time [s]."""
    yield from _shoot_preload(player)
    while player.time < until:
        is_auto = player.time < MATCH.start("pause")
        yield from player.collect(
            _in_auto if is_auto else _can_be_taken, until=lambda: _is_time_to_shoot(player), timeout=6.0
        )
        if player.held and (_is_time_to_shoot(player) or player.room == 0):
            yield from _go_and_shoot(player)
        yield


def _shoot_preload(player: Player) -> Steps:
    """Shoot the preload from the starting position, if fuel counts."""
    if _counts(player):
        yield from player.shoot(HUB_TARGET, timeout=3.0)


def shuttle(player: Player) -> Steps:
    """Shoot the preload, then shoot fuel from the neutral zone into the alliance zone, for partners to collect."""
    yield from _shoot_preload(player)
    while True:
        wanted = _in_auto if player.time < MATCH.start("pause") else _in_neutral_zone
        yield from player.collect(wanted, until=lambda: _is_full(player), timeout=6.0)
        if _is_full(player):
            side = 1.0 if player.pose[1] > _HUB_Y else -1.0
            yield from player.travel(_THROW_FROM[0], _HUB_Y + side * _THROW_FROM[1], math.pi, near=0.4, timeout=6.0)
            yield from player.shoot((_THROW_TO[0], _HUB_Y + side * _THROW_TO[1], 0.1))
        yield


def _in_neutral_zone(places: FloatArray) -> BoolArray:
    wanted: BoolArray = _can_be_taken(places) & (places[:, 0] > dim.HUB_EXIT_X)
    return wanted


def defender(player: Player) -> Steps:
    """Block opponents that drive to the opponents' hub, and release an opponent before a pin becomes a foul (G418).

    In auto, the defender only shoots the preload, and touches no robot across the center line (G403). In the end game,
    the defender stays away from the opponents' tower (G420).
    """
    yield from _shoot_preload(player)
    while player.time < MATCH.start("transition"):
        player.stop()
        yield
    yield from _DEFENSE.play(player)


def _is_at_tower(player: Player, place: tuple[float, float]) -> bool:
    x, y = FIELD.symmetry.flip_point(*place)
    is_near = x < dim.TOWER_UPRIGHT_X + _TOWER_REACH and abs(y - dim.TOWER_Y) < _TOWER_REACH
    return is_near and player.time >= MATCH.start("end game") - 1.0


_DEFENSE = Defense(goal=FIELD.symmetry.flip_point(_HUB_X, _HUB_Y), retreat=dim.FIELD_CENTER, is_left_alone=_is_at_tower)


def climber(player: Player) -> Steps:
    """Collect fuel until the last seconds, then climb to level 1 of the tower with the hook on the low rung."""
    yield from collector(player, until=MATCH.duration - _CLIMB_TIME)
    player.intake(False)
    x, y = dim.TOWER_UPRIGHT_X, dim.TOWER_Y
    player.set_volts(CLIMBER, 12.0)
    yield from player.travel(x + 1.3, y, 0.0, near=0.04, timeout=7.0)
    yield from player.drive_to(x + 1.3, y, 0.0, tolerance=0.02, timeout=2.0)
    while player.robot.mechanisms[CLIMBER].position < _HOOK_UP:
        yield
    yield from player.drive_to(x, y, 0.0, speed=0.9, tolerance=0.02, timeout=3.0)
    player.set_volts(CLIMBER, -12.0)
    while player.robot.chassis.pos[2] < _HANGS:
        yield
    player.set_volts(CLIMBER, 0.0)


ROLES: dict[str, Role] = {
    role.name: role
    for role in (
        make_role(collector, "collects fuel and shoots it into its hub while that counts", SETTINGS),
        make_role(shuttle, "collects fuel in the neutral zone and throws it into its alliance zone", SETTINGS),
        make_role(defender, "pushes opponents away from their hub, without fouls G403, G418 and G420", SETTINGS),
        make_role(climber, "a collector that hangs on the low rung as the match ends", SETTINGS, climbing_robot),
        make_role(idle, "stands still", SETTINGS),
    )
}
"""Roles of scripted players, by name."""
