"""Tables `[[partner]]` and `[[opponent]]` of `simcore.toml`: further robots and their controllers."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from simcore.errors import ConfigError, UnknownNameError
from simcore.match.game import Game, RobotEntry
from simcore.match.match import Match
from simcore.match.players.lineup import ME, WhileEnabled, find_role, lineup, read_player
from simcore.match.scoring import Alliance
from simcore.match.scripted import ScriptedRobot
from simcore.quantities import DEGREES, FIELD_PLACE, Quantity
from simcore.robot.robot import Controller
from simcore.robot_file.key_tables import Key, KeyTable, Table
from simcore.world.symmetry import Pose

__all__ = ["FURTHER_ROBOT", "ROLES", "FurtherRobot", "add_controllers", "players_beside", "read_further_robot"]

ROLES = ("partner", "opponent")
FURTHER_ROBOT = KeyTable("[[opponent]]", "the game's own robot as an opponent, or with [[partner]] in your alliance; "
    "plays while your robot is enabled", (
    Key("name", str, about="name of the robot", example="defender"),
    Key("start", (FIELD_PLACE, FIELD_PLACE, DEGREES), None, "start pose for the blue alliance: x [m], y [m], heading "
        "[deg]; left out: that of the auto, else that of the game", [2.0, 5.5, 0.0]),
    Key("auto", str, None, "name of an auto of the game; without auto, player and script, the robot stands still"),
    Key("player", str, None, "scripted player: a role of the game and a skill level from 1 to 4 (docs/whole_match.md)",
        "defender:3"),
    Key("script", str, None, '"module:function" in the folder of this file: a function of (robot, time), or a '
        'generator function for a ScriptedRobot', "defense:defend"),
    Key("preload", Quantity("", 0, 500, is_whole=True), None, "number of preloaded pieces; left out: that of the auto, "
        "else 0", 0),
))  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class FurtherRobot:
    """Partner or opponent of the team's robot; the keys of `FURTHER_ROBOT` explain the fields with the same names."""

    name: str
    role: str
    """Role of the robot, one of `ROLES`."""
    start: Pose | None = None
    """Start pose for the blue alliance, field frame [m, m, rad]; None for the start of the auto, else of the game."""
    auto: str | None = None
    player: str | None = None
    script: str | None = None
    preload: int | None = None
    where: str = ""
    """Name of the table for error messages."""
    folder: Path = Path()
    """Folder that contains the module of the robot's script."""

    def entry(self, game: Game) -> RobotEntry:
        """Return the robot's match entry for a team robot on the blue alliance.

        Start pose and preload in the file override those of the auto. The role of a scripted player may set the config.

        Raises:
            ConfigError: The game does not have the auto or the role, or the player is not of the form `role:level`.
        """
        start, preload, config = self.start, self.preload, None
        try:
            if self.auto is not None:
                auto = game.auto(self.auto)
                start, preload = start or auto.start, auto.preload if preload is None else preload
            if self.player is not None:
                role = find_role(game, read_player(game, self.player)[0])
                config = None if role.config is None else role.config()
        except (UnknownNameError, ConfigError) as error:
            raise ConfigError(f"{self.where}: {error}") from error
        if self.auto is None and preload is None:
            preload = 0
        return RobotEntry(alliance=self.alliance("blue"), start=start, preload=preload, config=config)

    def alliance(self, ours: Alliance) -> Alliance:
        """Return the alliance of the robot: `ours` for a partner, the other alliance for an opponent."""
        theirs: Alliance = "red" if ours == "blue" else "blue"
        return ours if self.role == "partner" else theirs

    def controller(self, match: Match, number: int) -> Controller | None:
        """Return a controller that drives the robot while robots are enabled.

        The result is None for a robot without auto, player and script, which stands still.

        Args:
            match: Match with the robot.
            number: Index of the robot in the match.

        Raises:
            ConfigError: The script cannot be imported or is not callable.
        """
        if self.auto is None and self.player is None and self.script is None:
            return None
        return WhileEnabled(match, self._maker(match, number))

    def _maker(self, match: Match, number: int) -> Callable[[], Controller]:
        if self.auto is not None:
            auto = match.game.auto(self.auto)
            return lambda: auto.controller(match, match.alliances[number])
        if self.player is not None:
            name, level = read_player(match.game, self.player)
            role = find_role(match.game, name)
            return lambda: role.controller(match, match.alliances[number], level)
        script = self._script()
        if inspect.isgeneratorfunction(script):
            return lambda: ScriptedRobot(script, match, match.alliances[number])
        return lambda: script

    def _script(self) -> Any:
        module, _, name = str(self.script).partition(":")
        sys.path.insert(0, str(self.folder.resolve()))
        try:
            script = getattr(import_module(module), name)
        except (ImportError, AttributeError, ValueError) as error:
            raise ConfigError(f"{self.where}: script {self.script!r} is not there: {error}") from error
        finally:
            sys.path.remove(str(self.folder.resolve()))
        if not callable(script):
            raise ConfigError(f"{self.where}: script must name a function, got {script!r}")
        return script


