"""What people do to a field between and during runs: one table of actions for pages, dashboards and Python.

Commands may come from any thread and at any time: from robot code, from a team's physics.py, from a page, from a
dashboard. Their arguments are checked as they come; they are carried out in their order, before the next tick moves
anything, so that no tick sees half of one.
"""

from __future__ import annotations

import logging
import math
import threading
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Protocol

import numpy as np

from simcore.errors import ConfigError, SimcoreError, UnknownNameError
from simcore.match.clock import Mode
from simcore.match.game import PlayedMatch, RobotEntry
from simcore.match.human_actions import HumanAction
from simcore.match.run_record import PieceCount
from simcore.match.scoring import Alliance
from simcore.match.scripted import ScriptedRobot
from simcore.match.starts import pose_text
from simcore.quantities import shown
from simcore.robot.robot import Controller, Robot
from simcore.robot.robot_config import RobotConfig
from simcore.typing import FloatArray
from simcore.units import TICK
from simcore.world.symmetry import Pose

__all__ = ["ACTIONS", "Action", "CommandResult", "ControlledMatch", "FieldControl"]

_log = logging.getLogger(__name__)

_KEPT = 100  # results
_MOST_PIECES = 1000  # of one command
_AHEAD = 1.2  # [m] from the middle of the robot to a new piece
_ALLIANCES: dict[str, Alliance] = {"blue": "blue", "red": "red"}


class ControlledMatch(PlayedMatch, Protocol):
    """Match as people act on it."""

    entries: tuple[RobotEntry, ...]

    @property
    def count(self) -> PieceCount:
        """Where all pieces are."""

    def carry_to(self, number: int, pose: Pose) -> None:
        """Put a robot somewhere at rest, as people carry it."""

    def require_robot(self, number: int) -> None:
        """Refuse the number of a robot that there is not."""

    def reset_field(self) -> None:
        """Put all pieces back to where the match began."""

    def set_controller(self, number: int, controller: Controller | None) -> None:
        """Choose what commands a robot."""

    def start_mode(self, mode: Mode) -> None:
        """Begin a mode, as a driver station does."""

    def start_pose(self, number: int) -> Pose:
        """Return where a robot should start [m, m, rad]."""


@dataclass(frozen=True, slots=True)
class CommandResult:
    """What became of one command."""

    number: int
    """Its place among all commands, from 1."""
    command: str
    """What was asked for, in words."""
    is_done: bool
    """False: it was refused, and nothing has changed."""
    text: str
    """What was done, or why it was refused and what would work."""

    def __str__(self) -> str:
        """One line: `3 done: ...` or `4 refused: ...`."""
        return f"{self.number} {'done' if self.is_done else 'refused'}: {self.text}"


