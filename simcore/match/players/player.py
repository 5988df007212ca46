"""Scripted players: robots that play a match by observing the field, planning routes, collecting pieces and shooting.

A player uses only information that a driver has: the robots and pieces at the last look at the field, the match clock,
the game data, and the pieces, tilt and contacts of the player's robot. `RouteMap` plans routes on a grid over the
field. `Defense` obeys the pinning rule.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any, TypeAlias

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from simcore.loop.compiled import compiled
from simcore.match.foul_book import pins_of
from simcore.match.game import FieldDefinition, PlayedMatch, Role
from simcore.match.scoring import Alliance
from simcore.match.scripted import ScriptedRobot, ScriptSettings, Steps
from simcore.quantities import FIELD_PLACE, require_fields
from simcore.robot.robot import Robot
from simcore.robot.robot_config import RobotConfig
from simcore.typing import BoolArray, FloatArray, IntArray
from simcore.units import TICK, degrees
from simcore.world.field import FieldElement
from simcore.world.rotation import rotate, wrap_angle
from simcore.world.shapes import outline_points
from simcore.world.symmetry import Pose

__all__ = ["SKILLS", "Defense", "PlayScript", "Player", "RouteMap", "SeenRobot", "Skill", "idle", "make_role"]

Place = tuple[float, float]
"""Position on the carpet, blue field frame [m]."""

_CELL = 0.2  # [m]; size of a grid cell
_FINE = 4  # sampling points for elements per cell and axis
_FLAT = 0.05  # [m]; lower elements do not slow a robot down
_HALF = 0.42  # [m]; half of a robot and a margin: smallest distance from the robot center to a wall
_CORNER = 0.6  # [m]; a robot that turns at this distance from a wall touches the wall
_BLOCKED, _TIGHT = 60.0, 1.5  # cost per meter; finite, so that a robot inside a blocked cell finds a way out
_RAMP = 8.0  # cost per meter; a robot is slow on a ramp, and may land on a piece that lifts the wheels
_ROBOT, _NEAR_ROBOT = (0.85, 12.0), (1.3, 2.0)  # [m] from another robot's center, and the added cost per meter
_DETOUR = 1.03  # allowed cost of a straight line relative to a route of cells, which has steps of 45 degrees


class RouteMap:
    """Grid of driving costs on a field, with a search for the cheapest route.

    Args:
        field: Definition of the field, with the symmetry and the drivable elements.
        elements: Elements of the loaded field.
        height: Height of the robot [m]; the robot passes under elements above this height.
        flipped: Whether to flip the field for a red robot, so that routes are in the blue field frame.
    """

    def __init__(
        self, field: FieldDefinition, elements: Iterable[FieldElement], *, height: float, flipped: bool
    ) -> None:
        from scipy.ndimage import distance_transform_edt

        self._size = np.array(field.size)
        self.shape = (round(field.size[0] / _CELL), round(field.size[1] / _CELL))
        self._step = field.size[0] / self.shape[0], field.size[1] / self.shape[1]
        solid, ramp = self._rasters(elements, field.drivable, height)
        fine = np.array(self._step) / _FINE
        away = distance_transform_edt(np.pad(~solid, 1), sampling=fine)[1:-1, 1:-1]
        cost = np.where(away < _HALF, _BLOCKED, np.where(away < _CORNER, _TIGHT, 1.0)) + (_RAMP - 1.0) * ramp
        cells = cost.reshape(self.shape[0], _FINE, self.shape[1], _FINE)
        ramps = np.any(ramp.reshape(cells.shape), axis=(1, 3))
        self._to_ramp: FloatArray = (
            distance_transform_edt(~ramps, sampling=self._step) if ramps.any() else np.full(self.shape, np.inf)
        )
        # the middle of a cell stands for the whole cell; otherwise a passage narrower than two cells would close
        self._cost = cells[:, _FINE // 2 - 1 : _FINE // 2 + 1, :, _FINE // 2 - 1 : _FINE // 2 + 1].mean(axis=(1, 3))
        if flipped:
            turn = (slice(None, None, -1), slice(None, None, -1 if field.symmetry.keeps_hands else None))
            self._cost, self._to_ramp = self._cost[turn].copy(), self._to_ramp[turn].copy()
        x, y = ((np.arange(n) + 0.5) * s for n, s in zip(self.shape, self._step, strict=True))
        self._centers = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
        self._edges = a, b = _neighbors(self.shape)  # rows and columns of the graph's matrix
        flat = self._centers.reshape(-1, 2)
        self._half_lengths = 0.5 * np.linalg.norm(flat[a] - flat[b], axis=1)
        self._row_ends = np.searchsorted(a, np.arange(len(flat) + 1)).astype(np.int32)

    def _rasters(
        self, elements: Iterable[FieldElement], drivable: Sequence[str], height: float
    ) -> tuple[BoolArray, BoolArray]:
        """Return two masks of the fine grid: points on elements that block a robot, and points on drivable elements."""
        fine = (self.shape[0] * _FINE, self.shape[1] * _FINE)
        solid, ramp = np.zeros(fine, dtype=bool), np.zeros(fine, dtype=bool)
        step = np.array(self._step) / _FINE
        for element in elements:
            z = outline_points(element.shape)[:, 2] + element.position[2]
            is_ramp = any(fnmatchcase(element.name, pattern) for pattern in drivable)
            if z.max() < _FLAT or z.min() > height:
                continue
            outline = element.outline()
            first = np.maximum(0, np.ceil(outline.min(axis=0) / step - 0.5)).astype(int)
            last = np.minimum(fine, np.floor(outline.max(axis=0) / step + 0.5)).astype(int)
            if (last <= first).any():
                continue
            x, y = ((np.arange(a, b) + 0.5) * s for a, b, s in zip(first, last, step, strict=True))
            edges = np.roll(outline, -1, axis=0) - outline
            inside = np.ones((len(x), len(y)), dtype=bool)
            for (ex, ey), (cx, cy) in zip(edges.tolist(), outline.tolist(), strict=True):
                inside &= ex * (y[None, :] - cy) - ey * (x[:, None] - cx) >= 0.0
            (ramp if is_ramp else solid)[first[0] : last[0], first[1] : last[1]] |= inside
        return solid, ramp

    # --- queries --------------------------------------------------------------------------------------------------

    def is_ramp(self, place: Place, within: float = 0.0) -> bool:
        """Return whether a position is on a drivable element or within `within` [m] of a drivable element."""
        return bool(self._to_ramp[self._cell(place)] <= within)

    def is_free(self, place: Place) -> bool:
        """Return whether a robot centered at a position is on the field and clear of solid elements."""
        inside = 0.0 < place[0] < self._size[0] and 0.0 < place[1] < self._size[1]
        return inside and bool(self._cost[self._cell(place)] < _BLOCKED)

    def route(self, start: Place, goal: Place, others: Sequence[Place] = ()) -> list[Place]:
        """Return the cheapest route between two positions, blue field frame.

        Args:
            start: Current position of the robot [m].
            goal: Goal of the robot [m].
            others: Centers of other robots [m]; a robot on the goal is not an obstacle.

        Returns:
            Corners of the route, without the start and with the goal as the last corner [m].
        """
        cost = self._cost
        for x, y in others:
            if math.dist((x, y), goal) < _ROBOT[0]:
                continue
            if cost is self._cost:
                cost = cost.copy()
            around = _NEAR_ROBOT[0] + _CELL
            (i, j), (k, m) = self._cell((x - around, y - around)), self._cell((x + around, y + around))
            part, centers = cost[i : k + 1, j : m + 1], self._centers[i : k + 1, j : m + 1]
            away = np.hypot(centers[..., 0] - x, centers[..., 1] - y)
            for reach, more in (_ROBOT, _NEAR_ROBOT):
                part[away < reach] += more
        length = math.dist(start, goal)
        if self._line_cost(cost, start, goal) <= _DETOUR * length:
            return [goal]
        flat = cost.ravel()
        a, b = self._edges
        weights = self._half_lengths * (flat[a] + flat[b])
        graph: Any = csr_array((weights, b, self._row_ends), shape=(flat.size, flat.size))
        width = self.shape[1]
        first, last = (i * width + j for i, j in (self._cell(start), self._cell(goal)))
        costs, before = (row[0] for row in dijkstra(graph, indices=[last], return_predecessors=True))
        way, node = [], int(before[first])
        while node >= 0 and node != last:
            way.append(node)
            node = int(before[node])
        middles = [(float(x), float(y)) for x, y in self._centers.reshape(-1, 2)[way]] + [goal]
        left = [*costs[way].tolist(), 0.0]
        total = float(costs[first])
        # go straight to the farthest cell for which the straight line costs no more than the route of cells
        for n in range(len(middles) - 1, 0, -1):
            if self._line_cost(cost, start, middles[n]) <= _DETOUR * (total - left[n]):
                return middles[n:]
        return middles

    def _cell(self, place: Place) -> tuple[int, int]:
        i, j = (int(p / s) for p, s in zip(place, self._step, strict=True))
        return min(max(i, 0), self.shape[0] - 1), min(max(j, 0), self.shape[1] - 1)

    def _line_cost(self, cost: FloatArray, a: Place, b: Place) -> float:
        """Return the driving cost of the straight line between two positions on a cost grid."""
        length = math.dist(a, b)
        steps, ends = max(1, math.ceil(length / (0.5 * _CELL))), np.array((a, b), dtype=np.float64)
        return length * _mean_cost(cost, *self._step, ends, steps)


@compiled
def _mean_cost(cost: FloatArray, width: float, depth: float, ends: FloatArray, steps: int) -> float:
    """Return the mean cost per meter at evenly spaced points of a line, each with the cost of the cell at the point.

    Args:
        cost: Cost per meter of each cell, shape (nx, ny).
        width: Size of a cell along x [m].
        depth: Size of a cell along y [m].
        ends: Ends of the line [m], shape (2, 2).
        steps: Number of steps along the line.
    """
    total, x, y = 0.0, (ends[1, 0] - ends[0, 0]) / steps, (ends[1, 1] - ends[0, 1]) / steps
    for number in range(steps + 1):
        i, j = int((ends[0, 0] + number * x) / width), int((ends[0, 1] + number * y) / depth)
        if number == steps:
            i, j = int(ends[1, 0] / width), int(ends[1, 1] / depth)
        total += cost[min(max(i, 0), cost.shape[0] - 1), min(max(j, 0), cost.shape[1] - 1)]
    return total / (steps + 1)


def _neighbors(shape: tuple[int, int]) -> tuple[IntArray, IntArray]:
    """Return all pairs of grid cells that share a side or corner, each pair in both orders, sorted by cell.

    Returns:
        Indices of the first cells and of the second cells of the pairs, two arrays of shape (n,).
    """
    number = np.arange(shape[0] * shape[1]).reshape(shape)
    pairs = [
        (number[:-1, :], number[1:, :]),
        (number[:, :-1], number[:, 1:]),
        (number[:-1, :-1], number[1:, 1:]),
        (number[:-1, 1:], number[1:, :-1]),
    ]
    a = np.concatenate([one.ravel() for one, _ in pairs])
    b = np.concatenate([other.ravel() for _, other in pairs])
    first, second = np.concatenate((a, b)), np.concatenate((b, a))
    order = np.lexsort((second, first))
    return first[order].astype(np.int32), second[order].astype(np.int32)


_RAMP_SPEED = 1.4  # [m/s]; a faster robot jumps off a ramp
_AHEAD = 0.6  # [m]; distance at which a robot slows down for a ramp
_REPLAN = 0.4  # [s]; a route is kept for this time if the goal moves by less than `_MOVED`
_MOVED = 0.5  # [m]
_STUCK, _STUCK_TIME = 0.15, 1.2  # [m], [s]; a robot that moves less than this in this time is stuck
_BACK_OFF, _SHAKING = 0.6, 4.0  # [s]
_TILT, _RAISED = 0.08, 0.035  # [rad], [m]; elements flat on the carpet, e.g. a 3 cm bar, cause less
_BESIDE_RAMP = 0.6  # [m]; a robot whose center is this close to a ramp may have wheels on the ramp
_CALM = 5  # ticks on all wheels after which a robot counts as free
_AIM = 0.8  # [s]; interval between new aiming errors
_REACHES = 1.3  # [m]; a deployed intake touches opponents that are closer
_IN_THE_WAY = 1.2  # [s]; time of aiming without a shot after which a robot moves to another place
_CLUSTER = 0.45  # [m]; size of the cells in which pieces are counted
_CROWD = 1.3  # [m]; a player prefers pieces farther than this from other robots
_BEYOND = 0.35  # [m]; distance that a robot drives past the pieces that it collects
_LYING = 0.3  # [m]; pieces whose center is higher are in the air or on something


@dataclass(frozen=True, slots=True)
class Skill:
    """Skill of a scripted player and quality of the robot. The sources of the numbers are in docs/whole_match.md."""

    speed: float
    """Cruising speed [m/s]."""
    collecting_speed: float
    """Driving speed while taking in pieces [m/s]."""
    aim: float
    """Standard deviation of the heading error of a shot [rad]."""
    shot_speed: float
    """Relative standard deviation of a shot's speed [-]."""
    load: int
    """Largest number of pieces that the player collects before driving to score."""
    shot_rate: float
    """Average number of shots per second while shooting [1/s]."""
    reaction: float
    """Time between two looks at the field [s]."""
    foresight: float
    """Time in advance at which the player prepares for a scoring opportunity [s]; 0 for no preparation."""
    planning: float
    """Exponent of the number of pieces in the value of a cluster [-].

    With 0, the value does not depend on the number of pieces. With 1, the value is proportional to the number.
    The player drives to the cluster with the largest ratio of value to distance.
    """