def read_further_robot(t: Table, role: str, folder: Path) -> FurtherRobot:
    """Return the robot that a `[[partner]]` or `[[opponent]]` table describes.

    Args:
        t: Table to read.
        role: Role of the robot, one of `ROLES`.
        folder: Folder of the file, which contains the modules of scripts.

    Raises:
        ConfigError: A key is missing, unknown or invalid, or the table has two of auto, player and script.
    """
    v = FURTHER_ROBOT.read(t)
    t.finish()
    given = [key for key in ("script", "player", "auto") if v[key] is not None]
    if len(given) > 1:
        raise t.error(given[0], f"and {given[1]} exclude each other: one of them drives the robot")
    if v["script"] is not None and not all(v["script"].partition(":")):
        raise t.error("script", f'must be "module:function", e.g. "defense:defend"; got {v["script"]!r}')
    return FurtherRobot(**v, role=role, where=t.where, folder=folder)


def players_beside(game: Game, match: str) -> tuple[FurtherRobot, ...]:
    """Return the scripted partners and opponents of the team's robot in a whole match.

    Args:
        game: Game to play.
        match: Name of one of the game's practice matches, or a lineup `PARTNERS/OPPONENTS`, for example
            `collector:3/collector:2,defender`.

    Raises:
        ConfigError: A player is invalid, or an alliance has too many robots.
        UnknownNameError: The match or a role does not exist.
    """
    with_me, slash, against = match.partition("/")
    if not slash:
        if match not in game.practice_matches:
            raise UnknownNameError(f"match of {game.name} (or PARTNERS/OPPONENTS)", match, game.practice_matches)
        with_me, against = game.practice_matches[match]
    seats = lineup(game, blue=f"{ME},{with_me}" if with_me.strip() else ME, red=against)
    return tuple(
        FurtherRobot(
            name=f"{seat} {number}",
            role="partner" if seat.alliance == "blue" else "opponent",
            player=str(seat),
            preload=game.preload,
            where=f"match {match!r}, robot {number}",
        )
        for number, seat in enumerate(seats)
        if seat.role != ME
    )


def add_controllers(match: Match, robots: Sequence[FurtherRobot]) -> None:
    """Set the controllers of the further robots, and change their alliances when the team's robot changes alliance.

    Args:
        match: Match with the robots.
        robots: Further robots, in the order of their numbers in the match, from 1.

    Raises:
        ConfigError: A script cannot be imported or is not callable.
    """

    def follow() -> None:
        for number, one in enumerate(robots, 1):
            if match.alliances[number] != (alliance := one.alliance(match.alliances[0])):
                match.set_alliance(number, alliance)

    for number, one in enumerate(robots, 1):
        match.set_controller(number, one.controller(match, number))
    match.control.sources.append(follow)
