"""Who plays and where robots start: checked before the first tick."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from simcore.errors import ConfigError, UnknownNameError
from simcore.geometry.symmetry import Pose
from simcore.match.game import Game, RobotEntry
from simcore.match.scoring import Alliance
from simcore.physics.substeps import Surroundings
from simcore.physics.world import PhysicsWorld
from simcore.robot.robot import Robot

__all__ = ["require_free_starts", "require_playable", "start_pose"]


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


def start_pose(game: Game, entries: Sequence[RobotEntry], alliances: Sequence[Alliance], number: int) -> Pose:
    """Where a robot starts as one of its present alliance, field frame [m, m, rad].

    Args:
        game: With the starts of its own.
        entries: All robots.
        alliances: Of each robot, as last set.
        number: Of the robot.

    Raises:
        ConfigError: Its entry names no start, and the game has none left.
    """
    entry = entries[number]
    pose = entry.start
    if pose is None:
        before = len([1 for other in entries[:number] if other.alliance == entry.alliance])
        if before >= len(game.starts):
            raise ConfigError(
                f"{game.name} has {len(game.starts)} starts an alliance; give the RobotEntry of robot {number} a start"
            )
        pose = game.starts[before]
    return game.field.symmetry.flip_pose(*pose) if alliances[number] == "red" else pose


def require_free_starts(world: PhysicsWorld, robots: Sequence[Robot], field_size: tuple[float, float]) -> None:
    """Refuse robots that start beyond the field, inside of each other or of a solid element.

    Raises:
        ConfigError: One does.
    """
    length, width = field_size
    for robot in robots:
        (x, y, _), c = robot.chassis.pose, robot.chassis.config
        if not (0.0 <= x <= length and 0.0 <= y <= width):
            raise ConfigError(
                f"robot {robot.number} starts outside of the field of {length:g} x {width:g} m, at ({x:g}, {y:g}); "
                "a start is in meters from the blue corner"
            )
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
        (x, y, _), c = robot.chassis.pose, robot.chassis.config
        inner = 0.25 * min(c.bumper_length, c.bumper_width)
        low, high = (x - inner, y - inner, c.clearance), (x + inner, y + inner, c.bumper_top)
        if world.surroundings(robot.chassis.row, low, high) is Surroundings.WALL:
            raise ConfigError(
                f"robot {robot.number} starts inside of a field element, at ({x:.2f}, {y:.2f}) m; "
                "give its RobotEntry another start"
            )
