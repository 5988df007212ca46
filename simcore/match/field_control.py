"""Commands of users on a practice field, such as a reset of the field or the placement of a robot.

Web pages, dashboards and Python share one table of actions. Commands may come from any thread at any time.
`FieldControl` checks the arguments of a command on arrival and runs the commands in order before the next tick, so that
no command takes effect halfway through a tick.
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

_KEPT = 100  # newest results that are kept
_MOST_PIECES = 1000  # in one command
_AHEAD = 1.2  # [m]; distance from the robot center to a new piece
_ALLIANCES: dict[str, Alliance] = {"blue": "blue", "red": "red"}


class ControlledMatch(PlayedMatch, Protocol):
    """Parts of a match that field control uses."""

    entries: tuple[RobotEntry, ...]

    @property
    def count(self) -> PieceCount:
        """Number of pieces on the field, in flight, in robots, scored, placed and off the field."""

    def carry_to(self, number: int, pose: Pose) -> None:
        """Place a robot at rest, as if the drive team carried the robot to a pose."""

    def require_robot(self, number: int) -> None:
        """Raise an error for a robot number that does not exist."""

    def reset_field(self) -> None:
        """Reset pieces, preloads, score and rules to the start of the match."""

    def set_controller(self, number: int, controller: Controller | None) -> None:
        """Set the controller of a robot."""

    def start_mode(self, mode: Mode) -> None:
        """Set the match clock to the start of a mode, as a driver station does."""

    def start_pose(self, number: int) -> Pose:
        """Return the start pose of a robot, field frame [m, m, rad]."""


@dataclass(frozen=True, slots=True)
class CommandResult:
    """Result of one command."""

    number: int
    """Number of the command, counted from 1."""
    command: str
    """Description of the command."""
    is_done: bool
    """Whether the command was done; a refused command changes nothing."""
    text: str
    """Description of the result, or the reason for the refusal and what would work."""

    def __str__(self) -> str:
        """Return one line: `3 done: ...` or `4 refused: ...`."""
        return f"{self.number} {'done' if self.is_done else 'refused'}: {self.text}"


class FieldControl:
    """Queue of commands to one match, available as `Match.control`.

    Each command method queues a command and returns the number of the command. The command runs before the next tick;
    the result is then in `results`. A refused command changes nothing and is logged.

    Args:
        match: Match that the commands act on.

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
        self._last_number = 0
        self.results: deque[CommandResult] = deque(maxlen=_KEPT)
        """Results of the latest commands, oldest first."""
        self.count = 0
        """Number of commands done or refused so far."""
        self.sources: list[Callable[[], object]] = []
        """Functions called before every tick; commands that the functions queue run in the same tick."""
        self.placed: list[Callable[[int, Pose | None], object]] = []
        """Functions called when a robot is placed, with its number and pose [m, m, rad], or None for the start pose."""

    # --- commands -------------------------------------------------------------------------------------------------

    def do(self, name: str, arguments: Mapping[str, Any]) -> int:
        """Queue an action of the table `ACTIONS`, as web pages and dashboards do.

        Args:
            name: Name of the action in `ACTIONS`.
            arguments: Values of all arguments of the action, by name.

        Returns:
            Number of the command.

        Raises:
            UnknownNameError: If no action has this name.
            ConfigError: If an argument is missing, unknown or of the wrong type.
        """
        if not isinstance(name, str) or name not in ACTIONS:
            raise UnknownNameError("action", name, ACTIONS)
        action = ACTIONS[name]
        if set(arguments) != set(action.arguments):
            raise ConfigError(f"{name}: arguments are {sorted(action.arguments)}, got {sorted(arguments)}")
        values = {key: check(f"{name}: {key}", arguments[key]) for key, check in action.arguments.items()}
        return self._enqueue(action.words.format(**values), partial(action.act, self, **values))

    def reset_field(self) -> int:
        """Reset pieces, preloads, score and rules to the start of the match.

        Robots stay in place, their batteries keep their charge, and the clock goes on.
        """
        return self.do("reset", {})

    def spawn(self, kind: str, places: Sequence[Sequence[float]]) -> int:
        """Put pieces on the carpet, each at the free position nearest to the requested position.

        Unused pieces are put down first, then pieces that wait off the field, then pieces that have scored; the game's
        total number of pieces never changes.

        Args:
            kind: Name of the kind of piece.
            places: Requested positions, x and y of each piece, field frame [m].

        Raises:
            ConfigError: If a position is not two finite numbers.
        """
        return self.do("put_down", {"kind": kind, "places": places})

    def place_robot(self, pose: Any, robot: int = 0) -> int:
        """Place a robot at rest; the gyro keeps its reading, and pieces are moved out of the way.

        Robot code keeps its pose estimate, so also reset the odometry of the robot code.

        Args:
            pose: x, y [m] and heading [rad], or a `Pose2d`, field frame.
            robot: Number of the robot.

        Raises:
            ConfigError: If the pose is not three finite numbers.
        """
        return self.do("place", {"pose": pose, "robot": robot})

    def place_at_start(self, robot: int = 0) -> int:
        """Place a robot at its start pose for its current alliance."""
        return self.do("start", {"robot": robot})

    def start_auto(self, name: str, robot: int = 0) -> int:
        """Reset the field, place a robot at the start of one of the game's autos, and run the auto from its beginning.

        The command is refused for a robot with robot code, which selects the auto with its own chooser.

        Args:
            name: Name of the auto.
            robot: Number of the robot.
        """
        return self.do("auto", {"name": name, "robot": robot})

    def human_action(self, alliance: str, name: str) -> int:
        """Request an action of the human player of `blue` or `red`, performed as soon as the action is possible.

        From the first call on, a person controls this human player and the game's own policy is off.
        """
        return self.do("human", {"alliance": alliance, "name": name})

    def take_over(self, alliance: str, by_person: bool = True) -> int:
        """Give control of an alliance's human player to a person, or back to the game's own policy."""
        return self.do("take_over", {"alliance": alliance, "by_person": by_person})

    def refuse(self, command: str, why: str) -> int:
        """Record an unreadable command as refused, with the reason."""

        def act() -> str:
            raise ConfigError(why)

        return self._enqueue(command, act)

    # --- the tick -------------------------------------------------------------------------------------------------

    def before_tick(self) -> None:
        """Run the commands that have arrived since the last tick."""
        for source in self.sources:
            source()
        while self._queue:
            number, command, act = self._queue.popleft()
            try:
                result = CommandResult(number, command, True, act())
            except Exception as error:  # the caller has already returned, so an error must not end the match
                result = CommandResult(number, command, False, _reason(error))
            self.results.append(result)
            self.count += 1
            if result.is_done:
                _log.info("field control at %.2f s: %s", self._match.time, result.text)
            else:
                _log.warning("field control at %.2f s: cannot %s: %s", self._match.time, command, result.text)
        self._carry_out()

    # --- actions: each returns a description of its effect, or raises an error and changes nothing ----------------

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
        where = f"at ({x:.2f}, {y:.2f}) m" if len(slots) == 1 else f"starting at ({x:.2f}, {y:.2f}) m"
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
        """Request an action of a human player and give control to a person."""
        match = self._match
        whose, actions = self._human_player(alliance)
        if name not in actions:
            raise UnknownNameError("action of a human player", name, actions)
        action = actions[name]
        why = action.refusal(match.timer, whose)
        if not action.lasts and name in match.persons.get(whose, ()):
            why = why or f"the previous one is still to come, and each takes {action.period:g} s"
        if why:
            raise ConfigError(f"{whose}'s human player cannot {action.summary}: {why}")
        match.persons.setdefault(whose, {})[name] = match.time + action.lasts
        return f"{whose}'s human player: {action.summary}, {action.feeders[whose].stock} were ready"

    def _take_over(self, alliance: str, by_person: bool) -> str:
        whose, _ = self._human_player(alliance)
        if by_person:
            self._match.persons.setdefault(whose, {})
        else:
            self._match.persons.pop(whose, None)
        return f"{'a person plays' if by_person else 'the game itself plays'} {whose}'s human player"

    # --- inside ---------------------------------------------------------------------------------------------------

    def _human_player(self, alliance: str) -> tuple[Alliance, dict[str, HumanAction]]:
        """Return an alliance by its name, and the actions of its human player."""
        actions = {action.name: action for action in self._match.rules.human_actions()}
        if not actions:
            raise ConfigError(f"this run of {self._match.game.name} has no human players; whole matches may have them")
        if alliance not in _ALLIANCES:
            raise UnknownNameError("alliance", alliance, _ALLIANCES)
        return _ALLIANCES[alliance], actions

    def _carry_out(self) -> None:
        """Perform requested actions of human players that are ready, and drop requests that are done or impossible."""
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
            self._last_number += 1
            self._queue.append((self._last_number, command, act))
            return self._last_number

    def _guarded(self, robot: int, name: str, controller: Controller) -> Controller:
        """Return a controller that is removed from the robot after an error, so that the match goes on."""

        def play(body: Robot, time: float) -> None:
            try:
                controller(body, time)
            except Exception as error:  # the caller of the command has already returned
                self._match.set_controller(robot, None)
                self.refuse(f"go on with auto {name!r}", _reason(error))

        return play

    def _notify(self, robot: int, goal: Pose | None) -> None:
        for listener in self.placed:
            listener(robot, goal)