SKILLS = (
    Skill(1.2, 0.6, degrees(6.0), 0.15, 6, 1.4, 1.0, 0.0, 0.0),
    Skill(1.6, 0.8, degrees(4.5), 0.11, 9, 2.2, 0.6, 2.0, 0.4),
    Skill(2.0, 1.0, degrees(3.0), 0.08, 12, 2.8, 0.4, 4.0, 0.7),
    Skill(2.6, 1.2, degrees(1.5), 0.04, 16, 4.0, 0.2, 6.0, 1.0),
)
"""Skills of levels 1 to 4: a team in its first match, an average team, a good team and a top team."""


@dataclass(frozen=True, slots=True)
class SeenRobot:
    """State of another robot at a player's last look at the field."""

    number: int
    is_opponent: bool
    pose: Pose
    """Pose of the other robot, field frame in which the player is blue [m, m, rad]."""

    @property
    def place(self) -> Place:
        """Center of the other robot, in the frame of `pose` [m]."""
        return self.pose[:2]


class Player(ScriptedRobot):
    """Controller that plays a match according to a script, for a robot with a swerve drive.

    Args:
        script: Script to follow.
        match: Match in which the robot plays.
        alliance: Alliance of the robot.
        skill: Skill of the player.
        settings: Settings of the robot.
    """

    def __init__(
        self, script: PlayScript, match: PlayedMatch, alliance: Alliance, skill: Skill, settings: ScriptSettings
    ) -> None:
        super().__init__(lambda _: script(self), match, alliance, settings)
        self.skill = skill
        self.others: list[SeenRobot] = []
        """Other robots at the last look, in order of robot number."""
        self.seen_pieces: dict[str | None, FloatArray] = {}
        """Positions of the pieces on the carpet at the last look, blue field frame [m], shape (n, 3), by kind.

        The key None contains the pieces of all kinds.
        """
        self._routes = RouteMap(
            match.game.field, match.field.elements, height=match.game.robot().body.height, flipped=alliance == "red"
        )
        self._middle = (0.5 * match.game.field.size[0], 0.5 * match.game.field.size[1])
        self._looks_at = self._aims_at = self._feeds_at = 0.0
        self._held_before = 0
        self._has_looked = False

    def begin(self, robot: Robot) -> None:
        """Start the script for a robot, and create the random number generator of the player."""
        self.rng = self.match.draws.generator("players", robot.number)
        self._looks_at = self._aims_at = self._feeds_at = -math.inf
        super().begin(robot)

    def __call__(self, robot: Robot, time: float) -> None:
        """Look at the field if the reaction time has passed since the last look, and run one tick of the script."""
        self._has_looked = time >= self._looks_at
        if self._has_looked:
            self._looks_at = time + self.skill.reaction - 0.5 * TICK
            self._see_field(robot)
        super().__call__(robot, time)

    def _see_field(self, robot: Robot) -> None:
        match = self.match
        self.others = [
            SeenRobot(other.number, side != self.alliance, self.as_blue(other.chassis.pose))
            for other, side in zip(match.robots, match.alliances, strict=True)
            if other is not robot
        ]
        for kind in (None, *(one.name for one in match.pieces.types)):
            positions = self.piece_positions(kind)
            self.seen_pieces[kind] = positions[positions[:, 2] < _LYING]

    # --- state that a script reads ----------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """Current match time [s]."""
        return self.match.timer.time

    @property
    def room(self) -> int:
        """Number of further pieces that fit into the robot and that the player's `load` allows."""
        return max(0, min(self.robot.storage.room, self.skill.load - self.held))

    @property
    def opponents(self) -> list[SeenRobot]:
        """Robots of the other alliance at the last look at the field."""
        return [other for other in self.others if other.is_opponent]

    @property
    def is_beached(self) -> bool:
        """Whether the robot is tilted or raised although no ramp is near, e.g. stuck on a piece under the frame."""
        chassis = self.robot.chassis
        roll, pitch, _ = chassis.roll_pitch_yaw
        leans = max(abs(roll), abs(pitch)) > _TILT or chassis.pos[2] > _RAISED
        return leans and not self._routes.is_ramp(self.pose[:2], within=_BESIDE_RAMP)

    def away(self, place: Place) -> float:
        """Return the distance from the robot to a position [m]."""
        return math.dist(self.pose[:2], place)

    def touches(self, number: int) -> bool:
        """Return whether this robot touched robot `number` in the last tick."""
        return (self.robot.number, number) in self.match.contacts.robots

    # --- commands of a script ---------------------------------------------------------------------------------------

    def travel(
        self, x: float, y: float, yaw: float, *, speed: float | None = None, timeout: float = 10.0, near: float = 0.12
    ) -> Steps:
        """Drive around obstacles to a pose and stop at the pose.

        Args:
            x: x coordinate of the goal, blue field frame [m].
            y: y coordinate of the goal, blue field frame [m].
            yaw: Heading at the goal [rad].
            speed: Cruising speed [m/s]; None for the skill's speed.
            timeout: Time after which the robot stops in any case [s].
            near: Distance from the goal at which the robot stops if the heading error is below 4 degrees [m].
        """
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
        """Drive around obstacles to a goal that may change with each look at the field.

        A beached robot first drives off the piece under the frame. A stuck robot backs off and then plans a new route.

        Args:
            goal: Function that returns the goal pose, blue field frame [m, m, rad], or None to end the pursuit.
            speed: Cruising speed [m/s]; None for the skill's speed.
            timeout: Time after which the pursuit ends [s].
            near: Distance from the goal at which the pursuit ends if the heading error is below 4 degrees [m]; 0 to
                continue at the goal.
            ignored: Numbers of the robots that this robot pushes instead of avoiding.
        """
        aim: Pose | None = None
        way: list[Place] = []
        planned, planned_for = -math.inf, (math.inf, math.inf)
        since, anchor = self.match.time, self.pose[:2]
        for _ in range(round(timeout / TICK)):
            if self._has_looked and self.is_beached:  # driving on would trap more pieces under the raised edge
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
        """Deploy the intake and collect pieces until the robot is full or no wanted piece is left.

        The skill's `planning` decides between large clusters and single pieces that are closer. The robot retracts the
        intake close to opponents.

        Args:
            wanted: Function of positions [m], shape (n, 2), that returns a mask of the pieces to collect.
            until: Function called at each look at the field; a return value of True ends the collection.
            timeout: Time after which the collection ends [s].
            kind: Kind of pieces to collect; None for any kind.
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
        """Shoot all pieces at a target, with random aiming errors that depend on the skill and change every 0.8 s.

        A beached robot first drives off the piece under the frame. A robot that cannot shoot for 1.2 s backs away from
        the nearest robot.

        Args:
            target: Point to aim at, blue field frame [m].
            until: Function called in each tick; a return value of True ends the shooting.
            timeout: Time after which the shooting ends [s].
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
                # the nearest robot may be in the way
                nearest = min((other.place for other in self.others), key=self.away)
                yield from self._back_off(nearest)
                self.stop()
                since = self.match.time
        yield

    def shake_off(self) -> Steps:
        """Drive a tilted robot toward its lower side, off the piece under the raised side, for up to 4 s.

        Every 0.6 s the robot picks a direction at random within 1.2 rad of the lower side; the first direction is
        straight toward the lower side. A piece under a robot rolls half as far as the robot moves, so the piece is free
        after two robot lengths.
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
        """Return whether the shooter is ready and the skill's rate of fire allows another shot."""
        shot, self._held_before = self._held_before - self.held, self.held
        if shot > 0:
            self._feeds_at = self.match.time + shot / self.skill.shot_rate
        return super()._is_ready(turn) and self.match.time >= self._feeds_at

    def _pace(self, toward: Place, speed: float) -> float:
        """Return the speed toward a position [m/s]: `speed`, but at most 1.4 m/s on a ramp and 0.6 m before a ramp."""
        x, y, _ = self.pose
        ahead = max(math.dist((x, y), toward), 1e-9)
        share = min(1.0, _AHEAD / ahead)
        next_place = x + share * (toward[0] - x), y + share * (toward[1] - y)
        is_steep = self._routes.is_ramp((x, y)) or self._routes.is_ramp(next_place)
        return min(speed, _RAMP_SPEED) if is_steep else speed

    def _back_off(self, toward: Place) -> Steps:
        """Drive away from a position for 0.6 s, in a random direction within 1.2 rad of straight away."""
        x, y, _ = self.pose
        way = math.atan2(y - toward[1], x - toward[0]) + self.rng.uniform(-1.2, 1.2)
        for _ in range(round(_BACK_OFF / TICK)):
            self.accelerate_to(math.cos(way), math.sin(way))
            yield

    def _best_piece(self, wanted: Callable[[FloatArray], BoolArray], kind: str | None) -> Place | None:
        """Return the center of the most valuable cluster of wanted pieces [m]; None if the player saw no such piece."""
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
"""Function of a player that returns the generator of a script."""


