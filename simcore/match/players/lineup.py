"""Lineups of full matches: parse the players, build the robot entries, set the controllers, and play the match."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from simcore.errors import ConfigError, UnknownNameError
from simcore.match.game import Auto, Game, PlayedMatch, RobotEntry, Role
from simcore.match.match import Match
from simcore.match.players.player import SKILLS
from simcore.match.runner import AutoRun, play_robots
from simcore.match.scoring import Alliance
from simcore.quantities import DURATION, require
from simcore.robot.robot import Controller, Robot
from simcore.robot.robot_config import RobotConfig
from simcore.units import TICK

__all__ = [
    "ME",
    "Seat",
    "WhileEnabled",
    "entries",
    "find_role",
    "lineup",
    "match_seconds",
    "play_match",
    "plays",
    "read_player",
    "take_seats",
]

ME = "me"
"""Word for the user's robot in a lineup. This robot has no role."""
_LEVEL = 2
"""Default skill level of a scripted player."""


@dataclass(frozen=True, slots=True)
class Seat:
    """Place of a robot in a lineup: alliance, role and skill level."""

    alliance: Alliance
    role: str
    """Name of a role of the game, or `ME` for the user's robot."""
    level: int = _LEVEL

    def __str__(self) -> str:
        return self.role if self.role == ME else f"{self.role}:{self.level}"


def find_role(game: Game, name: str) -> Role:
    """Return a game's role by name.

    Raises:
        UnknownNameError: If the game has no role of this name.
        ConfigError: If the game has no roles.
    """
    if not game.roles:
        raise ConfigError(f"game {game.name} has no scripted players")
    if name not in game.roles:
        raise UnknownNameError(f"role of {game.name}", name, game.roles)
    return game.roles[name]


def read_player(game: Game, text: str) -> tuple[str, int]:
    """Parse a player such as `collector:3`, and return the role and the skill level; the default level is 2.

    Raises:
        UnknownNameError: If the game has no role of this name.
        ConfigError: If the level does not exist.
    """
    name, colon, level = text.strip().partition(":")
    role = find_role(game, name.strip())
    known = [str(number) for number in range(1, len(SKILLS) + 1)]
    if colon and level.strip() not in known:
        raise ConfigError(f"player {text.strip()!r}: the level must be one of {', '.join(known)}, got {level!r}")
    return role.name, int(level) if colon else _LEVEL


def lineup(game: Game, *, red: str = "", blue: str = "") -> tuple[Seat, ...]:
    """Parse a lineup and return the seat of each robot, in order of robot number.

    Robot 0 is `me`, followed by the other robots of the same alliance. Without `me`, the blue robots come first.

    Args:
        game: Game to play.
        red: Players of red, separated by commas or plus signs, e.g. `collector:3,idle`; empty for no red robots.
        blue: Players of blue, in the format of `red`.

    Raises:
        ConfigError: If there are no robots, too many robots, two robots named `me`, or an unknown level.
        UnknownNameError: If the game has no role of one of the names.
    """
    sides: dict[Alliance, list[Seat]] = {"blue": [], "red": []}
    texts: dict[Alliance, str] = {"blue": blue, "red": red}
    for alliance, text in texts.items():
        for one in text.replace("+", ",").split(",") if text.strip() else ():
            if one.strip().startswith(f"{ME}:"):
                raise ConfigError(f"player {one.strip()!r}: {ME!r} plays --auto and has no level, so give {ME!r}")
            seat = Seat(alliance, ME) if one.strip() == ME else Seat(alliance, *read_player(game, one))
            sides[alliance].append(seat)
        if len(sides[alliance]) > len(game.starts):
            raise ConfigError(
                f"an alliance of {game.name} has at most {len(game.starts)} robots, got {len(sides[alliance])} "
                f"in --{alliance} {text}"
            )
    mine = [seat for side in sides.values() for seat in side if seat.role == ME]
    if len(mine) > 1:
        raise ConfigError(f"only one robot of a match can be {ME!r}, got {len(mine)}")
    seats = sorted((seat for side in sides.values() for seat in side), key=lambda seat: seat.role != ME)
    if not seats:
        raise ConfigError("nobody plays: give --red or --blue players, e.g. --blue collector:3,idle")
    return tuple(sorted(seats, key=lambda seat: seat.alliance != (mine[0].alliance if mine else "blue")))