class FieldControl:
    """The commands to one match; `Match.control`.

    Each method returns the number of the command at once. What became of it is in `results` from the next tick on.
    A refused command changes nothing, and is logged.

    Args:
        match: Which they are for.

    Example:
        >>> from simcore.match.match import Match
        >>> with Match.bare() as match:
        ...     match.control.place_robot((5.0, 3.0, 0.0))
        ...     match.play(0.02)
        ...     print(match.control.results[-1])
        1
        1 done: robot 0 stands at (5.00, 3.00) m, 0 deg
    """

    def __init__(self, match: ControlledMatch) -> None:
        self._match = match
        self._lock = threading.Lock()
        self._queue: deque[tuple[int, str, Callable[[], str]]] = deque()
        self._given = 0
        self.results: deque[CommandResult] = deque(maxlen=_KEPT)
        """Of the last commands, the newest last."""
        self.count = 0
        """Commands that were done or refused so far."""
        self.sources: list[Callable[[], object]] = []
        """Called before every tick; they may give commands for it."""
        self.placed: list[Callable[[int, Pose | None], object]] = []
        """Called when a robot was placed, with its number and where [m, m, rad]; None: at its start."""

    # --- commands -------------------------------------------------------------------------------------------------

    def do(self, name: str, arguments: Mapping[str, Any]) -> int:
        """Ask for an action of the table by its name; pages and dashboards know no other way.

        Args:
            name: One of `ACTIONS`.
            arguments: Its arguments, all of them.

        Raises:
            UnknownNameError: There is no such action.
            ConfigError: An argument is missing, too many or of another kind than the action's.
        """
        if not isinstance(name, str) or name not in ACTIONS:
            raise UnknownNameError("action", name, ACTIONS)
        action = ACTIONS[name]
        if set(arguments) != set(action.arguments):
            raise ConfigError(f"{name}: arguments are {sorted(action.arguments)}, got {sorted(arguments)}")
        values = {key: check(f"{name}: {key}", arguments[key]) for key, check in action.arguments.items()}
        return self._enqueue(action.words.format(**values), partial(action.act, self, **values))

    def reset_field(self) -> int:
        """Pieces go back to where a match begins, preloads into the robots; score and rules begin anew.

        Robots stay where they are, with the charge of their batteries, and the clock goes on.
        """
        return self.do("reset", {})

    def spawn(self, kind: str, places: Sequence[Sequence[float]]) -> int:
        """Put pieces on the carpet, each at the free place that is nearest to where it is wanted.

        They are new ones while the game has spare ones, and count as staged then; after that those that wait off the
        field, then those that have scored: a field has no more pieces than its game.

        Args:
            kind: Name of the kind of piece.
            places: Where, field frame [m], one x and y a piece.

        Raises:
            ConfigError: A place is not two finite numbers.
        """
        return self.do("put_down", {"kind": kind, "places": places})

    def place_robot(self, pose: Any, robot: int = 0) -> int:
        """Put a robot somewhere, at rest; its gyro keeps its reading, and pieces make room.

        What robot code believes is its own affair: reset its odometry there, too.

        Args:
            pose: x, y [m] and heading [rad], or a `Pose2d`, field frame.
            robot: Its number.

        Raises:
            ConfigError: The pose is not three finite numbers.
        """
        return self.do("place", {"pose": pose, "robot": robot})

    def place_at_start(self, robot: int = 0) -> int:
        """Put a robot where it starts as one of its alliance."""
        return self.do("start", {"robot": robot})

    def start_auto(self, name: str, robot: int = 0) -> int:
        """Reset the field, put a robot where an auto of the game starts, and play that from its beginning.

        Only of robots without robot code: what robot code plays, its own chooser says.

        Args:
            name: Of the auto.
            robot: Its number.
        """
        return self.do("auto", {"name": name, "robot": robot})

    def human_action(self, alliance: str, name: str) -> int:
        """Let the human player of `blue` or `red` do an action of the game, as soon as their hands are ready.

        A person plays them from the first time on, and the game's own policy rests.
        """
        return self.do("human", {"alliance": alliance, "name": name})

    def take_over(self, alliance: str, by_person: bool = True) -> int:
        """Have a person play the human player of an alliance, or the game's own policy again."""
        return self.do("take_over", {"alliance": alliance, "by_person": by_person})

    def refuse(self, command: str, why: str) -> int:
        """Note a command that cannot even be read."""

        def act() -> str:
            raise ConfigError(why)

        return self._enqueue(command, act)

    # --- the tick -------------------------------------------------------------------------------------------------

    def before_tick(self) -> None:
        """Carry out what was asked for since the last tick."""
        for source in self.sources:
            source()
        while self._queue:
            number, command, act = self._queue.popleft()
            try:
                result = CommandResult(number, command, True, act())
            except Exception as error:  # whoever gave it is not here any more: it must not end the match
                result = CommandResult(number, command, False, _why(error))
            self.results.append(result)
            self.count += 1
            if result.is_done:
                _log.info("field control at %.2f s: %s", self._match.time, result.text)
            else:
                _log.warning("field control at %.2f s: cannot %s: %s", self._match.time, command, result.text)
        self._carry_out()

    # --- actions: each returns what was done, or raises why it cannot be and changes nothing ----------------------

    def _reset(self) -> str:
        self._match.reset_field()
        return f"the field is reset: {self._match.count.staged} pieces staged, no points"

    def _put_down(self, kind: str, places: FloatArray) -> str:
        length, width = self._match.game.field.size
        for x, y in places.tolist():
            if not (0.0 <= x <= length and 0.0 <= y <= width):
                raise ConfigError(
                    f"a piece at ({x:g}, {y:g}) m would lie outside of the field of {length:g} x {width:g} m"
                )
        pieces = self._match.pieces
        slots = pieces.spare(kind, len(places))
        pieces.put_down(slots, places)
        x, y, _ = pieces.state.pos[slots[0]].tolist()
        where = f"at ({x:.2f}, {y:.2f}) m" if len(slots) == 1 else f"from ({x:.2f}, {y:.2f}) m on"
        return f"{len(slots)} {kind} put down {where}"

    def _spawn_ahead(self, kind: str, robot: int) -> str:
        self._match.require_robot(robot)
        x, y, yaw = self._match.robots[robot].chassis.pose
        ahead = x + _AHEAD * math.cos(yaw), y + _AHEAD * math.sin(yaw)
        return self._put_down(kind, np.clip([ahead], 0.0, self._match.game.field.size))

    def _place(self, pose: Pose, robot: int) -> str:
        self._match.carry_to(robot, pose)
        self._notify(robot, pose)
        return f"robot {robot} stands at {pose_text(pose)}"

    def _place_at_start(self, robot: int) -> str:
        goal = self._match.start_pose(robot)
        self._match.carry_to(robot, goal)
        self._notify(robot, None)
        return f"robot {robot} stands at its start, {pose_text(goal)}"

    def _start_auto(self, name: str, robot: int) -> str:
        match = self._match
        match.require_robot(robot)
        if match.robots[robot].devices is not None:
            raise ConfigError(f"robot {robot} is driven by robot code, whose own chooser says which auto it plays")
        auto = match.game.auto(name)
        if missing := _missing(match.robots[robot].config, match.game.robot()):
            raise ConfigError(f"auto {name!r} is for the game's own robot, and robot {robot} has no {missing}")
        controller = auto.controller(match, match.alliances[robot])
        if isinstance(controller, ScriptedRobot):
            controller.begin(match.robots[robot])
        before = match.entries
        entry = replace(before[robot], start=auto.start, preload=auto.preload)
        match.entries = (*before[:robot], entry, *before[robot + 1 :])
        try:
            match.carry_to(robot, match.start_pose(robot))
        except SimcoreError:
            match.entries = before
            raise
        match.reset_field()
        match.start_mode("auto")
        match.set_controller(robot, self._guarded(robot, name, controller))
        return f"auto {name!r} begins"

    def _ask(self, alliance: str, name: str) -> str:
        """Let a person, who plays that human player from now on, have something done."""
        match = self._match
        whose, actions = self._human_player(alliance)
        if name not in actions:
            raise UnknownNameError("action of a human player", name, actions)
        action = actions[name]
        why = action.refusal(match.timer, whose)
        if not action.lasts and name in match.persons.get(whose, ()):
            why = why or f"the one before is still to come, one takes {action.period:g} s"
        if why:
            raise ConfigError(f"{whose}'s human player cannot {action.summary}: {why}")
        match.persons.setdefault(whose, {})[name] = match.time + action.lasts
        return f"{whose}'s human player: {action.summary}, {action.feeders[whose].stock} stood ready"

    def _take_over(self, alliance: str, by_person: bool) -> str:
        whose, _ = self._human_player(alliance)
        if by_person:
            self._match.persons.setdefault(whose, {})
        else:
            self._match.persons.pop(whose, None)
        return f"{'a person plays' if by_person else 'the game itself plays'} {whose}'s human player"

    # --- inside ---------------------------------------------------------------------------------------------------

    def _human_player(self, alliance: str) -> tuple[Alliance, dict[str, HumanAction]]:
        """Return whose human player it is, and what they can do."""
        actions = {action.name: action for action in self._match.rules.human_actions()}
        if not actions:
            raise ConfigError(f"this run of {self._match.game.name} has no human players; whole matches may have")
        if alliance not in _ALLIANCES:
            raise UnknownNameError("alliance", alliance, _ALLIANCES)
        return _ALLIANCES[alliance], actions

    def _carry_out(self) -> None:
        """Do what persons have asked human players for, as far as the hands are ready."""
        match = self._match
        for alliance, wanted in match.persons.items():
            _, actions = self._human_player(alliance)
            for name, until in list(wanted.items()):
                is_done = actions[name].take(match.timer, alliance)
                if actions[name].lasts:
                    is_done = match.time > until - 0.5 * TICK
                if is_done or actions[name].refusal(match.timer, alliance):
                    del wanted[name]

    def _enqueue(self, command: str, act: Callable[[], str]) -> int:
        with self._lock:
            self._given += 1
            self._queue.append((self._given, command, act))
            return self._given

    def _guarded(self, robot: int, name: str, controller: Controller) -> Controller:
        """A controller that ends, and not the match, where the robot cannot do what it asks."""

        def play(body: Robot, time: float) -> None:
            try:
                controller(body, time)
            except Exception as error:  # as with a command: who gave it is not here any more
                self._match.set_controller(robot, None)
                self.refuse(f"go on with auto {name!r}", _why(error))

        return play

    def _notify(self, robot: int, goal: Pose | None) -> None:
        for listener in self.placed:
            listener(robot, goal)


