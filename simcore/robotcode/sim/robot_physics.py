"""Physics that advances a match in the robot loops of `robotpy sim` and `robotpy test`."""

from __future__ import annotations

import atexit
import gc
import logging
import math
import sys
import time
import weakref
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from simcore import season
from simcore.errors import ConfigError
from simcore.match.field_control import FieldControl
from simcore.match.match import Match
from simcore.robotcode.networktables.control_topics import ControlTopics
from simcore.robotcode.networktables.limelight_table import CameraTables
from simcore.robotcode.networktables.network_clock import NetworkClock
from simcore.robotcode.program import program_odometry
from simcore.robotcode.program.makers import require_distinct_devices
from simcore.robotcode.program.motor_ports import MotorDevices
from simcore.robotcode.sim.auto_start import AutoStart
from simcore.robotcode.sim.belief_watch import BeliefWatch
from simcore.robotcode.sim.connected_devices import ConnectedDevices, DrivetrainDevices
from simcore.robotcode.sim.repeatable_runs import fastest_period
from simcore.robotcode.sim.robot_inputs import DriverStationLink, FieldView
from simcore.robotcode.sim.robot_power import PowerDistributionView, RoboRioPower
from simcore.units import TICK

if TYPE_CHECKING:
    from simcore.robotcode.sim.simulated_phoenix import PhoenixTime

is_timing_paused = season.hal_simulation.is_timing_paused
IterativeRobotBase = season.wpilib.IterativeRobotBase
Timer = season.wpilib.Timer
ntcore = season.ntcore

__all__ = ["LatenessReport", "PhysicsTimes", "RobotPhysics", "field_control", "latest_physics"]

_log = logging.getLogger(__name__)

_MOST_OWED = 0.1  # longest delay that physics catches up; physics skips the rest of a longer delay [s]
# When several parts run in a row after a stall, each part waits for the devices, which run at 1 kHz on the wall clock,
# to respond to the last part. Voltages from before the stall would make steer motors oscillate.
_ANSWER = 0.0015  # time to wait for the devices [s]
_FINEST = 1, 2, 4, 5, 10, 20  # possible numbers of parts per tick, each of whole milliseconds
_HISTORY = 6000  # number of ticks in the timing statistics, two minutes
_ANY_LOOP = 0.005  # assumed period of a custom loop [s]
_LATE_EVERY = 10.0  # default time between two reports of skipped time [s]
_MOST_MS = 15.0  # longest acceptable tick, because robot code also needs part of the 20 ms [ms]
_AT_START = 2.0  # default time before the first report, because every computer is late while a program starts [s]


@dataclass(frozen=True, slots=True, kw_only=True)
class PhysicsTimes:
    """Statistics of the physics' computing time and lateness."""

    ticks: int
    median_ms: float
    """Median wall time that physics takes to compute a 20 ms tick [ms]."""
    p99_ms: float
    max_ms: float
    late_parts: int
    """Number of parts that physics ran immediately after the previous part to catch up."""
    skipped: float
    """Simulated time that physics skipped because the robot program was blocked too long [s]."""
    late_loops: int
    """Number of robot loops that started more than half a period late."""
    lateness_ms: float
    """99th percentile of the lateness of parts, equal to the age of rotor readings, in a wall-clock test [ms]."""


