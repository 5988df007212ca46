"""A scripted robot that plays a match with others: it looks at reaction's pace, finds its way, collects and aims.

What it knows is what a driver sees: where robots and pieces were when it last looked, the clock, the game data, and
what its own robot holds.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from simcore.geometry.rotation import rotate, wrap_angle
from simcore.geometry.symmetry import Pose
from simcore.match.match import Match
from simcore.match.scoring import Alliance
from simcore.match.scripted import ScriptedRobot, ScriptSettings, Steps
from simcore.players.routes import Place, RouteMap
from simcore.robot.robot import Robot
from simcore.typing import BoolArray, FloatArray
from simcore.units import TICK, degrees

__all__ = ["SKILLS", "PlayScript", "Player", "SeenRobot", "Skill"]

_RAMP_SPEED = 1.4  # [m/s]; faster, a robot jumps off what it climbs over
_AHEAD = 0.6  # [m] that a robot looks ahead for ramps
_REPLAN = 0.4  # [s] for which a route holds, while its goal stays within _MOVED
_MOVED = 0.5  # [m]
_STUCK, _STUCK_TIME = 0.15, 1.2  # [m], [s]; a robot that wants to move and comes no farther in this time is stuck
_BACK_OFF, _SHAKING = 0.6, 4.0  # [s]
_TILT, _RAISED = 0.08, 0.035  # [rad], [m]; what lies flat on carpets, as a bar of 3 cm, does less
_BESIDE_RAMP = 0.6  # [m]; a robot whose center is this near to a ramp may have its wheels on it
_CALM = 5  # ticks for which a robot stands on its wheels before it is believed to be free
_AIM = 0.8  # [s] after which a player aims anew
_REACHES = 1.3  # [m]; an intake that is out touches opponents who are nearer
_IN_THE_WAY = 1.2  # [s] for which a robot that aims does not come to shoot before it looks for another place
_CLUSTER = 0.45  # [m]; cells in which pieces are counted
_CROWD = 1.3  # [m]; pieces this near to another robot are its
_BEYOND = 0.35  # [m] that a robot drives on over the pieces that it collects
_LYING = 0.3  # [m]; pieces whose center is higher are in the air or on something


@dataclass(frozen=True, slots=True, kw_only=True)
class Skill:
    """How well somebody plays, and how good a robot it has. Where the numbers come from: docs/whole_match.md."""

    speed: float
    """Cruising [m/s]."""
    collecting_speed: float
    """Over pieces that are taken in [m/s]."""
    aim: float
    """Standard deviation of the heading of a shot [rad]."""
    shot_speed: float
    """Standard deviation of the speed of a shot, as a share of it [-]."""
    load: int
    """How many pieces it collects at most before it goes to score."""
    shot_rate: float
    """Shots a second, on average, while it shoots [1/s]."""
    reaction: float
    """Between two looks at the field [s]."""
    foresight: float
    """How long before something opens its player thinks of it [s]; 0: never."""
    planning: float
    """How much a heap counts over a single piece that is nearer: 0 not at all, 1 by its pieces."""


def _skill(*numbers: float) -> Skill:
    speed, collecting, aim, shot_speed, load, shot_rate, reaction, foresight, planning = numbers
    return Skill(
        speed=speed,
        collecting_speed=collecting,
        aim=degrees(aim),
        shot_speed=shot_speed,
        load=round(load),
        shot_rate=shot_rate,
        reaction=reaction,
        foresight=foresight,
        planning=planning,
    )


SKILLS = (
    _skill(1.2, 0.6, 6.0, 0.15, 6, 1.4, 1.0, 0.0, 0.0),
    _skill(1.6, 0.8, 4.5, 0.11, 9, 2.2, 0.6, 2.0, 0.4),
    _skill(2.0, 1.0, 3.0, 0.08, 12, 2.8, 0.4, 4.0, 0.7),
    _skill(2.6, 1.2, 1.5, 0.04, 16, 4.0, 0.2, 6.0, 1.0),
)
"""Of levels 1 to 4: a first match, a usual one, a good one, the best."""


@dataclass(frozen=True, slots=True)
class SeenRobot:
    """Another robot, as a player last saw it."""

    number: int
    is_opponent: bool
    pose: Pose
    """In the blue frame of the player [m, m, rad]."""

    @property
    def place(self) -> Place:
        """Its center [m]."""
        return self.pose[:2]


class Player(ScriptedRobot):
    """One scripted player of a match.

    Args:
        script: What to do.
        match: In which it plays.
        alliance: Whose robot it is.
        skill: How well.
        settings: How it handles the robot.
    """

    def __init__(
        self, script: PlayScript, match: Match, alliance: Alliance, skill: Skill, settings: ScriptSettings
    ) -> None:
        super().__init__(lambda _: script(self), match, alliance, settings)
        self.skill = skill
        self.others: list[SeenRobot] = []
        """As last seen, by number."""
        self.seen_pieces: dict[str | None, FloatArray] = {}
        """Pieces that lie on the carpet, as last seen, blue frame [m], shape (n, 3): by kind, and under None all."""
        self._routes = RouteMap(
            match.game.field, match.field.elements, height=match.game.robot().body.height, flipped=alliance == "red"
        )
        self._middle = (0.5 * match.game.field.size[0], 0.5 * match.game.field.size[1])
        self._looks_at = self._aims_at = self._feeds_at = 0.0
        self._held_before = 0
        self._has_looked = False

    def begin(self, robot: Robot) -> None:
        """Begin the script with a robot, with the chance that is the robot's own."""
        self.rng = self.match.draws.generator("players", robot.number)
        self._looks_at = self._aims_at = self._feeds_at = -math.inf
        super().begin(robot)

    def __call__(self, robot: Robot, time: float) -> None:
        """One tick: look, if it is time to, and go on."""
        self._has_looked = time >= self._looks_at
        if self._has_looked:
            self._looks_at = time + self.skill.reaction - 0.5 * TICK
            self._look(robot)
        super().__call__(robot, time)

    def _look(self, robot: Robot) -> None:
        match = self.match
        self.others = [
            SeenRobot(other.number, side != self.alliance, self.as_blue(other.chassis.pose))
            for other, side in zip(match.robots, match.alliances, strict=True)
            if other is not robot
        ]
        for kind in (None, *(one.name for one in match.pieces.types)):
            positions = self.piece_positions(kind)
            self.seen_pieces[kind] = positions[positions[:, 2] < _LYING]

    # --- what a script sees -----------------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """Of the match [s]."""
        return self.match.timer.time

    @property
    def room(self) -> int:
        """How many more pieces it takes in before it goes to score."""
        return max(0, min(self.robot.storage.room, self.skill.load - self.held))

    @property
    def opponents(self) -> list[SeenRobot]:
        """As last seen."""
        return [other for other in self.others if other.is_opponent]

    @property
    def is_beached(self) -> bool:
        """Whether the robot stands on something else than carpet and ramps, such as a piece under its frame."""
        chassis = self.robot.chassis
        roll, pitch, _ = chassis.roll_pitch_yaw
        leans = max(abs(roll), abs(pitch)) > _TILT or chassis.pos[2] > _RAISED
        return leans and not self._routes.is_ramp(self.pose[:2], within=_BESIDE_RAMP)

    def away(self, place: Place) -> float:
        """How far a place is from the robot [m]."""
        return math.dist(self.pose[:2], place)

    def touches(self, number: int) -> bool:
        """Whether the robot is in contact with another one, by its number."""
        return (self.robot.number, number) in self.match.contacts.robots

    # --- what a script does -----------------------------------------------------------------------------------------

    def travel(
        self, x: float, y: float, yaw: float, *, speed: float | None = None, timeout: float = 10.0, near: float = 0.12
    ) -> Steps:
        """Drive to a pose around everything [m, m, rad], and stop there; gives up after `timeout` [s]."""
        yield from self.pursue(lambda: (x, y, yaw), speed=speed, timeout=timeout, near=near)
        self.stop()

    def pursue(
        self,
        goal: Callable[[], Pose | None],
        *,
        speed: float | None = None,
        timeout: float = 10.0,
        near: float = 0.12,
        ignored: tuple[int, ...] = (),
    ) -> Steps:
        """Drive to a pose that may change with every look, until it is reached or there is none.

        Args:
            goal: Where to [m, m, rad]; None: the end.
            speed: Cruising speed [m/s]; None: that of the skill.
            timeout: Gives up after this long [s].
            near: How near counts as there [m]; 0: it never is.
            ignored: Numbers of robots that are no obstacles, and that it pushes.
        """
        aim: Pose | None = None
        way: list[Place] = []
        planned, planned_for = -math.inf, (math.inf, math.inf)
        since, anchor = self.match.time, self.pose[:2]
        for _ in range(round(timeout / TICK)):
            if self._has_looked and self.is_beached:  # whoever drives on gathers more under the edge that is up
                yield from self.shake_off()
                since, anchor, planned = self.match.time, self.pose[:2], -math.inf
            now, here = self.match.time, self.pose[:2]
            if aim is None or self._has_looked:
                aim = goal()
                if aim is None:
                    break
                if now >= planned + _REPLAN or math.dist(planned_for, aim[:2]) > _MOVED:
                    others = [other.place for other in self.others if other.number not in ignored]
                    way = self._routes.route(here, aim[:2], others)
                    planned, planned_for = now, aim[:2]
                way[-1] = aim[:2]
            left = self.steer_along(way, aim[2], speed=self._pace(way[0], speed or self.skill.speed))
            if left < near and abs(wrap_angle(aim[2] - self.pose[2])) < degrees(4.0):
                break
            if math.dist(here, anchor) > _STUCK or left < max(near, _STUCK) or any(map(self.touches, ignored)):
                since, anchor = now, here
            elif now - since > _STUCK_TIME:
                yield from self._back_off(way[0])
                since, anchor, planned = self.match.time, self.pose[:2], -math.inf
            yield

    def collect(
        self,
        wanted: Callable[[FloatArray], BoolArray],
        *,
        until: Callable[[], bool],
        timeout: float = 10.0,
        kind: str | None = None,
    ) -> Steps:
        """Take in pieces, where there are many or near ones, as the skill has it.

        Args:
            wanted: Which of some places [m], shape (n, 2), to take pieces from.
            until: Asked at every look; True ends it. It also ends when the robot is full or nothing is left.
            timeout: Gives up after this long [s].
            kind: Of pieces; None: any.
        """
        front = 0.0 if self.settings.intake_x > 0.0 else math.pi

        def goal() -> Pose | None:
            place = None if until() or self.room == 0 else self._best_piece(wanted, kind)
            if place is None:
                return None
            x, y, yaw = self.pose
            ahead = math.dist((x, y), place)
            self.intake(all(self.away(other.place) > _REACHES for other in self.opponents))
            if ahead < 0.3:
                return (*place, yaw)
            ux, uy = (place[0] - x) / ahead, (place[1] - y) / ahead
            beyond = place[0] + _BEYOND * ux, place[1] + _BEYOND * uy
            return (*(beyond if self._routes.is_free(beyond) else place), math.atan2(uy, ux) + front)

        self.intake(True)
        yield from self.pursue(goal, speed=self.skill.collecting_speed, timeout=timeout, near=0.0)

    def shoot(
        self, target: tuple[float, float, float], *, until: Callable[[], bool] = lambda: False, timeout: float = 6.0
    ) -> Steps:
        """Shoot everything at a place, blue field frame [m], aiming anew as the skill does it.

        Args:
            target: Where to.
            until: Asked every tick; True ends it.
            timeout: Gives up after this long [s].
        """
        yield from self.shake_off()
        since, ends = self.match.time, self.match.time + timeout
        while self.held and not until() and self.match.time < ends:
            for _ in self.shoot_until_empty(target, timeout=_IN_THE_WAY):
                if until():
                    break
                if self.match.time >= self._aims_at:
                    self._aims_at = self.match.time + _AIM
                    aside, faster = self.rng.standard_normal(2).tolist()
                    self.aim_error = (self.skill.aim * aside, self.skill.shot_speed * faster)
                since = self.match.time if self.is_feeding else since
                yield
            self.hold_fire()
            if self.held and self.match.time - since > _IN_THE_WAY and self.others:
                nearest = min((other.place for other in self.others), key=self.away)  # it may lean on this robot
                yield from self._back_off(nearest)
                self.stop()
                since = self.match.time
        yield

    def shake_off(self) -> Steps:
        """Drive off what is under the robot, toward the side that hangs lower: it lies under the other one.

        A piece under a robot rolls half as far as the robot moves, so a way of two robots' lengths leaves it behind.
        """
        aside, calm = 0.0, 0
        for number in range(round(_SHAKING / TICK)):
            calm = 0 if self.is_beached else calm + 1
            if calm > min(number, _CALM):
                break
            if number % round(_BACK_OFF / TICK) == 0:
                up_x, up_y, _ = rotate(self.robot.chassis.quat, (0.0, 0.0, 1.0))
                way = self.as_blue((0.0, 0.0, math.atan2(up_y, up_x)))[2] + aside
                aside = self.rng.uniform(-1.2, 1.2)
            self.accelerate_to(2.0 * math.cos(way), 2.0 * math.sin(way))
            yield
        self.stop()

    # --- inside -----------------------------------------------------------------------------------------------------

    def _is_ready(self, turn: float) -> bool:
        """Whether to feed: the shooter is ready, and the last shots are as long ago as the skill's rate wants it."""
        shot, self._held_before = self._held_before - self.held, self.held
        if shot > 0:
            self._feeds_at = self.match.time + shot / self.skill.shot_rate
        return super()._is_ready(turn) and self.match.time >= self._feeds_at

    def _pace(self, toward: Place, speed: float) -> float:
        """A speed that the ground allows [m/s]."""
        x, y, _ = self.pose
        ahead = max(math.dist((x, y), toward), 1e-9)
        share = min(1.0, _AHEAD / ahead)
        next_place = x + share * (toward[0] - x), y + share * (toward[1] - y)
        is_steep = self._routes.is_ramp((x, y)) or self._routes.is_ramp(next_place)
        return min(speed, _RAMP_SPEED) if is_steep else speed

    def _back_off(self, toward: Place) -> Steps:
        """Drive away from where it did not go on, a little aside."""
        x, y, _ = self.pose
        way = math.atan2(y - toward[1], x - toward[0]) + self.rng.uniform(-1.2, 1.2)
        for _ in range(round(_BACK_OFF / TICK)):
            self.accelerate_to(math.cos(way), math.sin(way))
            yield

    def _best_piece(self, wanted: Callable[[FloatArray], BoolArray], kind: str | None) -> Place | None:
        """The place that is most worth driving to of those with pieces [m]; None: there is none."""
        places = self.seen_pieces[kind][:, :2]
        places = places[wanted(places)]
        if not len(places):
            return None
        _, which, counts = np.unique((places / _CLUSTER).astype(int), axis=0, return_inverse=True, return_counts=True)
        which = which.ravel()
        middle = np.column_stack([np.bincount(which, places[:, axis]) / counts for axis in (0, 1)])
        away = np.hypot(*(middle - self.pose[:2]).T)
        worth = np.minimum(counts, self.room) ** self.skill.planning / (away + 0.5)
        for other in self.others:
            worth[np.hypot(*(middle - other.place).T) < _CROWD] *= 0.3
        x, y = middle[int(np.argmax(worth))].tolist()
        return x, y


PlayScript: TypeAlias = Callable[[Player], Steps]
"""What to do, from the first tick to the last."""