def _why(error: Exception) -> str:
    return str(error) if isinstance(error, SimcoreError) else f"{type(error).__name__}: {error}"


def _missing(config: RobotConfig, wanted: RobotConfig) -> str:
    """What a robot lacks of what another one has, as what follows after "no"; empty: nothing."""
    for name, mechanism in wanted.mechanisms.items():
        if type(config.mechanisms.get(name)) is not type(mechanism):
            return f"{type(mechanism).__name__.removesuffix('Config').lower()} named {name!r}"
    for kind in ("intakes", "shooters", "placers"):
        if len(getattr(config, kind)) < len(getattr(wanted, kind)):
            return kind[:-1]
    return ""


def _text(owner: str, value: Any) -> str:
    if not isinstance(value, str):
        raise ConfigError(f"{owner} must be a text, got {shown(value)}")
    return value


def _whole(owner: str, value: Any) -> int:
    if type(value) is not int:
        raise ConfigError(f"{owner} must be a whole number, got {shown(value)}")
    return value


def _switch(owner: str, value: Any) -> bool:
    if not isinstance(value, bool):
        raise ConfigError(f"{owner} must be True or False, got {shown(value)}")
    return value


def _pose(_: str, value: Any) -> Pose:
    if hasattr(value, "rotation"):
        value = (value.x, value.y, value.rotation().radians())
    x, y, yaw = _numbers("place_robot: a pose", value, "x, y [m], heading [rad]", 3)
    return x, y, math.remainder(yaw, math.tau)