class RobotPhysics:
    """Base class of the `PhysicsEngine` in a team's physics.py.

    The class advances a match with the robot program. All work runs on the robot's thread, in parts of a tick. Each
    part reads voltages from the devices, advances the match and writes the sensors. A TimedRobot of any period runs the
    parts through `addPeriodic`. A robot with another loop, such as a MagicRobot, runs all due parts once per loop, in
    `_simulationPeriodic`.

    Args:
        physics_controller: Object whose attribute `field` is the Field2d of the simulation window.
        robot: Robot object of the program.
        match: Match that contains the robot; closed when the program ends.
        number: Index of this program's robot in the match.
        drivetrain: Devices of the drivetrain, e.g. `SwerveDrivetrainSim`; None if the robot has no drivetrain.
        motors: Devices of the mechanisms, e.g. `TalonFXMotorSim`.
        parts: Number of parts per tick. None selects 4 parts of 5 ms on the wall clock. In simulated time, None selects
            1 part for a robot with a 20 ms loop, in the middle of the loop, and more parts of at least 1 ms if the
            robot loop, a Notifier or an `addPeriodic` function is faster.
        pace_tests: Whether tests with CTRE's own simulation (`--phoenix=real`) run at wall-clock speed, so that Phoenix
            6 loops behave as on a real robot. False makes these tests run as fast as possible. Tests in simulated time,
            the default, always run as fast as possible.
        auto_starts: Start poses of autos by dashboard name, for the blue alliance, field frame [m, m, rad]. Any other
            auto starts at the pose to which robot code resets the drivetrain's pose.

    Raises:
        ConfigError: Two devices share one simulation, an object is not a device, `parts` is not a whole number from 1
            to 20, or the match has no robot `number`.
    """

    def __init__(
        self,
        physics_controller: Any,
        robot: Any,
        *,
        match: Match,
        number: int = 0,
        drivetrain: DrivetrainDevices | None = None,
        motors: Sequence[MotorDevices] = (),
        parts: int | None = None,
        pace_tests: bool = True,
        auto_starts: Mapping[str, tuple[float, float, float]] | None = None,
    ) -> None:
        if number not in range(len(match.robots)):
            raise ConfigError(f"RobotPhysics: the match has robots 0 to {len(match.robots) - 1}, got number={number!r}")
        if not (parts is None or (isinstance(parts, int) and 1 <= parts <= 20)):
            raise ConfigError(f"RobotPhysics: parts must be a whole number from 1 to 20, got {parts!r}")
        require_distinct_devices()
        self.robot = robot
        """Robot object of the program."""
        self.match = match
        self.robot_sim = match.robots[number]
        """Robot that the program drives in the match."""
        self._phoenix = _phoenix_time()
        self._period = _period_of(robot)
        can_wait = self._phoenix is not None and drivetrain is not None and self._period >= TICK  # one part is enough
        self._devices = ConnectedDevices(self.robot_sim, drivetrain, motors, clock=self._phoenix)
        self.robot_sim.connect(self._devices)
        self._start: float | None = None
        self._done = 0
        self._h = TICK  # until `_set_parts`
        self._part = 0
        self._has_periodic = _has_wpilib_loop(type(robot))
        self._may_follow = parts is None and is_timing_paused() and self._has_periodic
        self._set_parts(parts or (1 if can_wait else 4))
        # Devices on the wall clock: CTRE's own simulation.
        self._has_real_devices = self._phoenix is None and "phoenix6" in sys.modules
        self._pace_tests = pace_tests and self._has_real_devices
        self._lateness = LatenessReport()
        self._late: deque[float] = deque(maxlen=4 * _HISTORY)
        # In simulated time, no user watches the map, and drawing all pieces takes half a millisecond.
        self._view = FieldView(physics_controller.field, every=10 if self._phoenix is None else 50)
        self._estimated_pose = getattr(drivetrain, "estimated_pose", program_odometry.estimated_pose)
        self.auto_start = AutoStart(match, number, auto_starts or {}, believed=self._estimated_pose)
        """Placement of the robot at the start pose of autonomous."""
        program_odometry.set_truth(lambda: self.robot_sim.chassis.pose)
        self.belief = BeliefWatch(self.robot_sim, sees=self._has_cameras, why_still=program_odometry.why_still)
        """Check of the program's odometry against the simulated pose."""
        getattr(drivetrain, "on_pose_reset", program_odometry.on_pose_reset)(self._see_reset)
        match.control.placed.append(self._note_place)
        network = ntcore.NetworkTableInstance.get_default()
        self._clock = match.network.clock if isinstance(match.network, CameraTables) else NetworkClock()
        # In tests, where the instance is local, a dashboard must not change a run.
        if not season.is_local(network):
            ControlTopics(match, network, robot=number)
        self._driver_station = DriverStationLink(match, number, placed=self.auto_start.keep_place)
        self._power = RoboRioPower(self.robot_sim.battery)
        self._panels = PowerDistributionView(self.robot_sim)
        self._last_wall = 0.0
        self._work = 0.0
        self._work_ms: deque[float] = deque(maxlen=_HISTORY)
        self._ticks = self._late_parts = self._late_loops = 0
        self._skipped = 0.0
        atexit.register(match.close)
        global _latest
        _latest = weakref.ref(self)
        if not self._follow_loops() and self._has_periodic:
            season.add_between_loops(robot, self.do_due, self._h)

    @property
    def control(self) -> FieldControl:
        """Field control, which resets the field, adds pieces and places robots at the next tick."""
        return self.match.control

    @property
    def part(self) -> float:
        """Length of one part of a tick [s]."""
        return self._h

    def after_tick(self) -> None:
        """Do nothing after each 20 ms tick. A subclass may override this method, for example to log data."""

    def update_sim(self, now: float, tm_diff: float) -> None:
        """Count late loops, and run all due parts if the robot does not use WPILib's loop.

        Call this method once per robot loop.

        Args:
            now: FPGA time [s].
            tm_diff: Time since the last call [s].

        Raises:
            ConfigError: A subclass has not called `__init__` of this class.
        """
        if not hasattr(self, "_has_periodic"):
            raise ConfigError(
                f"{type(self).__name__}.__init__ does not call super().__init__(physics_controller, robot, match=...)"
            )
        if tm_diff > 1.5 * max(self._period, 0.010) + 0.010 * (self._period < 0.020):
            self._late_loops += 1
        if not self._has_periodic:
            self.do_due()

    def add_motor(self, motor: MotorDevices) -> None:
        """Connect the devices of an additional mechanism from the next part on."""
        self._devices.add(motor)

    def remove_motor(self, motor: MotorDevices) -> None:
        """Disconnect the devices of a mechanism. The devices keep the last values."""
        self._devices.remove(motor)

    @property
    def times(self) -> PhysicsTimes:
        """Timing statistics: computing times of the last two minutes, and counts and skipped time since the start."""
        work = np.array(self._work_ms) if self._work_ms else np.zeros(1)
        return PhysicsTimes(
            ticks=self._ticks,
            median_ms=float(np.median(work)),
            p99_ms=float(np.percentile(work, 99)),
            max_ms=float(work.max()),
            late_parts=self._late_parts,
            skipped=self._skipped,
            late_loops=self._late_loops,
            lateness_ms=1e3 * float(np.percentile(self._late, 99)) if self._late else 0.0,
        )

    def do_due(self) -> None:
        """Run all parts that are due, and skip the simulated time by which the parts are more than 0.1 s late."""
        now = Timer.get_monotonic_timestamp()
        if self._start is None:
            self._start = now - self._h
            gc.collect()
            gc.freeze()  # exclude the long-lived field, pieces and robot from garbage collection (5 % of a tick)
            if self._phoenix is not None:
                # A tick creates thousands of small objects, and nearly all are deleted by the end of the tick. A search
                # for cycles after every 700 objects took 5 to 8 % of a test's time. On the wall clock, short pauses
                # matter more.
                gc.set_threshold(20_000, *gc.get_threshold()[1:])
                self._phoenix.catch_up(self._start)
        owed = int((now - self._start) / self._h + 0.5) - self._done
        if owed > self._most_owed:
            given_up = owed - self._most_owed
            self._skipped += given_up * self._h
            self._done += given_up
            owed = self._most_owed
            if not is_timing_paused():
                self._lateness.note(given_up * self._h, tick_ms=self.times.median_ms)
        self._late_parts += max(0, owed - 1)
        for k in range(owed):
            if self._pace_tests and is_timing_paused():
                self._keep_to_the_wall_clock()
            elif k and self._has_real_devices:
                time.sleep(_ANSWER)
            begin = time.perf_counter()
            self._do_part()
            self._work += time.perf_counter() - begin
            self._done += 1
            if self._part == self._parts:
                self._end_tick()

    def _set_parts(self, parts: int) -> None:
        """Set the number of parts per tick. Call this method only between ticks."""
        if self._start is not None:
            self._start += self._done * self._h
        self._done = 0
        self._parts, self._h = parts, TICK / parts
        self._most_owed = round(_MOST_OWED / self._h)

    def _follow_loops(self) -> bool:
        """Shorten the parts to the period of the program's fastest loop, and return whether the length has changed."""
        fastest = min(fastest_period(), self._period) if self._may_follow else math.inf
        if fastest > self._h - 1e-6 or self._parts == _FINEST[-1]:
            return False
        self._set_parts(next((n for n in _FINEST if TICK / n < fastest + 1e-6), _FINEST[-1]))
        season.add_between_loops(self.robot, self.do_due, self._h)
        return True

    def _has_cameras(self) -> bool:
        cameras = self.match.cameras
        return bool(cameras.headsets) or any(c.robot == self.robot_sim.number for c in cameras.cameras.values())

    def _see_reset(self, position: tuple[float, float] | None, heading: float | None) -> None:
        self.belief.note_reset()
        self.auto_start.see_reset(position, heading)

    def _note_place(self, robot: int, pose: tuple[float, float, float] | None) -> None:
        if robot == self.robot_sim.number:
            self.auto_start.note_place(pose)

    def _do_part(self) -> None:
        if self._part == 0:
            self.auto_start.before_tick()
            self._power.show_voltage()
            self.match.begin_tick()
        self._part += 1
        self.match.run_part(self._h)
        self._power.show_rails()

    def _end_tick(self) -> None:
        begin = time.perf_counter()
        self._part = 0
        assert self._start is not None
        # time at which the tick was due, not the time at which the thread ran
        self._clock.offset = self._start + self._done * self._h - (self.match.ticks + 1) * TICK
        self.robot_sim.estimated_pose = self._estimated_pose()
        self.robot_sim.setpoints = self._devices.setpoints()
        self.robot_sim.module_setpoints = self._devices.module_setpoints()
        self.belief.after_tick(is_driving=self.robot_sim.drive.enabled)
        self.match.end_tick()
        self._driver_station.update()
        self._panels.update()
        self._view.update(self.robot_sim.chassis.pose, self.match.piece_positions())
        self.after_tick()
        self._follow_loops()
        self._ticks += 1
        self._work_ms.append(1e3 * (self._work + time.perf_counter() - begin))
        self.match.last_tick_ms = self._work_ms[-1]
        self._work = 0.0

    def _keep_to_the_wall_clock(self) -> None:
        rest = self._last_wall + self._h - time.perf_counter()
        if rest > 0.0:
            time.sleep(rest)
        if self._last_wall:
            self._late.append(max(0.0, time.perf_counter() - self._last_wall - self._h))
        self._last_wall = max(self._last_wall + self._h, time.perf_counter() - self._h)


