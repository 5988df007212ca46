"""Test fixture that runs a project's robot program on the simulated field."""

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

_FIRST_LOOP = 1.0  # wall time to wait for the first run of a custom loop before time is stepped [s]
_ENDS = 2.0  # wall time for a failed program to end [s]
_SPAN = Quantity("s", 0.0, 1e6)
_SETTLE = 0.5  # disabled time before the first mode, so that robot code receives alliance and dashboard values [s]
_NOT_STARTED = "the robot program has not finished robotInit"
_NOT_LOOPED = "no robot loop has finished"
_STATIONS = {
    ("blue", 1): hal.AllianceStationID.BLUE_1,
    ("blue", 2): hal.AllianceStationID.BLUE_2,
    ("blue", 3): hal.AllianceStationID.BLUE_3,
    ("red", 1): hal.AllianceStationID.RED_1,
    ("red", 2): hal.AllianceStationID.RED_2,
    ("red", 3): hal.AllianceStationID.RED_3,
}


class ConditionError(SimcoreError, AssertionError):
    """Error for a condition that did not hold within the timeout, or for a mode that a test entered but did not run."""


class _NoSuchNameError(SimcoreError, AttributeError):
    """Error for an unknown attribute of the fixture `sim`."""


class _WarningList(logging.Handler):
    """Log handler that collects warnings in a list without duplicates."""

    def __init__(self, kept: list[str]) -> None:
        super().__init__(logging.WARNING)
        self._kept = kept

    def emit(self, record: logging.LogRecord) -> None:
        """Add the message of a log record to the list, unless the list contains the message."""
        text = record.getMessage()
        if text not in self._kept:
            self._kept.append(text)