def _places(_: str, value: Any) -> FloatArray:
    rows = value if np.iterable(value) else [value]
    places = np.array([_numbers("spawn: a place", place, "x, y [m]", 2) for place in rows]).reshape(-1, 2)
    if not 1 <= len(places) <= _MOST_PIECES:
        raise ConfigError(f"spawn: want 1 to {_MOST_PIECES} places, got {len(places)}")
    return places


def _numbers(owner: str, values: Any, want: str, count: int) -> tuple[float, ...]:
    try:
        numbers = tuple(float(value) for value in values)
    except (TypeError, ValueError, OverflowError):
        numbers = ()
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise ConfigError(f"{owner} is {count} finite numbers, {want}, got {shown(values)}")
    return numbers


@dataclass(frozen=True, slots=True)
class Action:
    """Something that people do to a field; a row of the table."""

    words: str
    """The command in words, with its arguments in braces."""
    act: Callable[..., str]
    """Carries it out, of a `FieldControl` and the arguments; returns what was done."""
    arguments: Mapping[str, Callable[[str, Any], Any]]
    """By name: checks one as it comes from outside, of its name in messages and the value; returns what is used."""


ACTIONS: Mapping[str, Action] = {
    "reset": Action("reset the field", FieldControl._reset, {}),
    "spawn": Action("put a {kind} before robot {robot}", FieldControl._spawn_ahead, {"kind": _text, "robot": _whole}),
    "put_down": Action("spawn {places.shape[0]} {kind}", FieldControl._put_down, {"kind": _text, "places": _places}),
    "place": Action("place robot {robot}", FieldControl._place, {"pose": _pose, "robot": _whole}),
    "start": Action("place robot {robot} at its start", FieldControl._place_at_start, {"robot": _whole}),
    "auto": Action("start auto {name!r}", FieldControl._start_auto, {"name": _text, "robot": _whole}),
    "human": Action("have {name!r} done for {alliance}", FieldControl._ask, {"alliance": _text, "name": _text}),
    "take_over": Action(
        "let somebody else play {alliance}'s human player",
        FieldControl._take_over,
        {"alliance": _text, "by_person": _switch},
    ),
    "leave": Action(
        "leave {alliance}'s human player to the game",
        partial(FieldControl._take_over, by_person=False),
        {"alliance": _text},
    ),
}
"""By the name that a page's message has, too."""
