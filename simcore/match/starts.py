"""Checks of settings, robots and start poses before a match, and of pose estimates at the start of an auto."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Iterable, Sequence
from typing import TypeAlias

import numpy as np

from simcore.errors import ConfigError, UnknownNameError
from simcore.match.clock import MatchTimer
from simcore.match.game import FieldDefinition, Game, RobotEntry
from simcore.match.scoring import Alliance
from simcore.quantities import shown
from simcore.robot.robot import Robot
from simcore.telemetry.snapshot import TelemetrySink
from simcore.typing import FloatArray
from simcore.units import TICK
from simcore.world.engine_choice import ENGINES
from simcore.world.footprints import corners, overlaps
from simcore.world.rotation import Quaternion, Vector, from_yaw, matrix, multiply
from simcore.world.symmetry import Pose
from simcore.world.world import PhysicsWorld

__all__ = [
    "BeliefCheck",
    "StartError",
    "free_place",
    "missed_place",
    "pose_text",
    "require_free_place",
    "require_free_starts",
    "require_playable",
    "require_settings",
]

Flip: TypeAlias = Callable[[float, float, float], Pose]

_log = logging.getLogger(__name__)

_APART = 0.5, math.radians(10.0)  # [m], [rad]; a path follower misses the goal with a larger pose error
_MOVES = 0.05  # [m/s]; a faster robot has begun to drive
_BEGINNING = 0.5  # [s]; time in autonomous for robot code to set its pose
_SPARE = 0.02  # [m]; allowed overlap at a start, which contact forces then remove
_RING, _RINGS = 0.1, 20  # [m], [-]; spacing and number of the rings searched for a free pose


def require_playable(
    game: Game, entries: Sequence[RobotEntry], *, options: Iterable[str], controllers: int, seed: int
) -> None:
    """Check that a game can be played with the given robots, options, controllers and seed.

    Raises:
        ConfigError: If the game or an entry has the wrong type, the seed is not a whole number >= 0, or there are too
            many robots, controllers or preloads.
        UnknownNameError: If the game does not have one of the options.
    """
    if not hasattr(game, "robots"):
        raise ConfigError(f"the game must be a Game, as find_game(name) returns it, got {shown(game)}")
    if not isinstance(seed, int) or isinstance(seed, bool) or seed < 0:
        raise ConfigError(f"seed must be a whole number >= 0, got {seed!r}")
    if len(entries) > game.robots:
        raise ConfigError(f"a match of {game.name} has at most {game.robots} robots, got {len(entries)}")
    if controllers > len(entries):
        raise ConfigError(f"{controllers} controllers for {len(entries)} robots")
    known = [option.name for option in game.options]
    for name in options:
        if name not in known:
            raise UnknownNameError(f"option of {game.name}", name, known)
    for entry in entries:
        if not isinstance(entry, RobotEntry):
            raise ConfigError(f"robots must be RobotEntry objects, got {shown(entry)}")
        if entry.preload is not None and entry.preload > game.preload:
            raise ConfigError(f"RobotEntry: preload must be 0..{game.preload} in {game.name}, got {entry.preload}")


def require_settings(*, practice: bool = False, sinks: Sequence[TelemetrySink] = (), engine: object = None) -> None:
    """Check the types of settings whose errors would otherwise only show during the match.

    Raises:
        ConfigError: If `practice` is not a bool, or `sinks` or `engine` has the wrong type.
    """
    if not isinstance(practice, bool):
        raise ConfigError(f"practice must be True or False, got {shown(practice)}")
    for sink in sinks if isinstance(sinks, Sequence) else [sinks]:
        if not all(callable(getattr(sink, name, None)) for name in ("due", "write", "close")):
            raise ConfigError(f"sinks must be TelemetrySinks, with due, write and close, got {shown(sink)}")
    if not (engine is None or isinstance(engine, str) or callable(getattr(engine, "step", None))):
        raise ConfigError(f"engine must be None, {' or '.join(map(repr, ENGINES))}, or an Engine, got {shown(engine)}")


class StartError(ConfigError):
    """Error for a robot pose, at the start or later, that is outside the field or occupied.

    Args:
        number: Number of the robot.
        problem: Description of the problem, worded to follow "robot 0" in the message.
        hint: Suggestion for a solution; empty to suggest another start.
    """

    def __init__(self, number: int, problem: str, hint: str = "") -> None:
        self.number = number
        self.problem = problem
        self.hint = hint
        super().__init__(f"robot {number} {problem}; {hint or 'give its RobotEntry another start'}")


def require_free_starts(
    world: PhysicsWorld, robots: Sequence[Robot], field: FieldDefinition, alliances: Sequence[Alliance]
) -> None:
    """Check that each robot starts inside the field, without overlap with another robot or a solid element.

    Args:
        world: Physics world with the field and the robots.
        robots: Robots at their start poses.
        field: Field of the match.
        alliances: Alliance of each robot; for a red robot, the message also states the blue position of the entry.

    Raises:
        StartError: If a start pose is not free.
    """
    for robot, alliance in zip(robots, alliances, strict=True):
        pose, as_blue = robot.chassis.pose, field.symmetry.flip_pose if alliance == "red" else None
        require_free_place(world, robot, pose, field.size, others=robots[: robot.number], as_blue=as_blue)


def require_free_place(
    world: PhysicsWorld,
    robot: Robot,
    pose: Pose,
    field_size: tuple[float, float],
    *,
    others: Sequence[Robot] = (),
    as_blue: Flip | None = None,
) -> None:
    """Check that a pose is inside the field, without overlap with a solid element or another robot.

    The error message suggests a free position close to the pose.

    Args:
        world: Physics world with the field and the robots.
        robot: Robot to place.
        pose: Intended pose, field frame [m, m, rad].
        field_size: Length and width of the field [m].
        others: Other robots on the field.
        as_blue: Function that converts a red pose to the blue pose of the robot's entry; None for a blue robot.

    Raises:
        StartError: If the pose is not free.
    """
    (x, y, _), (length, width) = pose, field_size
    if not (0.0 <= x <= length and 0.0 <= y <= width):
        problem = f"starts outside of the field of {length:g} x {width:g} m, at {_place(x, y, as_blue)}"
        hint = "" if as_blue is None else ", as a blue robot"
        raise StartError(robot.number, problem, f"places are in meters from the blue corner{hint}")
    obstacle = _obstacle(world, robot, pose, others)
    if obstacle:
        near = free_place(world, robot, pose, field_size, others=others)
        hint = f"{_place(*near[:2], as_blue)} is free" if near else ""
        raise StartError(robot.number, f"starts inside of {obstacle}, at {_place(*pose[:2], as_blue)}", hint)


def free_place(
    world: PhysicsWorld, robot: Robot, pose: Pose, field_size: tuple[float, float], *, others: Sequence[Robot] = ()
) -> Pose | None:
    """Return an intended pose if the pose is free, or else a free pose on flat ground within 2 m.

    The result is None if no such pose is free. All poses have the same heading.

    Args:
        world: Physics world with the field and the robots.
        robot: Robot to place.
        pose: Intended pose, field frame [m, m, rad].
        field_size: Length and width of the field [m].
        others: Other robots on the field.
    """
    if not _obstacle(world, robot, pose, others):
        return pose
    (x, y, yaw), (length, width), body = pose, field_size, robot.chassis.config
    places = (
        (x + ring * _RING * math.cos(way), y + ring * _RING * math.sin(way))
        for ring in range(1, _RINGS + 1)
        for way in (step * math.tau / 16 for step in range(16))
    )
    free = (
        (px, py, yaw)
        for px, py in places
        if 0.0 <= px <= length
        and 0.0 <= py <= width
        and world.is_flat(px, py, 0.5 * math.hypot(body.bumper_length, body.bumper_width))
        and not _obstacle(world, robot, (px, py, yaw), others)
    )
    return next(free, None)


class BeliefCheck:
    """Check that logs a warning if robot code's pose estimate is over 0.5 m or 10 degrees off at the start of an auto.

    The check runs in each tick in which the robot moves, and a last time half a second into the auto or at the end of
    the auto. Each robot gets at most one warning per auto. A robot with an entry in `reasons` gets the warning at once.

    Args:
        robots: Robots of the match.
    """

    def __init__(self, robots: Sequence[Robot]) -> None:
        self._robots = robots
        self._open: list[Robot] = []
        self._since: float | None = None
        self.reasons: dict[int, str] = {}
        """Reason why a robot could not be placed at the start of an auto, by robot number, until the warning."""

    def after_tick(self, time: float, timer: MatchTimer) -> None:
        """Check the pose estimates of the robots in the first half second of an auto.

        Args:
            time: Simulated time at the end of the tick [s].
            timer: Timer of the match.
        """
        is_auto = timer.is_enabled and timer.phase.mode == "auto"
        if is_auto and self._since is None:
            self._since, self._open = time, list(self._robots)
        if self._since is not None and self._open:
            is_last = not is_auto or time - self._since >= _BEGINNING - 1e-9
            still = [robot for robot in self._open if not self._warn(robot, is_last=is_last)]
            self._open = [] if is_last else still
        if not is_auto:
            self._since = None

    def _warn(self, robot: Robot, *, is_last: bool) -> bool:
        """Log a warning if a robot is away from the estimated pose; return whether a warning was logged.

        Args:
            robot: Robot to check; a robot that has not begun to move is checked only if `is_last` is True.
            is_last: Whether this is the last check in the auto.
        """
        true, believed, reason = robot.chassis.pose, robot.believed_pose, self.reasons.get(robot.number, "")
        if not (is_last or reason) and robot.chassis.speed < _MOVES:
            return False
        apart, turned = math.dist(true[:2], believed[:2]), abs(math.remainder(true[2] - believed[2], math.tau))
        is_elsewhere = apart > _APART[0] or turned > _APART[1] or bool(reason)
        if is_elsewhere:
            _log.warning(
                "as its auto begins, robot %d believes it is at %s, but it is at %s: %.2f m and %.0f deg apart%s",
                *(robot.number, pose_text(believed), pose_text(true), apart, math.degrees(turned)),
                f"; {reason}" if reason else "",
            )
        if is_elsewhere or is_last:
            self.reasons.pop(robot.number, None)
        return is_elsewhere


def pose_text(pose: Pose) -> str:
    """Return a pose [m, m, rad] as text in meters and degrees, with the heading from -180 to 180 degrees."""
    return f"({pose[0]:.2f}, {pose[1]:.2f}) m, {math.degrees(math.remainder(pose[2], math.tau)):.0f} deg"


def missed_place(world: PhysicsWorld, robot: Robot, pose: Pose, error: Pose) -> Pose:
    """Return the actual pose of a robot: the intended pose plus a placement error of the drive team.

    If the error would make the robot overlap a further obstacle or ramp, the function reverses the position error. If
    the reversed error also causes an overlap, or if the intended pose is not free, the function returns the intended
    pose.

    Args:
        world: Physics world with the field and the robots.
        robot: Robot to place.
        pose: Intended pose, field frame [m, m, rad].
        error: Error in the robot frame: forward, to the left, and counter-clockwise [m, m, rad].
    """
    (x, y, yaw), (ahead, left, turn) = pose, error
    c, s = math.cos(yaw), math.sin(yaw)
    is_met, on_ramp = _around(world, robot, pose)
    if is_met:
        return pose
    for side in (1.0, -1.0):
        missed = (x + side * (c * ahead - s * left), y + side * (s * ahead + c * left), yaw + turn)
        if _around(world, robot, missed) <= (False, on_ramp):
            return missed
    return pose


def _around(world: PhysicsWorld, robot: Robot, pose: Pose) -> tuple[bool, bool]:
    """Return whether a robot at a pose would overlap a solid obstacle, and whether the robot would overlap a ramp."""
    c, (x, y, yaw) = robot.chassis.config, pose
    half_length, half_width = 0.5 * c.bumper_length, 0.5 * c.bumper_width
    return world.obstacles(robot.chassis.row, x, y, yaw, half_length, half_width, c.clearance, c.bumper_top)


def _place(x: float, y: float, as_blue: Flip | None) -> str:
    text = f"({x:.2f}, {y:.2f}) m"
    if as_blue is None:
        return text
    x, y, _ = as_blue(x, y, 0.0)
    return f"{text}, as blue ({x:.2f}, {y:.2f}) m"


def _obstacle(world: PhysicsWorld, robot: Robot, pose: Pose, others: Sequence[Robot] = ()) -> str:
    """Return the name of an obstacle that a robot at a pose would overlap by more than `_SPARE`.

    The name is worded for a message, and is empty if the pose is free. Other robots are obstacles at the current poses
    and at the expected poses after one tick.
    """
    c, (x, y, yaw) = robot.chassis.config, pose
    z = robot.chassis.standing(pose)[0][2]
    half = 0.5 * c.bumper_length - _SPARE, 0.5 * c.bumper_width - _SPARE
    for inner, top in ((0.0, c.bumper_top), (c.bumper_thickness, c.height)):
        box = x, y, yaw, max(half[0] - inner, _SPARE), max(half[1] - inner, _SPARE), z + c.clearance, z + top
        if world.is_in_solid(*box):
            return "a field element"
    mine = _outlines(robot, *robot.chassis.standing(pose), spare=_SPARE)
    for other in others:
        (ox, oy, oz), (vx, vy, _), quat = other.chassis.pos, other.chassis.origin_velocity, other.chassis.quat
        later = (ox + TICK * vx, oy + TICK * vy, oz), multiply(from_yaw(TICK * other.chassis.rate[2]), quat)
        theirs = _outlines(other, (ox, oy, oz), quat) + _outlines(other, *later)
        if other is not robot and any(overlaps(a, b) for a in mine for b in theirs):
            return f"robot {other.number}"
    return ""


def _outlines(robot: Robot, pos: Vector, quat: Quaternion, *, spare: float = 0.0) -> list[FloatArray]:
    """Return the outlines of the bumpers' lower and upper edges seen from above, shape (4, 2).

    The outlines differ if the robot is tilted.

    Args:
        robot: Robot with the bumpers.
        pos: Position of the robot's origin, field frame [m].
        quat: Attitude of the robot, unit quaternion x, y, z, w.
        spare: Reduction of the bumpers on each side [m].
    """
    body = robot.chassis.config
    edge = corners(0.0, 0.0, 0.0, body.bumper_length - 2.0 * spare, body.bumper_width - 2.0 * spare)
    heights = (body.clearance, body.bumper_top)
    return [(np.column_stack([edge, [height] * 4]) @ matrix(quat).T + pos)[:, :2] for height in heights]
