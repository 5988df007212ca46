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
FURTHER_ROBOT = KeyTable("[[opponent]]", "or [[partner]]: another robot, the game's own, in the other alliance or in "
    "yours; it plays while yours is enabled", (
    Key("name", str, example="defender"),
    Key("start", (FIELD_PLACE, FIELD_PLACE, DEGREES), None, "x, y, heading_deg as a blue robot; left out: its auto's, "
        "else the game's", [2.0, 5.5, 0.0]),
    Key("auto", str, None, "an auto of the game, by name; without auto, player and script it stands still"),
    Key("player", str, None, "a role of the game and a level of skill, 1 to 4 (docs/whole_match.md)", "defender:3"),
    Key("script", str, None, '"module:function" next to this file: called with (robot, time), or a generator for a '
        "ScriptedRobot", "defense:defend"),
    Key("preload", Quantity("", 0, 500, is_whole=True), None, "left out: its auto's, else none", 0),
))  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class FurtherRobot:
    """Robot other than the team's own; each field has the meaning of the key with the same name in `FURTHER_ROBOT`."""

    name: str
    role: str
    """Role of the robot, one of `ROLES`."""
    start: Pose | None = None
    """Start pose as a blue robot, field frame [m, m, rad]; None for the start of the auto or of the game."""
    auto: str | None = None
    player: str | None = None
    script: str | None = None
    preload: int | None = None
    where: str = ""
    """Name of the table in messages."""
    folder: Path = Path()
    """Folder that contains the module of the robot's script."""

    def entry(self, game: Game) -> RobotEntry:
        """Return the robot's entry in a match; start pose and preload in the file override those of the auto.

        Raises:
            ConfigError: The game does not have the auto or the role.
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
        """Return the alliance of the robot, given the alliance of the team's robot."""
        theirs: Alliance = "red" if ours == "blue" else "blue"
        return ours if self.role == "partner" else theirs

    def controller(self, match: Match, number: int) -> Controller | None:
        """Return a controller that drives the robot while robots are enabled; None if the robot stands still.

        Raises:
            ConfigError: The script does not exist.
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
    """Read the table of a further robot.

    Args:
        t: Table to read.
        role: Role of the robot, one of `ROLES`.
        folder: Folder of the file, for scripts.

    Raises:
        ConfigError: A key is missing, unknown or invalid.
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
        match: Name of one of the game's practice matches, or a line-up `PARTNERS/OPPONENTS`:
            `collector:3/collector:2,defender`.

    Raises:
        ConfigError: An alliance has too many robots.
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
    """Set the controllers of the further robots, and keep partners and opponents in the right alliance.

    Args:
        match: Match with the robots.
        robots: Further robots, in the order of their numbers in the match, from 1.

    Raises:
        ConfigError: A script does not exist.
    """

    def follow() -> None:
        for number, one in enumerate(robots, 1):
            if match.alliances[number] != (alliance := one.alliance(match.alliances[0])):
                match.set_alliance(number, alliance)

    for number, one in enumerate(robots, 1):
        match.set_controller(number, one.controller(match, number))
    match.control.sources.append(follow)
