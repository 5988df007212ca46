"""Who plays a whole match: line-ups as people type them, and the robots and players that come of them."""

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
"""In a line-up: the robot that is not scripted by a role."""
_LEVEL = 2
"""Of a player whose level is not given."""


@dataclass(frozen=True, slots=True)
class Seat:
    """One robot of a match, and who plays it."""

    alliance: Alliance
    role: str
    """`ME`, or a role of the game."""
    level: int = _LEVEL

    def __str__(self) -> str:
        return self.role if self.role == ME else f"{self.role}:{self.level}"


def find_role(game: Game, name: str) -> Role:
    """The role of a name.

    Raises:
        UnknownNameError: The game has none of that name.
        ConfigError: The game has no roles.
    """
    if not game.roles:
        raise ConfigError(f"game {game.name} has no scripted players")
    if name not in game.roles:
        raise UnknownNameError(f"role of {game.name}", name, game.roles)
    return game.roles[name]


def read_player(game: Game, text: str) -> tuple[str, int]:
    """Role and level of a player, as people type them: `collector:3`, or `collector`, which is of level 2.

    Raises:
        UnknownNameError: The game has no such role.
        ConfigError: There is no such level.
    """
    name, colon, level = text.strip().partition(":")
    role = find_role(game, name.strip())
    known = [str(number) for number in range(1, len(SKILLS) + 1)]
    if colon and level.strip() not in known:
        raise ConfigError(f"player {text.strip()!r}: the level must be one of {', '.join(known)}, got {level!r}")
    return role.name, int(level) if colon else _LEVEL


def lineup(game: Game, *, red: str = "", blue: str = "") -> tuple[Seat, ...]:
    """Seats of a match in the order of its robots: the alliance of `me` first, with `me` at its head, else blue.

    Args:
        game: What is played.
        red: Players with commas or plus signs between, e.g. `collector:3,idle`; empty: none.
        blue: The same.

    Raises:
        ConfigError: Too many robots or none at all, `me` twice, or a level that there is not.
        UnknownNameError: The game has no such role.
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
        raise ConfigError(f"one robot of a match can be {ME!r}, got {len(mine)}")
    seats = sorted((seat for side in sides.values() for seat in side), key=lambda seat: seat.role != ME)
    if not seats:
        raise ConfigError("nobody plays: give --red or --blue players, e.g. --blue collector:3,idle")
    return tuple(sorted(seats, key=lambda seat: seat.alliance != (mine[0].alliance if mine else "blue")))


def entries(game: Game, seats: Sequence[Seat], robot: RobotConfig | None = None) -> tuple[RobotEntry, ...]:
    """Robots of a match, each as its role wants it, and that of `ME` in place of the game's own."""
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
    """Let players drive the robots of a match while those may move.

    Args:
        match: With the robots of `entries`.
        seats: Of its robots.
        me: Makes what drives the robot of `ME`; None: nothing does.
        hand_over: Makes of a scripted robot, by its number and controller, one that a person can take over.
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
    """Play a whole match headless, until its score is final.

    Args:
        game: Which.
        seats: Who plays, as `lineup` gives them.
        me: Makes what drives the robot of `ME`, as `plays` does; None: nothing does.
        robot: That of `ME`, in place of the game's own.
        hand_over: As in `take_seats`.
        seconds: How long, simulated [s]; None: to the end.
        options: Of the game that are on, beside those that are on in matches.
        settings: Further arguments of `simcore.match.runner.play_robots`.
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
    """What the robot of `ME` does that plays an auto, and stands still afterwards."""
    return lambda match: auto.controller(match, match.alliances[0])


def match_seconds(game: Game) -> float:
    """How long a whole match is, until its score is final [s]."""
    return game.clock.duration + game.assessment + 2.0 * TICK


def _maker(match: PlayedMatch, number: int, seat: Seat) -> Callable[[], Controller]:
    role = find_role(match.game, seat.role)
    return lambda: role.controller(match, match.alliances[number], seat.level)


class WhileEnabled:
    """Lets a controller command while robots may move, and begins it anew with each auto.

    Args:
        match: In which.
        make: Makes the controller.
    """

    def __init__(self, match: PlayedMatch, make: Callable[[], Controller]) -> None:
        self._match = match
        self._make = make
        self._controller: Controller | None = None
        self._was_auto = False

    def __call__(self, robot: Robot, time: float) -> None:
        """One tick."""
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
