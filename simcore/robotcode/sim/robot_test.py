"""A robot under test: the program of a project on its simulated field, driven step by step."""

from __future__ import annotations

import gc
import logging
import math
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from types import TracebackType
from typing import Any, TextIO
from unittest.mock import patch

from simcore import season
from simcore.errors import ConfigError, SimcoreError, nearest
from simcore.loop.step import prepare
from simcore.match.match import Match
from simcore.match.run_record import PieceCount, RunRecord
from simcore.match.scoring import Score
from simcore.quantities import START, Quantity, require, require_row
from simcore.robot.battery import Battery
from simcore.robot.robot import Robot
from simcore.robotcode.sim.attach import PhysicsHook
from simcore.robotcode.sim.belief_watch import BeliefError
from simcore.robotcode.sim.driver_controls import Joystick, XboxPad, active_choices, choose_auto
from simcore.robotcode.sim.hang_watch import NO_LINE, HangWatch, program_line
from simcore.robotcode.sim.repeatable_runs import note_threads, started_threads
from simcore.robotcode.sim.robot_physics import RobotPhysics
from simcore.robotcode.sim.run_variation import require_varied
from simcore.telemetry.snapshot import TelemetrySink
from simcore.units import TICK

Timer = season.wpilib.Timer
DriverStationSim = season.wpilib_simulation.DriverStationSim
step_timing = season.wpilib_simulation.step_timing
Pose2d = season.wpimath.Pose2d
hal = season.hal

__all__ = ["ConditionError", "RobotTest"]

_log = logging.getLogger(__name__)

_FIRST_LOOP = 1.0  # wall time in which a loop of the program's own may come before time is stepped [s]
_ENDS = 2.0  # wall time in which a program that has failed ends [s]
_SPAN = Quantity("s", 0.0, 1e6)
_SETTLE = 0.5  # [s]; disabled before the first mode: the alliance becomes known, the dashboard is filled
_NOT_STARTED = "the robot program has not come through robotInit"
_NOT_LOOPED = "no robot loop has come to its end"
_STATIONS = {
    ("blue", 1): hal.AllianceStationID.BLUE_1,
    ("blue", 2): hal.AllianceStationID.BLUE_2,
    ("blue", 3): hal.AllianceStationID.BLUE_3,
    ("red", 1): hal.AllianceStationID.RED_1,
    ("red", 2): hal.AllianceStationID.RED_2,
    ("red", 3): hal.AllianceStationID.RED_3,
}


class ConditionError(SimcoreError, AssertionError):
    """What a test waited for did not happen in time."""


class _NoSuchNameError(SimcoreError, AttributeError):
    """A test asks the fixture for what it does not have."""


class _WarningList(logging.Handler):
    """Keeps warnings in a list, each once."""

    def __init__(self, kept: list[str]) -> None:
        super().__init__(logging.WARNING)
        self._kept = kept

    def emit(self, record: logging.LogRecord) -> None:
        """Take one."""
        text = record.getMessage()
        if text not in self._kept:
            self._kept.append(text)