class LatenessReport:
    """Log of skipped simulated time, by default with at most one warning in ten seconds of wall time.

    Args:
        every: Wall time between two reports [s].
        start: Wall time before the first report [s].
    """

    def __init__(self, *, every: float = _LATE_EVERY, start: float = _AT_START) -> None:
        self._every = every
        self._start = start
        self.given_up = 0.0
        """Skipped time since the last report [s]."""
        self._since = time.monotonic()
        self._is_first = True

    def note(self, seconds: float, *, tick_ms: float) -> None:
        """Add skipped time, and log a warning if enough time has passed since the last warning.

        The method ignores time skipped at program start.

        Args:
            seconds: Skipped time [s].
            tick_ms: Wall time that physics takes to compute a 20 ms tick [ms].
        """
        now = time.monotonic()
        if self._is_first and now - self._since < self._start:
            return
        self.given_up += seconds
        if not self._is_first and now - self._since < self._every:
            return
        why = "the computer is busy with other programs or robot code blocks"
        if tick_ms > _MOST_MS:
            why = f"the computer is too slow: physics alone takes {tick_ms:.0f} ms for a tick of 20 ms"
        _log.warning(
            "this run is late: %.2f s of the last %.0f s are missing from the physics, because %s; do not trust its "
            "timing (robot tests are not affected)",
            *(self.given_up, max(1.0, now - self._since), why),
        )
        self._is_first = False
        self.given_up = 0.0
        self._since = now