_INTO = 0.3  # [m]; distance from an opponent's center to the goal of a robot that pushes it
_LONGEST_PIN, _LET_GO, _SIX_FEET = 1.6, 3.1, 1.95  # [s], [s], [m]; a pin ends after 3 s at this distance


def make_role(
    script: PlayScript, summary: str, settings: ScriptSettings, config: Callable[[], RobotConfig] | None = None
) -> Role:
    """Return a role of scripted players; the name of the role is the name of the script function.

    Args:
        script: Script of the role.
        summary: One-line description of the script, shown to users.
        settings: Settings of the robot.
        config: Function that returns the robot's config; None for the game's default robot.
    """

    def controller(match: PlayedMatch, alliance: Alliance, level: int) -> Player:
        return Player(script, match, alliance, SKILLS[level - 1], settings)

    return Role(name=script.__name__, summary=summary, controller=controller, config=config)


def idle(player: Player) -> Steps:
    """Command zero velocity for the whole match."""
    while True:
        player.stop()
        yield


@dataclass(frozen=True, slots=True, kw_only=True)
class Defense:
    """Defensive play: a robot pushes opponents away from the opponents' goal."""

    goal: Place
    """Position to which opponents bring pieces, in the field frame in which the defender is blue [m]."""
    retreat: Place
    """Position to which the defender retreats after a long pin or without an opponent to block, frame of `goal` [m]."""
    is_left_alone: Callable[[Player, Place], bool]
    """Function that returns whether the defender avoids an opponent, e.g. because the rules forbid contact.

    The arguments are the player and the opponent's position in the frame of `goal` [m].
    """

    def __post_init__(self) -> None:
        require_fields(self, goal=(FIELD_PLACE,) * 2, retreat=(FIELD_PLACE,) * 2)

    def play(self, player: Player) -> Steps:
        """Repeatedly block the nearest opponent that is not left alone; end a pin before the pin becomes a foul."""
        pinned: dict[int, float] = defaultdict(float)  # time for which each opponent has been pinned [s], by number
        while True:
            wanted = [other for other in player.opponents if not self.is_left_alone(player, other.place)]
            nearest = min(wanted, key=lambda other: player.away(other.place), default=None)
            yield from self._block(player, None if nearest is None else nearest.number, pinned)
            yield

    def _block(self, player: Player, number: int | None, pinned: dict[int, float]) -> Steps:
        """Push an opponent away from `goal` for up to 4 s and then release a long pin; retreat if `number` is None."""
        since = 0.0

        def place() -> Place | None:
            other = next((one.place for one in player.opponents if one.number == number), None)
            return None if other is None or self.is_left_alone(player, other) else other

        def between() -> Pose | None:
            other = place()
            if number is None or other is None or pinned[number] > _LONGEST_PIN:
                return None
            if (player.robot.number, number) in pins_of(player.match):
                pinned[number] += player.skill.reaction
            toward = math.atan2(self.goal[1] - other[1], self.goal[0] - other[0])
            return other[0] + _INTO * math.cos(toward), other[1] + _INTO * math.sin(toward), toward + math.pi

        def away() -> Pose | None:
            nonlocal since
            other = place()
            if other is None or player.away(other) < _SIX_FEET:
                since = player.match.time
            return None if player.match.time > since + _LET_GO else (*self.retreat, player.pose[2])

        yield from player.pursue(between, near=0.0, timeout=4.0, ignored=() if number is None else (number,))
        since = player.match.time
        if number is None:
            yield from player.pursue(away, timeout=_LET_GO)
        elif pinned[number] > _LONGEST_PIN:
            yield from player.pursue(away, near=0.0, timeout=8.0)
            pinned[number] = 0.0
        player.stop()