class RobotTest:
    """The fixture `sim`: starts the robot program at the first call that needs it, and stops it at the end.

    Methods run the robot, properties read the truth of the field, not what the robot believes.

    Args:
        control: Test controller, of pyfrc or of wpilib.testing, of the robot.
        robot: Proxy of the robot object.
        hook: Physics in its loop.
        hang: How long one robot loop may take before the test ends with one sentence [s]; see `HangWatch`.
        complaints: Where that goes; None: nothing ends it.

    Example:
        def test_the_auto_scores(sim):
            sim.alliance("red")
            sim.autonomous("two cycles", seconds=20)
            assert sim.score.red >= 8
    """

    def __init__(
        self,
        control: Any,
        robot: Any,
        hook: PhysicsHook,
        *,
        hang: float = 9.0,
        complaints: TextIO | None = None,
    ) -> None:
        self.robot = robot
        """The robot object, to look at what it believes; a proxy."""
        self.own_threads: list[str] = []
        """Names of the threads that the program has started: where there are any, two runs may differ."""
        self.warnings: list[str] = []
        """What simcore has warned of so far, each once."""
        self._control = control
        self._hook = hook
        self._loop: float | None = getattr(robot, "control_loop_wait_time", None)  # of a MagicBot [s]
        self._watch = None if complaints is None else HangWatch(hang, self._where, complaints)
        self._stack = ExitStack()
        self._physics: RobotPhysics | None = None
        self._wall = 0.0
        self._ran = 0.0
        self._steps = 0
        self._sinks: list[TelemetrySink] = []
        self._mode = "disabled"
        self._is_played = True
        self.was_enabled = False
        """Whether the robot has been enabled: before that nothing falls short."""
        self._auto = self._op_mode = ""
        self._alliance = "blue"
        handler = _WarningList(self.warnings)
        logging.getLogger("simcore").addHandler(handler)
        self._stack.callback(logging.getLogger("simcore").removeHandler, handler)
        self.alliance("blue")

    def __enter__(self) -> RobotTest:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        if self._physics is not None and kind is None:
            DriverStationSim.set_enabled(False)
        with ExitStack() as quiet:
            if self.has_run and not self._control.robot_is_alive:
                # RobotPy steps one more second, in which WPILib's watchdog would complain that nobody feeds it
                controller = sys.modules[type(self._control).__module__]
                for name in {"stepTimingAsync", "step_timing_async"} & vars(controller).keys():
                    quiet.enter_context(patch.object(controller, name, lambda seconds: None))
            self._stack.close()

    # --- driver station -------------------------------------------------------------------------------------------

    def alliance(self, color: str, station: int = 1) -> None:
        """Play for `"blue"` or `"red"`, at station 1..3. Until the first enable the robot is carried to its start.

        Raises:
            ConfigError: There is no such place.
        """
        if (color, station) not in _STATIONS:
            raise ConfigError(f"alliance: want 'blue' or 'red' and a station 1..3, got {color!r}, {station!r}")
        if self.was_enabled and color != self._alliance:
            _log.warning(
                "alliance(%r) after the robot was enabled changes its color and leaves it where it stands: call it "
                "first, or place the robot, too",
                color,
            )
        self._alliance = color
        DriverStationSim.set_alliance_station_id(_STATIONS[color, station])

    def game_data(self, text: str) -> None:
        """The game-specific message.

        Raises:
            ConfigError: It is no text.
        """
        if not isinstance(text, str):
            raise ConfigError(f"game_data: want a text, as the field sends it, got {text!r}")
        DriverStationSim.set_game_data(text)

    def joystick(self, port: int = 0) -> Joystick:
        """A joystick at a port, let go of."""
        return Joystick(port)

    def xbox(self, port: int = 0) -> XboxPad:
        """An Xbox controller at a port, let go of."""
        return XboxPad(port)

    # --- running --------------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Start the robot program, disabled, for half a second; the other methods do so by themselves."""
        if self._physics is not None:
            return
        prepare()  # the first time on a computer it takes longer than a program may hang
        DriverStationSim.set_ds_attached(True)
        DriverStationSim.set_enabled(False)
        note_threads()
        self._run_robot()
        self._step()  # waits until the program has built its physics
        if self._hook.engine is None:
            self._control._thread.join(_ENDS)  # where its physics could not be built the program is about to end
            self._raise_error_of_robot()
            raise SimcoreError(
                f"no physics: the loop of {self._robot_name} is its own, and calls neither _simulationInit nor "
                f"_simulationPeriodic; {self._place()}"
            )
        physics = next(engine for engine in self._hook.engine if isinstance(engine, RobotPhysics))
        require_varied(physics.match)
        self._physics = physics
        self._stack.callback(gc.unfreeze)  # the physics has frozen what was built
        physics.match.sinks.extend(self._sinks)
        physics.match.record.warnings = self.warnings
        self.run(_SETTLE)
        if physics.times.ticks == 0:
            raise SimcoreError(
                f"no tick of physics has run in {_SETTLE:g} s: the loop of {self._robot_name} never calls "
                f"_simulationPeriodic; {self._place()}"
            )

    def place(self, x: float, y: float, heading: float = 0.0) -> None:
        """Put the robot truly there, at rest; what it believes is the program's affair.

        An auto that resets its odometry does not carry it elsewhere any more.

        Args:
            x: Field frame, from the blue corner, whatever the alliance [m].
            y: [m]
            heading: Counter-clockwise from the direction to the red wall [rad].

        Raises:
            ConfigError: It cannot stand there; the text says where it can.
        """
        require_row("place", "x, y and heading", (x, y, heading), START)
        self.physics.auto_start.place((float(x), float(y), float(heading)))

    def autonomous(
        self,
        name: str | None = None,
        *,
        seconds: float = 15.0,
        start: tuple[float, float, float] | Any = None,
    ) -> None:
        """Run autonomous.

        The robot starts where `start` says, else where it was placed, else at the start of this auto in `simcore.toml`,
        else where the auto resets its odometry to, else where it stands.

        Args:
            name: Of the auto, as the dashboard's chooser shows it; None leaves the choice as it is.
            seconds: How long; the robot stays enabled after it.
            start: As `place` wants it [m, m, rad].

        Raises:
            UnknownNameError: No chooser has that name; the text lists what there is.
        """
        _require_name("autonomous", name)
        self.start()
        if start is not None:
            self.place(*((start.x, start.y, start.rotation().radians()) if isinstance(start, Pose2d) else start))
        if name is not None:
            if name in season.op_modes("autonomous"):
                self._op_mode = name
            else:
                choose_auto(name)
            if self._mode == "disabled":
                self.run(2 * TICK)  # a chooser hears of it at the end of a loop
        self._auto = name or ", ".join(active_choices())
        self._enter("autonomous")
        self.run(seconds)

    def teleop(self, name: str = "", *, seconds: float = 0.0) -> None:
        """Run teleop, e.g. after moving the sticks; of an OpModeRobot the mode of this name, else its first."""
        self._play("teleop", name, seconds)

    def utility(self, name: str = "", *, seconds: float = 0.0) -> None:
        """Run the utility mode, which was `test` until 2026; `name` as of `teleop`."""
        self._play("utility", name, seconds)

    def disable(self, *, seconds: float = 0.0) -> None:
        """Disable, and wait."""
        self.start()
        self._enter("disabled")
        self.run(seconds)

    def run(self, seconds: float) -> None:
        """Go on in the present mode.

        Raises:
            ConfigError: `seconds` is not a finite number >= 0.
        """
        require("run", "seconds", seconds, _SPAN)
        self.start()
        for _ in range(round(seconds / TICK)):
            self._step()

    def run_until(self, condition: Callable[[], object], *, timeout: float) -> float:
        """Go on until a condition holds; it is asked after each 20 ms.

        Args:
            condition: E.g. `lambda: sim.pieces.held >= 8`.
            timeout: Simulated time after which it is an error [s].

        Returns:
            How long it took, simulated [s].

        Raises:
            ConditionError: It did not hold in time.
            ConfigError: The condition is no function, or the time no number of seconds.
        """
        if not callable(condition):
            raise ConfigError(
                f"run_until: want a function that is asked after each tick, e.g. lambda: sim.pieces.held >= 8; "
                f"got {condition!r}"
            )
        require("run_until", "timeout", timeout, _SPAN)
        self.start()
        begin = self.time
        for _ in range(round(timeout / TICK)):
            if condition():
                return self.time - begin
            self._step()
        if condition():
            return self.time - begin
        raise ConditionError(
            f"the condition did not hold within {timeout:g} s; at its end the robot is at {self.pose}, {self._mode}"
        )

    def __getattr__(self, name: str) -> Any:
        """Say where a name is that the fixture does not have itself."""
        if name.startswith("_"):
            raise AttributeError(name)
        parts = {"pieces": PieceCount, "score": Score, "record": RunRecord, "match": Match, "robot_sim": Robot}
        near = nearest(name, [key for key in dir(type(self)) if not key.startswith("_")])
        for part, cls in parts.items():
            if name in dir(cls) or name in getattr(cls, "__dataclass_fields__", ()):
                near = f" Did you mean 'sim.{part}.{name}'?"
                break
        raise _NoSuchNameError(f"sim has no {name!r}.{near} All that it has: docs/testing.md")

    # --- truth ----------------------------------------------------------------------------------------------------

    @property
    def belief_error(self) -> BeliefError:
        """How far what the robot believes is from the truth: `position` [m] and `heading` [rad]."""
        return self.physics.belief.error

    @property
    def physics(self) -> RobotPhysics:
        """The project's PhysicsEngine."""
        self.start()
        assert self._physics is not None
        return self._physics

    @property
    def match(self) -> Match:
        """The match, with everything on the field."""
        return self.physics.match

    @property
    def robot_sim(self) -> Robot:
        """The robot in the match."""
        return self.physics.robot_sim

    @property
    def game(self) -> Match:
        """The same as `match`."""
        return self.match

    @property
    def plant(self) -> Robot:
        """The same as `robot_sim`."""
        return self.robot_sim

    @property
    def time(self) -> float:
        """Since the robot program started, simulated [s]."""
        return float(Timer.get_monotonic_timestamp()) % season.EPOCH

    @property
    def pose(self) -> Any:
        """Where the robot truly is."""
        x, y, yaw = self.robot_sim.chassis.pose
        return Pose2d(x, y, yaw)

    @property
    def score(self) -> Score:
        """Points so far."""
        return self.match.score

    @property
    def pieces(self) -> PieceCount:
        """Where all pieces are: `held`, `scored`, `on_field`, `in_flight`."""
        return self.match.count

    @property
    def battery(self) -> Battery:
        """Voltage, its lowest so far, and the whole robot's current."""
        return self.robot_sim.battery

    @property
    def currents(self) -> dict[str, list[float]]:
        """In the motors of the drivetrain [A], by group: `drive` and `steer` of swerve, `left` and `right` of tank."""
        return self.robot_sim.drive.motor_currents()

    @property
    def record(self) -> RunRecord:
        """Shots, pieces taken in, placements, ways and extremes: what the pages and reports of the run say."""
        return self.match.record

    @property
    def digest(self) -> str:
        """Of everything that moved since the start: equal if and only if two runs were the same to the last bit."""
        return self.match.digest.hexdigest()

    @property
    def realtime_factor(self) -> float:
        """How many times faster than real time the robot ran so far."""
        return self._ran / self._wall if self._wall > 0.0 else math.nan

    # --- what a failed test leaves -----------------------------------------------------------------------------------

    def add_sink(self, sink: TelemetrySink) -> None:
        """Log telemetry there, from the next tick on."""
        self._sinks.append(sink)
        if self._physics is not None:
            self._physics.match.sinks.append(sink)

    @property
    def has_run(self) -> bool:
        """Whether the robot program has started."""
        return self._physics is not None

    def require_played(self) -> None:
        """Refuse what a test says of a mode that it has begun and not played a tick of.

        Raises:
            ConditionError: It is so.
        """
        if not self._is_played:
            raise ConditionError(
                f"{self._mode} was begun and 0 s of it were played: say how long, e.g. {self._mode}(seconds=10), or go "
                "on with run(10)"
            )

    def __repr__(self) -> str:
        """Show a failed assertion where the run was."""
        return f"<sim at {self.summary()}>" if self.has_run else "<sim before its start>"

    def summary(self) -> str:
        """One line: the auto, and where robot and score stand."""
        x, y, yaw = self.robot_sim.chassis.pose
        auto = f"auto {self._auto!r}, " if self._auto else ""
        return (
            f"{self.time:.2f} s, {auto}{self._alliance}, {self._mode}, robot at ({x:.2f}, {y:.2f}) m, "
            f"{math.degrees(yaw):.0f} deg, score blue {self.score.blue} red {self.score.red}"
        )

    # --- inside ---------------------------------------------------------------------------------------------------

    def _run_robot(self) -> None:
        try:
            with self._watched(_NOT_STARTED):
                self._stack.enter_context(self._control.run_robot())
        except AssertionError as error:  # pyfrc's: it has not come to its end of robotInit
            self._raise_error_of_robot()
            raise SimcoreError(f"{_NOT_STARTED}; {self._place()}") from error
        if not isinstance(self.robot, (season.wpilib.IterativeRobotBase, *season.loop_classes())):
            self._wait(lambda: self._hook.last_loop is not None, _FIRST_LOOP)

    @property
    def _robot_name(self) -> str:
        return str(self.robot.__class__.__name__)

    def _raise_error_of_robot(self) -> None:
        error = self._control._reraise.exception
        if error is not None:
            self._control._thread.join(_ENDS)
            self._control._reraise.reset()
            raise error

    def _play(self, mode: str, name: str, seconds: float) -> None:
        _require_name(mode, name)
        self.start()
        self._op_mode = name
        self._enter(mode)
        self.run(seconds)

    def _enter(self, mode: str) -> None:
        if mode == self._mode:
            return
        if self._mode != "disabled" and mode != "disabled":
            self._enter("disabled")  # as the field does between auto and teleop
            self.run(5 * TICK)
        self.require_played()
        self._mode = mode
        if mode != "disabled":
            self._is_played, self.was_enabled = False, True
            season.set_mode(mode, self._op_mode)
        DriverStationSim.set_enabled(mode != "disabled")

    def _step(self) -> None:
        begin = time.perf_counter()
        DriverStationSim.notify_new_data()
        self._is_played = True
        with self._watched(_NOT_LOOPED):
            self._advance(TICK)
        self._wall += time.perf_counter() - begin
        self._ran += TICK
        self._steps += 1
        self._name_threads()
        self._raise_error_of_robot()
        if not self._control.robot_is_alive:
            raise SimcoreError("the robot program has ended by itself: startCompetition returned")

    def _name_threads(self) -> None:
        new = [name for name in started_threads() if name not in self.own_threads]
        if new:
            self.own_threads += new
            _log.warning(
                "%s has threads of its own (%s): nobody steps them, so two runs may differ",
                *(self._robot_name, ", ".join(new)),
            )

    @contextmanager
    def _watched(self, awaited: str) -> Iterator[None]:
        """End the process with one sentence where the program hangs in what is inside."""
        if self._watch is not None:
            self._watch.arm(awaited)
        try:
            yield
        finally:
            if self._watch is not None:
                self._watch.disarm()

    def _advance(self, seconds: float) -> None:
        """Step time from loop to loop.

        Whoever steps WPILib's clock waits until all notifiers are waited for. A MagicBot frees its own between two
        modes: time must not go on before it has come to the first loop of the next mode.
        """
        left = round(1e6 * seconds)
        while left > 0:
            until_loop = left if self._loop is None else round(1e6 * (self._next_loop - self._now()))
            step = min(left, until_loop) if until_loop > 0 else left
            step_timing(1e-6 * (step + 0.5))  # which cuts to whole microseconds
            left -= step
            if self._loop is not None:
                self._wait(lambda: self._now() < self._next_loop - 1e-6)

    @property
    def _next_loop(self) -> float:
        assert self._loop is not None
        return (self._hook.last_loop or 0.0) + self._loop

    def _now(self) -> float:
        return float(Timer.get_monotonic_timestamp())

    def _wait(self, condition: Callable[[], bool], patience: float = math.inf) -> None:
        """Wait for the program's thread, this wall time [s] at most, until the condition holds or it has ended."""
        end = time.monotonic() + patience
        while not condition() and self._control.robot_is_alive and time.monotonic() < end:
            time.sleep(0.0002)

    def _where(self) -> str:
        """Return the line of the program that its thread, or else another one but this, is at; else nothing."""
        frames = sys._current_frames()
        robot = getattr(self._control._thread, "ident", None) or 0
        rest = (frame for ident, frame in frames.items() if ident not in (robot, threading.main_thread().ident))
        return program_line([*filter(None, [frames.get(robot)]), *rest])

    def _place(self) -> str:
        """Say where the program is, as the end of a sentence."""
        return f"it is at {self._where() or NO_LINE}"


def _require_name(mode: str, name: object) -> None:
    """Refuse a number of seconds in the place of a name."""
    if name is not None and not isinstance(name, str):
        raise ConfigError(
            f"{mode}({name!r}): the name of a mode is text, and seconds are given by name: {mode}(seconds={name!r})"
        )
