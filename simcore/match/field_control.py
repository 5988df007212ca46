"""Commands of users to a running match, e.g. to reset the field or to place a robot.

Web pages, dashboards and Python code use the same table of actions, `ACTIONS`. Any thread may queue commands at any
time. `FieldControl` checks the arguments of a command immediately, and runs all queued commands in order before the
next tick. No command therefore takes effect in the middle of a tick.
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
    """Match interface that `FieldControl` uses."""

    entries: tuple[RobotEntry, ...]

    @property
    def count(self) -> PieceCount:
        """Number of pieces by status: on the field, in flight, in robots, scored, placed and off the field."""

    def carry_to(self, number: int, pose: Pose) -> None:
        """Place a robot at rest at a pose; the gyro keeps its reading."""

    def require_robot(self, number: int) -> None:
        """Raise a `ConfigError` if there is no robot with this number."""

    def reset_field(self) -> None:
        """Reset pieces, preloads, score and rules to the state at the start of the match."""

    def set_controller(self, number: int, controller: Controller | None) -> None:
        """Set the controller of a robot from the next tick on; None removes the controller."""

    def start_mode(self, mode: Mode) -> None:
        """Set the match clock to the start of a mode, as if a driver station had enabled the mode."""

    def start_pose(self, number: int) -> Pose:
        """Return the start pose of a robot for the robot's current alliance, field frame [m, m, rad]."""


@dataclass(frozen=True, slots=True)
class CommandResult:
    """Result of one command: executed or refused, with a description."""

    number: int
    """Number of the command, counted from 1."""
    command: str
    """Description of the command."""
    is_done: bool
    """Whether the command was executed; a refused command changes nothing."""
    text: str
    """Description of the effect of an executed command, or reason for a refusal with a remedy."""

    def __str__(self) -> str:
        """Return the result as one line of text, e.g. `3 done: ...` or `4 refused: ...`."""
        return f"{self.number} {'done' if self.is_done else 'refused'}: {self.text}"


class FieldControl:
    """Queue of commands to one match, available as `Match.control`.

    Each command method queues a command and returns the number of the command. `before_tick` runs the queued commands,
    appends the results to `results` and logs the results. A refused command changes nothing.

    Args:
        match: Match that the commands change.

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
        """Results of the latest 100 commands, oldest first."""
        self.count = 0
        """Number of commands executed or refused so far."""
        self.sources: list[Callable[[], object]] = []
        """Functions called before each tick; the commands that these functions queue run before the same tick."""
        self.placed: list[Callable[[int, Pose | None], object]] = []
        """Functions called after `place_robot` or `place_at_start` has placed a robot.

        The arguments are the robot number and the new pose, field frame [m, m, rad], or None for the start pose.
        """

    # --- commands -------------------------------------------------------------------------------------------------

    def do(self, name: str, arguments: Mapping[str, Any]) -> int:
        """Queue an action by name, for web pages and dashboards.

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
        """Queue a reset of pieces, preloads, score and rules to the state at the start of the match.

        The robots keep their poses and battery charge, and the match clock keeps running.
        """
        return self.do("reset", {})

    def spawn(self, kind: str, places: Sequence[Sequence[float]]) -> int:
        """Queue a command that puts pieces on the carpet, each at the free position nearest to the requested position.

        The command uses pieces that have not been in play first, then pieces off the field, then scored pieces. The
        game's total number of pieces never changes.

        Args:
            kind: Name of the kind of piece.
            places: Requested positions, x and y of each piece, field frame [m].

        Raises:
            ConfigError: If a position is not two finite numbers, or if there are not 1 to 1000 positions.
        """
        return self.do("put_down", {"kind": kind, "places": places})

    def place_robot(self, pose: Any, robot: int = 0) -> int:
        """Queue the placement of a robot at rest; the gyro keeps its reading, and pieces are moved out of the way.

        The placement does not change the pose estimate of robot code. Therefore, also reset the odometry in robot code.

        Args:
            pose: x, y [m] and heading [rad], or a `Pose2d`, field frame.
            robot: Number of the robot.

        Raises:
            ConfigError: If the pose is not three finite numbers.
        """
        return self.do("place", {"pose": pose, "robot": robot})

    def place_at_start(self, robot: int = 0) -> int:
        """Queue the placement of a robot at the start pose for the robot's current alliance."""
        return self.do("start", {"robot": robot})

    def start_auto(self, name: str, robot: int = 0) -> int:
        """Queue the start of an auto: reset the field, place a robot at the auto's start pose, and run the auto.

        The command is refused for a robot with robot code, because robot code selects the auto. The command is also
        refused for a robot that lacks a mechanism or part of the game's default robot.

        Args:
            name: Name of the auto.
            robot: Number of the robot.
        """
        return self.do("auto", {"name": name, "robot": robot})

    def human_action(self, alliance: str, name: str) -> int:
        """Queue a request for an action of the human player of `blue` or `red`.

        The human player performs the action when the period since the last piece has passed. The request also gives
        control of the human player to a person, so that the game's own policy no longer acts.
        """
        return self.do("human", {"alliance": alliance, "name": name})

    def take_over(self, alliance: str, by_person: bool = True) -> int:
        """Queue a command that gives control of an alliance's human player to a person, or to the game's own policy."""
        return self.do("take_over", {"alliance": alliance, "by_person": by_person})

    def refuse(self, command: str, why: str) -> int:
        """Queue a command that is refused with a given reason, e.g. for an unreadable message."""

        def act() -> str:
            raise ConfigError(why)

        return self._enqueue(command, act)

    # --- the tick -------------------------------------------------------------------------------------------------

    def before_tick(self) -> None:
        """Call all sources, run all queued commands, and perform the due actions of human players."""
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
        """Request an action of an alliance's human player, and give control of the human player to a person."""
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
        """Return the alliance named `alliance`, and the actions of the alliance's human player by action name."""
        actions = {action.name: action for action in self._match.rules.human_actions()}
        if not actions:
            raise ConfigError(f"this run of {self._match.game.name} has no human players; whole matches may have them")
        if alliance not in _ALLIANCES:
            raise UnknownNameError("alliance", alliance, _ALLIANCES)
        return _ALLIANCES[alliance], actions

    def _carry_out(self) -> None:
        """Perform requested actions of human players that are ready, and remove completed and impossible requests."""
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
        """Return a controller that calls `controller`, and after an error removes itself from the robot.

        The error is reported as a refused command, and the match continues without a controller for the robot.
        """

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
    """Return the first part of the config `wanted` that `config` lacks, worded to follow "no"; empty if complete."""
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
    """Action in the table `ACTIONS`: description, function and checks of the arguments."""

    words: str
    """Format string that describes the command, with the names of the arguments in braces."""
    act: Callable[..., str]
    """Function that performs the action and returns a description of the effect.

    The arguments are the `FieldControl` and the arguments of the action by name.
    """
    arguments: Mapping[str, Callable[[str, Any], Any]]
    """Function that checks and converts an argument, by argument name.

    The function is called with a name for error messages and the value, and returns the converted value.
    """


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
"""Actions by name, as used in messages of web pages and dashboards."""