def _reason(error: Exception) -> str:
    return str(error) if isinstance(error, SimcoreError) else f"{type(error).__name__}: {error}"


def _missing(config: RobotConfig, wanted: RobotConfig) -> str:
    """Return the first part that a robot lacks compared with a wanted config, worded to follow "no"; empty if none."""
    for name, mechanism in wanted.mechanisms.items():
        if type(config.mechanisms.get(name)) is not type(mechanism):
            return f"{type(mechanism).__name__.removesuffix('Config').lower()} named {name!r}"
    for kind in ("intakes", "shooters", "placers"):
        if len(getattr(config, kind)) < len(getattr(wanted, kind)):
            return kind[:-1]
    return ""


def _text(owner: str, value: Any) -> str:
    if not isinstance(value, str):
        raise ConfigError(f"{owner} must be a string, got {shown(value)}")
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
        raise ConfigError(f"spawn needs 1 to {_MOST_PIECES} places, got {len(places)}")
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
    """One row of the table of field actions."""

    words: str
    """Format string that describes the command, with its arguments in braces."""
    act: Callable[..., str]
    """Function that performs the action, called with the `FieldControl` and the arguments; returns a description of the
    effect."""
    arguments: Mapping[str, Callable[[str, Any], Any]]
    """Check of each argument, by name: a function of a name for messages and a value that returns the checked value."""


ACTIONS: Mapping[str, Action] = {
    "reset": Action("reset the field", FieldControl._reset, {}),
    "spawn": Action(
        "put a {kind} in front of robot {robot}", FieldControl._spawn_ahead, {"kind": _text, "robot": _whole}
    ),
    "put_down": Action("spawn {places.shape[0]} {kind}", FieldControl._put_down, {"kind": _text, "places": _places}),
    "place": Action("place robot {robot}", FieldControl._place, {"pose": _pose, "robot": _whole}),
    "start": Action("place robot {robot} at its start", FieldControl._place_at_start, {"robot": _whole}),
    "auto": Action("start auto {name!r}", FieldControl._start_auto, {"name": _text, "robot": _whole}),
    "human": Action("do {name!r} for {alliance}", FieldControl._ask, {"alliance": _text, "name": _text}),
    "take_over": Action(
        "change who plays {alliance}'s human player",
        FieldControl._take_over,
        {"alliance": _text, "by_person": _switch},
    ),
    "leave": Action(
        "leave {alliance}'s human player to the game",
        partial(FieldControl._take_over, by_person=False),
        {"alliance": _text},
    ),
}
"""Actions by the name used in a web page's message."""
