"""What people do to a field between and during runs: reset it, put pieces down, place a robot, start an auto.

Commands may come from any thread and at any time: from robot code, from a team's physics.py, from a dashboard. They are
carried out in their order, before the next tick moves anything, so that no tick sees half of one.
"""

from __future__ import annotations

import logging
import math
import threading
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from simcore.errors import ConfigError, SimcoreError
from simcore.geometry.symmetry import Pose
from simcore.match.human_actions import ask, carry_out, take_over
from simcore.match.scripted import ScriptedRobot
from simcore.quantities import shown
from simcore.robot.robot import Controller, Robot
from simcore.robot.robot_config import RobotConfig

if TYPE_CHECKING:
    from simcore.match.match import Match

__all__ = ["CommandResult", "FieldControl"]

_log = logging.getLogger(__name__)

_KEPT = 100  # results
_MOST_PIECES = 1000  # of one command


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

    def __init__(self, match: Match) -> None:
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

    def reset_field(self) -> int:
        """Pieces go back to where a match begins, preloads into the robots; score and rules begin anew.

        Robots stay where they are, with the charge of their batteries, and the clock goes on.
        """

        def act() -> str:
            self._match.reset_field()
            return f"the field is reset: {self._match.count.staged} pieces staged, no points"

        return self._enqueue("reset the field", act)

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
        rows = places if np.iterable(places) else [places]
        wanted = np.array([_numbers("spawn: a place", place, "x, y [m]", 2) for place in rows]).reshape(-1, 2)
        if not 1 <= len(wanted) <= _MOST_PIECES:
            raise ConfigError(f"spawn: want 1 to {_MOST_PIECES} places, got {len(wanted)}")

        def act() -> str:
            length, width = self._match.game.field.size
            for x, y in wanted.tolist():
                if not (0.0 <= x <= length and 0.0 <= y <= width):
                    raise ConfigError(
                        f"a piece at ({x:g}, {y:g}) m would lie outside of the field of {length:g} x {width:g} m"
                    )
            pieces = self._match.pieces
            slots = pieces.spare(kind, len(wanted))
            pieces.put_down(slots, wanted)
            x, y, _ = pieces.state.pos[slots[0]].tolist()
            where = f"at ({x:.2f}, {y:.2f}) m" if len(slots) == 1 else f"from ({x:.2f}, {y:.2f}) m on"
            return f"{len(slots)} {kind} put down {where}"

        return self._enqueue(f"spawn {len(wanted)} {kind}", act)

    def place_robot(self, pose: Any, robot: int = 0) -> int:
        """Put a robot somewhere, at rest; its gyro keeps its reading, and pieces make room.

        What robot code believes is its own affair: reset its odometry there, too.

        Args:
            pose: x, y [m] and heading [rad], or a `Pose2d`, field frame.
            robot: Its number.

        Raises:
            ConfigError: The pose is not three finite numbers.
        """
        if hasattr(pose, "rotation"):
            pose = (pose.x, pose.y, pose.rotation().radians())
        x, y, yaw = _numbers("place_robot: a pose", pose, "x, y [m], heading [rad]", 3)
        goal = (x, y, math.remainder(yaw, math.tau))

        def act() -> str:
            self._match.carry_to(robot, goal)
            self._notify(robot, goal)
            return f"robot {robot} stands at {_words(goal)}"

        return self._enqueue(f"place robot {robot} at {_words(goal)}", act)

    def place_at_start(self, robot: int = 0) -> int:
        """Put a robot where it starts as one of its alliance."""

        def act() -> str:
            goal = self._match.start_pose(robot)
            self._match.carry_to(robot, goal)
            self._notify(robot, None)
            return f"robot {robot} stands at its start, {_words(goal)}"

        return self._enqueue(f"place robot {robot} at its start", act)

    def start_auto(self, name: str, robot: int = 0) -> int:
        """Reset the field, put a robot where an auto of the game starts, and play that from its beginning.

        Only of robots without robot code: what robot code plays, its own chooser says.

        Args:
            name: Of the auto.
            robot: Its number.
        """

        def act() -> str:
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
                self._match.carry_to(robot, match.start_pose(robot))
            except SimcoreError:
                match.entries = before
                raise
            self._match.reset_field()
            self._match.start_mode("auto")
            self._match.set_controller(robot, self._guarded(robot, name, controller))
            return f"auto {name!r} begins"

        return self._enqueue(f"start auto {name!r}", act)

    def human_action(self, alliance: str, name: str) -> int:
        """Let the human player of `blue` or `red` do an action of the game, as soon as their hands are ready.

        A person plays them from the first time on, and the game's own policy rests.
        """
        return self._enqueue(f"have {name!r} done for {alliance}", lambda: ask(self._match, alliance, name))

    def take_over(self, alliance: str, by_person: bool = True) -> int:
        """Have a person play the human player of an alliance, or the game's own policy again."""
        return self._enqueue(
            f"let somebody else play {alliance}'s human player", lambda: take_over(self._match, alliance, by_person)
        )

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
        if self._match.persons:
            carry_out(self._match)

    # --- inside ---------------------------------------------------------------------------------------------------

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


def _numbers(owner: str, values: Any, want: str, count: int) -> tuple[float, ...]:
    try:
        numbers = tuple(float(value) for value in values)
    except (TypeError, ValueError, OverflowError):
        numbers = ()
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise ConfigError(f"{owner} is {count} finite numbers, {want}, got {shown(values)}")
    return numbers


def _words(pose: Pose) -> str:
    return f"({pose[0]:.2f}, {pose[1]:.2f}) m, {math.degrees(pose[2]):.0f} deg"