_latest: weakref.ref[RobotPhysics] | None = None


def latest_physics() -> RobotPhysics | None:
    """Return the physics built last in this process; None before the first physics or after its deletion."""
    return None if _latest is None else _latest()


def field_control() -> FieldControl | None:
    """Return the field control of the running simulation; None before simcore has built the physics.

    Robot code can use the field control after `robotInit`.
    """
    physics = latest_physics()
    return None if physics is None else physics.control


def _period_of(robot: Any) -> float:
    """Return the period of the robot's loop [s]; 5 ms for a custom loop with an unknown period."""
    if isinstance(robot, IterativeRobotBase):
        return float(robot.get_period())
    if isinstance(robot, season.loop_classes()):
        return float(type(robot).DEFAULT_PERIOD)  # an OpModeRobot keeps its period private
    return float(getattr(robot, "control_loop_wait_time", _ANY_LOOP))  # of a MagicRobot


def _has_wpilib_loop(robot_class: type) -> bool:
    """Return whether a robot class inherits WPILib's loop and therefore has `addPeriodic`."""
    start = season.own_name(season.wpilib.RobotBase, "start_competition")
    loop = next((cls for cls in robot_class.__mro__ if start in vars(cls)), object)
    return issubclass(robot_class, season.loop_classes()) and loop.__module__.split(".")[0] == "wpilib"


def _phoenix_time() -> PhoenixTime | None:
    """Return the clock of emulated Phoenix 6 devices, without importing phoenix6; None without emulated devices."""
    module = sys.modules.get("simcore.robotcode.sim.simulated_phoenix")
    return None if module is None else module.phoenix_time()  # type: ignore[no-any-return]