class RobotTest:
    """Robot program in a test, provided by the fixture `sim`.

    The program starts when a test first needs the program, and stops at the end of the test. Methods run the robot.
    Properties return the true state of the field and robot, not the robot's estimate.

    Args:
        control: Test controller of the robot, from pyfrc or wpilib.testing.
        robot: Proxy of the robot object.
        hook: Hook that runs the physics in the robot's loop.
        hang: Largest time of one robot loop [s]. After this time, `HangWatch` ends the test process.
        complaints: Stream for the report of `HangWatch`; None for no time limit.

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
        """Proxy of the robot object, from which a test reads the program's state."""
        self.own_threads: list[str] = []
        """Names of the threads that the program has started and that simulated time does not control."""
        self.warnings: list[str] = []
        """Messages of simcore's log warnings in this test, without duplicates."""
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
        """Whether the test has enabled the robot at least once."""
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
                # RobotPy steps one more second, during which WPILib's watchdog would report a missing feed
                controller = sys.modules[type(self._control).__module__]
                for name in {"stepTimingAsync", "step_timing_async"} & vars(controller).keys():
                    quiet.enter_context(patch.object(controller, name, lambda seconds: None))
            self._stack.close()

    # --- driver station -------------------------------------------------------------------------------------------

    def alliance(self, color: str, station: int = 1) -> None:
        """Set the alliance and the driver station.

        Before the first enable, a change of alliance moves the robot to the alliance's start.

        Args:
            color: Alliance, `"blue"` or `"red"`.
            station: Number of the driver station, 1 to 3.

        Raises:
            ConfigError: The alliance or station does not exist.
        """
        if (color, station) not in _STATIONS:
            raise ConfigError(f"alliance must be 'blue' or 'red', and station 1..3, got {color!r}, {station!r}")
        if self.was_enabled and color != self._alliance:
            _log.warning(
                "alliance(%r) after the robot was enabled changes its color and leaves it where it stands: call it "
                "first, or place the robot, too",
                color,
            )
        self._alliance = color
        DriverStationSim.set_alliance_station_id(_STATIONS[color, station])

    def game_data(self, text: str) -> None:
        """Set the game-specific message that robot code reads from the driver station.

        Raises:
            ConfigError: `text` is not a string.
        """
        if not isinstance(text, str):
            raise ConfigError(f"game_data must be a string, as the field sends it, got {text!r}")
        DriverStationSim.set_game_data(text)

    def joystick(self, port: int = 0) -> Joystick:
        """Return the joystick at a driver station port, after centering all axes and releasing all buttons."""
        return Joystick(port)

    def xbox(self, port: int = 0) -> XboxPad:
        """Return the Xbox controller at a driver station port, after centering all axes and releasing all buttons."""
        return XboxPad(port)

    # --- running --------------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Start the robot program and run the robot disabled for half a second of simulated time.

        The methods that run the robot call `start` if the program has not started. A second call has no effect.

        Raises:
            SimcoreError: The program does not run the physics. Errors in the robot code propagate.
        """
        if self._physics is not None:
            return
        prepare()  # the first start on a computer takes longer than the time limit of a robot loop
        DriverStationSim.set_ds_attached(True)
        DriverStationSim.set_enabled(False)
        note_threads()
        self._run_robot()
        self._step()  # waits until the program has built its physics
        if self._hook.engine is None:
            self._control._thread.join(_ENDS)  # the program ends if the physics could not be built
            self._raise_error_of_robot()
            raise SimcoreError(
                f"no physics: {self._robot_name} has its own loop, which calls neither _simulationInit nor "
                f"_simulationPeriodic; {self._place()}"
            )
        physics = next(engine for engine in self._hook.engine if isinstance(engine, RobotPhysics))
        require_varied(physics.match)
        self._physics = physics
        self._stack.callback(gc.unfreeze)  # the physics has called gc.freeze
        physics.match.sinks.extend(self._sinks)
        physics.match.record.warnings = self.warnings
        self.run(_SETTLE)
        if physics.times.ticks == 0:
            raise SimcoreError(
                f"no tick of physics has run in {_SETTLE:g} s: the loop of {self._robot_name} never calls "
                f"_simulationPeriodic; {self._place()}"
            )

    def place(self, x: float, y: float, heading: float = 0.0) -> None:
        """Place the robot at rest at a pose on the field, without changing the program's estimated pose.

        After this call, an odometry reset in robot code no longer moves the robot.

        Args:
            x: x coordinate [m], field frame with the origin at the blue corner for both alliances.
            y: y coordinate [m], field frame.
            heading: Heading, counter-clockwise from the direction to the red alliance wall [rad].

        Raises:
            ConfigError: The pose is off the field or obstructed. The message suggests a free pose.
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
        """Select an auto if `name` is given, and run autonomous.

        The robot starts at the first available of these poses: `start`, the pose from `place`, the start of the auto in
        `simcore.toml`, the pose to which the auto resets the odometry, the present pose.

        Args:
            name: Name of the auto in a dashboard chooser, or of an autonomous op mode; None for the present selection.
            seconds: Duration [s]. The robot stays enabled after this duration.
            start: Start pose, field frame [m, m, rad], or a Pose2d; None for one of the other poses.

        Raises:
            UnknownNameError: No chooser offers the name. The message lists the options.
            ConfigError: `name` is not a string, or robot code has no chooser.
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
                self.run(2 * TICK)  # a chooser receives the choice at the end of a loop
        self._auto = name or ", ".join(active_choices())
        self._enter("autonomous")
        self.run(seconds)

    def teleop(self, name: str = "", *, seconds: float = 0.0) -> None:
        """Run teleop for a duration [s].

        Args:
            name: Name of the op mode of an OpModeRobot; empty for the first op mode.
            seconds: Duration [s]. The robot stays enabled after this duration.
        """
        self._play("teleop", name, seconds)

    def utility(self, name: str = "", *, seconds: float = 0.0) -> None:
        """Run the utility mode (`test` until 2026) for a duration [s].

        Args:
            name: Name of the op mode of an OpModeRobot; empty for the first op mode.
            seconds: Duration [s]. The robot stays enabled after this duration.
        """
        self._play("utility", name, seconds)

    def disable(self, *, seconds: float = 0.0) -> None:
        """Disable the robot, and run the disabled robot for a duration [s]."""
        self.start()
        self._enter("disabled")
        self.run(seconds)

    def run(self, seconds: float) -> None:
        """Run the robot in the present mode for a duration [s], rounded to whole ticks of 20 ms.

        Raises:
            ConfigError: `seconds` is not a finite number >= 0.
        """
        require("run", "seconds", seconds, _SPAN)
        self.start()
        for _ in range(round(seconds / TICK)):
            self._step()

    def run_until(self, condition: Callable[[], object], *, timeout: float) -> float:
        """Run the robot in the present mode until a condition holds, and check the condition every 20 ms.

        Args:
            condition: Function that returns whether the condition holds, e.g. `lambda: sim.pieces.held >= 8`.
            timeout: Largest simulated time to run [s].

        Returns:
            Simulated time until the condition held [s].

        Raises:
            ConditionError: The condition did not hold within the timeout.
            ConfigError: `condition` is not a function, or `timeout` is not a finite number >= 0.
        """
        if not callable(condition):
            raise ConfigError(
                "run_until needs a function that is called after each tick, e.g. lambda: sim.pieces.held >= 8; got "
                f"{condition!r}"
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
        """Raise an AttributeError for an unknown attribute, with a suggestion of a similar name."""
        if name.startswith("_"):
            raise AttributeError(name)
        parts = {"pieces": PieceCount, "score": Score, "record": RunRecord, "match": Match, "robot_sim": Robot}
        near = nearest(name, [key for key in dir(type(self)) if not key.startswith("_")])
        for part, cls in parts.items():
            if name in dir(cls) or name in getattr(cls, "__dataclass_fields__", ()):
                near = f" Did you mean 'sim.{part}.{name}'?"
                break
        raise _NoSuchNameError(f"sim has no {name!r}.{near} Everything it has: docs/testing.md")

    # --- true state -----------------------------------------------------------------------------------------------

    @property
    def belief_error(self) -> BeliefError:
        """Error of the program's estimated pose relative to the true pose."""
        return self.physics.belief.error

    @property
    def physics(self) -> RobotPhysics:
        """Physics of the project. The first access starts the robot program."""
        self.start()
        assert self._physics is not None
        return self._physics

    @property
    def match(self) -> Match:
        """Match that the robot plays."""
        return self.physics.match

    @property
    def robot_sim(self) -> Robot:
        """Simulated robot of the program in the match."""
        return self.physics.robot_sim

    @property
    def game(self) -> Match:
        """Alias of `match`."""
        return self.match

    @property
    def plant(self) -> Robot:
        """Alias of `robot_sim`."""
        return self.robot_sim

    @property
    def time(self) -> float:
        """Simulated time since the robot program started [s]."""
        return float(Timer.get_monotonic_timestamp()) % season.EPOCH

    @property
    def pose(self) -> Any:
        """True pose of the robot in the field frame, as a Pose2d."""
        x, y, yaw = self.robot_sim.chassis.pose
        return Pose2d(x, y, yaw)

    @property
    def score(self) -> Score:
        """Points that each alliance has scored so far."""
        return self.match.score

    @property
    def pieces(self) -> PieceCount:
        """Numbers of pieces `held`, `scored`, `on_field` and `in_flight`."""
        return self.match.count

    @property
    def battery(self) -> Battery:
        """Battery of the robot, with present voltage, lowest voltage and total current."""
        return self.robot_sim.battery

    @property
    def currents(self) -> dict[str, list[float]]:
        """Currents of the drivetrain's motors [A], by group, for example `drive` and `steer` or `left` and `right`."""
        return self.robot_sim.drive.motor_currents()

    @property
    def record(self) -> RunRecord:
        """Record of the run for pages and reports, with shots, intakes, placements, distances and extreme values."""
        return self.match.record

    @property
    def digest(self) -> str:
        """Digest of all motion since the start. Two bit-identical runs have equal digests."""
        return self.match.digest.hexdigest()

    @property
    def realtime_factor(self) -> float:
        """Simulated time divided by wall time since the start [-]."""
        return self._ran / self._wall if self._wall > 0.0 else math.nan

    # --- output of a failed test -------------------------------------------------------------------------------------

    def add_sink(self, sink: TelemetrySink) -> None:
        """Add a telemetry sink, which receives snapshots from the next tick on."""
        self._sinks.append(sink)
        if self._physics is not None:
            self._physics.match.sinks.append(sink)

    @property
    def has_run(self) -> bool:
        """Whether the robot program has started."""
        return self._physics is not None

    def require_played(self) -> None:
        """Check that the robot has run for at least one tick in the present mode.

        Raises:
            ConditionError: The test has entered the mode without running a tick.
        """
        if not self._is_played:
            raise ConditionError(
                f"{self._mode} has begun, but 0 s of it have run: say how long, e.g. {self._mode}(seconds=10), or "
                "continue with run(10)"
            )

    def __repr__(self) -> str:
        """Describe the state of the run, for the output of a failed assertion."""
        return f"<sim at {self.summary()}>" if self.has_run else "<sim before its start>"

    def summary(self) -> str:
        """Return one line with time, auto, alliance, mode, robot pose and score."""
        x, y, yaw = self.robot_sim.chassis.pose
        auto = f"auto {self._auto!r}, " if self._auto else ""
        return (
            f"{self.time:.2f} s, {auto}{self._alliance}, {self._mode}, robot at ({x:.2f}, {y:.2f}) m, "
            f"{math.degrees(yaw):.0f} deg, score blue {self.score.blue} red {self.score.red}"
        )

    # --- internals ------------------------------------------------------------------------------------------------

    def _run_robot(self) -> None:
        try:
            with self._watched(_NOT_STARTED):
                self._stack.enter_context(self._control.run_robot())
        except AssertionError as error:  # raised by pyfrc if robotInit has not finished
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
            self._enter("disabled")  # as on a real field between auto and teleop
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
                "%s has its own threads (%s): simulated time does not step them, so two runs may differ",
                *(self._robot_name, ", ".join(new)),
            )

    @contextmanager
    def _watched(self, awaited: str) -> Iterator[None]:
        """Limit the time of the context's body. `HangWatch` reports a hanging program and ends the process."""
        if self._watch is not None:
            self._watch.arm(awaited)
        try:
            yield
        finally:
            if self._watch is not None:
                self._watch.disarm()

    def _advance(self, seconds: float) -> None:
        """Step the clock by a simulated time [s], from loop to loop for a MagicBot.

        A step of WPILib's clock blocks until threads wait on all notifiers. A MagicBot frees the loop's notifier
        between two modes. Time must therefore not advance until the MagicBot has reached the first loop of the next
        mode.
        """
        left = round(1e6 * seconds)
        while left > 0:
            until_loop = left if self._loop is None else round(1e6 * (self._next_loop - self._now()))
            step = min(left, until_loop) if until_loop > 0 else left
            step_timing(1e-6 * (step + 0.5))  # the HAL truncates to whole microseconds
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
        """Wait until the condition holds, the program has ended, or the wall time `patience` [s] has passed."""
        end = time.monotonic() + patience
        while not condition() and self._control.robot_is_alive and time.monotonic() < end:
            time.sleep(0.0002)

    def _where(self) -> str:
        """Return the source line that the program is executing on the robot's thread, or else on another thread.

        The text is empty if no thread is executing a line of the program.
        """
        frames = sys._current_frames()
        robot = getattr(self._control._thread, "ident", None) or 0
        rest = (frame for ident, frame in frames.items() if ident not in (robot, threading.main_thread().ident))
        return program_line([*filter(None, [frames.get(robot)]), *rest])

    def _place(self) -> str:
        """Return the text `it is at LINE`, with the source line that the program is executing."""
        return f"it is at {self._where() or NO_LINE}"


def _require_name(mode: str, name: object) -> None:
    """Check that a mode's name is a string, because a test may pass a duration by mistake.

    Raises:
        ConfigError: The name is neither a string nor None.
    """
    if name is not None and not isinstance(name, str):
        raise ConfigError(
            f"{mode}({name!r}): the auto's name must be a string, and seconds a keyword argument: "
            f"{mode}(seconds={name!r})"
        )