def entries(game: Game, seats: Sequence[Seat], robot: RobotConfig | None = None) -> tuple[RobotEntry, ...]:
    """Return one robot entry per seat, in order, with the config of the seat's role.

    The entry for `ME` gets the config `robot`. A config of None selects the game's default robot.
    """
    return tuple(
        RobotEntry(alliance=seat.alliance, config=robot if role is None else role.config and role.config())
        for seat in seats
        for role in [None if seat.role == ME else find_role(game, seat.role)]
    )


def take_seats(
    match: Match,
    seats: Sequence[Seat],
    me: Callable[[], Controller] | None = None,
    hand_over: Callable[[Match, int, Controller], Controller] | None = None,
) -> None:
    """Set the controller of each robot, which runs while robots are enabled, and record the robot's player.

    Args:
        match: Match with the robots of `entries`.
        seats: Seats of the robots.
        me: Function that returns the controller of `ME`; None if the robot stands still.
        hand_over: Function of the match, a robot number and a scripted controller that returns a controller from which
            a person can take over; None if no person can take over.
    """
    for number, seat in enumerate(seats):
        match.record.robots[number].player = str(seat)
        if seat.role == ME:
            match.set_controller(number, None if me is None else WhileEnabled(match, me))
            continue
        own = WhileEnabled(match, _maker(match, number, seat))
        match.set_controller(number, own if hand_over is None else hand_over(match, number, own))


def play_match(
    game: Game,
    seats: Sequence[Seat],
    *,
    me: Callable[[Match], Controller] | None = None,
    robot: RobotConfig | None = None,
    hand_over: Callable[[Match, int, Controller], Controller] | None = None,
    seconds: float | None = None,
    options: Iterable[str] = (),
    **settings: Any,
) -> AutoRun:
    """Run a whole match headless until the final assessment of the score, with scripted players and the user's robot.

    Args:
        game: Game to play.
        seats: Seats of the robots, from `lineup`.
        me: Function of the match that returns the controller of `ME`, e.g. from `plays`; None if `ME` stands still.
        robot: Config of `ME`; None for the game's default robot.
        hand_over: Function that returns a controller from which a person can take over, as in `take_seats`.
        seconds: Simulated time to play [s]; None for the whole match.
        options: Game options to switch on, in addition to the options that are on by default in matches.
        settings: Further arguments of `simcore.match.runner.play_robots`.

    Returns:
        Result of the run, with the match still open.
    """
    length = match_seconds(game) if seconds is None else seconds
    require("a match", "seconds", length, DURATION)
    return play_robots(
        game,
        entries(game, seats, robot),
        lambda match: take_seats(match, seats, None if me is None else lambda: me(match), hand_over),
        name="match",
        players=[f"{seat.alliance} {seat}" for seat in seats],
        seconds=length,
        options={*options, *(option.name for option in game.options if option.in_matches)},
        **settings,
    )


def plays(auto: Auto) -> Callable[[PlayedMatch], Controller]:
    """Return a function of a match that returns an auto's controller for robot 0, for use as `me` in `play_match`."""
    return lambda match: auto.controller(match, match.alliances[0])


def match_seconds(game: Game) -> float:
    """Return the duration of a match until the final assessment of the score, plus two ticks [s]."""
    return game.clock.duration + game.assessment + 2.0 * TICK


def _maker(match: PlayedMatch, number: int, seat: Seat) -> Callable[[], Controller]:
    role = find_role(match.game, seat.role)
    return lambda: role.controller(match, match.alliances[number], seat.level)


class WhileEnabled:
    """Controller that runs an inner controller while robots are enabled.

    At the start of each auto, the controller makes a new inner controller.

    Args:
        match: Match in which the robot plays.
        make: Function that returns a new inner controller.
    """

    def __init__(self, match: PlayedMatch, make: Callable[[], Controller]) -> None:
        self._match = match
        self._make = make
        self._controller: Controller | None = None
        self._was_auto = False

    def __call__(self, robot: Robot, time: float) -> None:
        """Run one tick of the inner controller; while robots are disabled, stop the drive and coast all mechanisms."""
        timer = self._match.timer
        is_auto = timer.is_enabled and timer.phase.mode == "auto"
        if self._controller is None or (is_auto and not self._was_auto):
            self._controller = self._make()
        self._was_auto = is_auto
        if timer.is_enabled:
            self._controller(robot, time)
            return
        robot.drive.stop()
        for mechanism in robot.mechanisms.values():
            mechanism.coast()
