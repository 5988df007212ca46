"""Who plays and where robots start: checked before the first tick."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import TypeAlias

from simcore.errors import ConfigError, UnknownNameError
from simcore.geometry.symmetry import Pose
from simcore.match.game import FieldDefinition, Game, RobotEntry
from simcore.match.scoring import Alliance
from simcore.physics.substeps import Surroundings
from simcore.physics.world import PhysicsWorld
from simcore.robot.robot import Robot

__all__ = [
    "StartError",
    "missed_place",
    "require_free_place",
    "require_free_starts",
    "require_playable",
]

Flip: TypeAlias = Callable[[float, float, float], Pose]

_RING, _RINGS = 0.1, 20  # [m], [-]; where a free place is looked for


def require_playable(
    game: Game, entries: Sequence[RobotEntry], *, options: Iterable[str], controllers: int, seed: int
) -> None:
    """Refuse a match that cannot be.

    Raises:
        ConfigError: The seed is no whole number >= 0, or there are more robots, controllers or preloads than can be.
        UnknownNameError: The game has no such option.
    """
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
        if entry.preload is not None and entry.preload > game.preload:
            raise ConfigError(f"RobotEntry: preload must be 0..{game.preload} in {game.name}, got {entry.preload}")


class StartError(ConfigError):
    """A robot cannot stand where it should start.

    Args:
        number: Of the robot.
        problem: What is wrong, as what follows after "robot 0".
        hint: What would work; empty: another start.
    """

    def __init__(self, number: int, problem: str, hint: str = "") -> None:
        self.number = number
        self.problem = problem
        self.hint = hint
        super().__init__(f"robot {number} {problem}; {hint or 'give its RobotEntry another start'}")


def require_free_starts(
    world: PhysicsWorld, robots: Sequence[Robot], field: FieldDefinition, alliances: Sequence[Alliance]
) -> None:
    """Refuse robots that start beyond the field, inside of each other or of a solid element.

    Args:
        world: With the field and the robots.
        robots: Where they start.
        field: Theirs.
        alliances: Of each robot; of a red one the text says places as blue, too: so its entry has them.

    Raises:
        StartError: One does.
    """
    as_blue = [field.symmetry.flip_pose if alliance == "red" else None for alliance in alliances]
    for robot in robots:
        (x, y, _), c = robot.chassis.pose, robot.chassis.config
        _require_on_field(robot, robot.chassis.pose, field.size, as_blue=as_blue[robot.number])
        half = 0.5 * min(c.bumper_length, c.bumper_width)
        for other in robots[: robot.number]:
            ox, oy, _ = other.chassis.pose
            reach = half + 0.5 * min(other.chassis.config.bumper_length, other.chassis.config.bumper_width)
            if math.hypot(ox - x, oy - y) < 0.99 * reach:
                raise ConfigError(
                    f"robots {other.number} and {robot.number} start inside of each other, at ({ox:.2f}, {oy:.2f}) "
                    f"and ({x:.2f}, {y:.2f}) m; give their RobotEntry other starts"
                )
    for robot in robots:
        require_free_place(world, robot, robot.chassis.pose, field.size, as_blue=as_blue[robot.number])


def _require_on_field(
    robot: Robot, pose: Pose, field_size: tuple[float, float], *, as_blue: Flip | None = None
) -> None:
    (x, y, _), (length, width) = pose, field_size
    if not (0.0 <= x <= length and 0.0 <= y <= width):
        problem = f"starts outside of the field of {length:g} x {width:g} m, at {_place(x, y, as_blue)}"
        hint = "" if as_blue is None else ", as a blue robot"
        raise StartError(robot.number, problem, f"places are in meters from the blue corner{hint}")


def require_free_place(
    world: PhysicsWorld, robot: Robot, pose: Pose, field_size: tuple[float, float], *, as_blue: Flip | None = None
) -> None:
    """Refuse a start beyond the field, or inside of something solid; the text names a place nearby that is free.

    Args:
        world: With the field and the robots.
        robot: Who would start there.
        pose: Where, field frame [m, m, rad].
        field_size: Length and width [m].
        as_blue: Turns a place into that of a blue robot, where the start was given so; None: it was not.

    Raises:
        StartError: It is.
    """
    _require_on_field(robot, pose, field_size, as_blue=as_blue)
    x, y, _ = pose
    if _is_free(world, robot, x, y):
        return
    places = [
        (x + ring * _RING * math.cos(way), y + ring * _RING * math.sin(way))
        for ring in range(1, _RINGS + 1)
        for way in (step * math.tau / 16 for step in range(16))
    ]
    (length, width), c = field_size, robot.chassis.config
    edge = 0.5 * min(c.bumper_length, c.bumper_width)
    free = (
        (px, py)
        for px, py in places
        if edge <= px <= length - edge and edge <= py <= width - edge and _is_free(world, robot, px, py, whole=True)
    )
    near = next(free, None)
    hint = f"{_place(*near, as_blue)} is free" if near else ""
    raise StartError(robot.number, f"starts inside of a field element, at {_place(x, y, as_blue)}", hint)


def missed_place(world: PhysicsWorld, robot: Robot, pose: Pose, error: Pose) -> Pose:
    """Where people put a robot who miss a place: to the other side where it would be in a wall, else not at all.

    Args:
        world: With the field and the robots.
        robot: Who is put there.
        pose: Where it should be, field frame [m, m, rad].
        error: How far ahead, to its left and turned it ends up [m, m, rad].
    """
    (x, y, yaw), (ahead, left, turn) = pose, error
    c, s = math.cos(yaw), math.sin(yaw)
    around = _around(world, robot, pose)
    if around is Surroundings.WALL:
        return pose
    for side in (1.0, -1.0):
        missed = (x + side * (c * ahead - s * left), y + side * (s * ahead + c * left), yaw + turn)
        if _around(world, robot, missed) in (Surroundings.OPEN, around):
            return missed
    return pose


def _around(world: PhysicsWorld, robot: Robot, pose: Pose) -> Surroundings:
    """What is in the box around a robot that stands there."""
    c, (x, y, yaw) = robot.chassis.config, pose
    half_length, half_width = 0.5 * c.bumper_length, 0.5 * c.bumper_width
    return world.surroundings(robot.chassis.row, x, y, yaw, half_length, half_width, c.clearance, c.bumper_top)


def _place(x: float, y: float, as_blue: Flip | None) -> str:
    text = f"({x:.2f}, {y:.2f}) m"
    if as_blue is None:
        return text
    x, y, _ = as_blue(x, y, 0.0)
    return f"{text}, as blue ({x:.2f}, {y:.2f}) m"


def _is_free(world: PhysicsWorld, robot: Robot, x: float, y: float, *, whole: bool = False) -> bool:
    """Whether no solid is in the middle of a robot that stands there, or in the whole of it."""
    c = robot.chassis.config
    inner = 0.5 * math.hypot(c.bumper_length, c.bumper_width) if whole else 0.25 * min(c.bumper_length, c.bumper_width)
    found = world.surroundings(robot.chassis.row, x, y, 0.0, inner, inner, c.clearance, c.bumper_top)
    return found is not Surroundings.WALL
