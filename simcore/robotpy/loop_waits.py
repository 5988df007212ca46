"""Physics between the loops of a robot whose loop is its own: its waits are cut, and each part of physics done in time.

Only a TimedRobot has `addPeriodic`. A MagicRobot waits in robotpy's `NotifierDelay`, a LoggedRobot in
`hal.waitForNotifierAlarm` (since 2027 `wpiutil.sync.wait_for_object`), a plain RobotBase wherever its author chose:
there, in `time.sleep`, `wpilib.wait` or `threading.Event.wait`. Volts that stand for a whole loop of 20 ms make a steer
motor overshoot by 18 % (5 ms: nothing), and a Notifier of our own would be another thread, whose turn against the
robot's loop is a matter of luck.
So the robot's own thread does the parts while it would sleep, and all its sleeping follows the FPGA's clock.

Whoever steps that clock waits until every notifier is waited for, since 2027 until every alarm is answered. So the
thread holds one from its start to its end, its own or ours (since 2027 ours, as `NotifierDelay` answers before the
robot computes): time stands still while the robot computes, also before its first loop and between two modes.
"""

from __future__ import annotations

import logging
import sys
import threading
import time
import types
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

from simcore import season
from simcore.errors import SimcoreError, leave
from simcore.robotpy.console_noise import restore_stderr

is_timing_paused = season.hal_simulation.is_timing_paused
RobotController = season.wpilib.RobotController

__all__ = ["LoopWaits", "TimedParts"]

_log = logging.getLogger(__name__)

_LOOP = 5  # sleeps on one line make it a loop, in a program that never says that it has started
_STARTS = ("startCompetition", "start_competition")
_BUILDING = (
    "__init__",
    "robotInit",
    "robot_init",
    "createObjects",
    "create_objects",
    "_simulationInit",
    "simulation_init",
)
_PATIENCE = 10.0  # wall time that a loop may compute in a test [s]
_INIT_PATIENCE = 60.0  # and the program before its first loop [s]
_LOOK = 5_000  # [us]
_UNCUT = 1.0  # [s]; so long after its time a part is done by a thread of our own, in real time, until the robot waits


class TimedParts(Protocol):
    """Work that is due at times of its own: `RobotPhysics`."""

    @property
    def next_due(self) -> float:
        """When the next part is due, FPGA time [s]."""
        ...

    def do_due(self) -> None:
        """Do all parts that are due by now."""
        ...


_create, _wait, _update, _free = season.notifier_calls()
_HOLDS_BY_ALARM = season.time_waits_for_answers()
_COUNTS = season.clock_rate() / 1e6  # of the robot's clock in a microsecond
_sleep, _event_wait = time.sleep, threading.Event.wait


class LoopWaits:
    """The waits of the thread that creates it, which is the robot's.

    Args:
        robot: The robot object.
        build: Builds its physics, if nothing has done so when the program has started; returns whether it was needed.
        every_loop: Called once a loop where the program has no simulation hooks.
        holds: Whether the thread holds a notifier of ours while it has none; False: its loop may be wpilib's.
    """

    def __init__(
        self,
        robot: Any,
        *,
        build: Callable[[], bool] | None = None,
        every_loop: Callable[[], None] | None = None,
        holds: bool = True,
    ) -> None:
        self.robot = robot
        self.thread = threading.get_ident()
        self.parts: TimedParts | None = None
        """What is done in the waits; None: not built yet."""
        self._lock = threading.Lock()  # held while parts are done
        self._has_warned = False
        self._build = build
        self._every_loop = every_loop
        self._has_hooks = True
        self._holds = holds
        self._held: int | None = None
        self._own: int | None = None
        self._alarms: dict[int, int] = {}
        self._lines: dict[tuple[str, int], int] = {}
        self._has_started = False
        self._computes_since = time.monotonic()
        self._is_waiting = False
        self._does_parts = False
        self._is_ending = False
        self._is_over = False
        self._hold()
        threading.Thread(target=self._watch, name="simcore-loop", daemon=True).start()

    def run(self, parts: TimedParts) -> None:
        """Do these parts, which are complete, from now on; the program's patience begins to count."""
        self._computes_since = time.monotonic()
        self.parts = parts

    def do_due(self) -> None:
        """Do the parts that are due, unless another thread does them; to be called on the robot's thread."""
        parts = self.parts
        if parts is not None and self._lock.acquire(blocking=False):
            self._does_parts = True
            try:
                if parts.next_due <= 1e-6 * _now():
                    parts.do_due()
            finally:
                self._does_parts = False
                self._lock.release()

    def stop(self) -> None:
        """Do no more parts: whoever steps time is about to end the program."""
        self._is_ending = True

    def end(self) -> None:
        """The program is over."""
        self._is_over = True
        self._let_go()

    def where(self) -> str:
        """Which line of the program its thread is at."""
        frame = sys._current_frames().get(self.thread)
        folder = str(self._folder())
        named = frame
        while frame is not None:
            if frame.f_code.co_filename.startswith(folder):
                named = frame
                break
            frame = frame.f_back
        if named is None:
            return "no line"
        return f"{Path(named.f_code.co_filename).name}:{named.f_lineno} in {named.f_code.co_name}"

    def require_waits(self, patience: float) -> None:
        """Make sure that the robot's thread waits, before time is stepped on another thread.

        Args:
            patience: Wall time that a loop may compute; until its physics is built a program may take longer [s].

        Raises:
            SimcoreError: It neither waits nor ends in that time; the text says where it is.
        """
        while not (self._is_waiting or self._is_over or not self._holds):
            if self._is_stuck(patience):
                raise SimcoreError(self._complaint(patience))
            _sleep(0.001)

    def _folder(self) -> Path:
        module = sys.modules.get(type(self.robot).__module__)
        return Path(getattr(module, "__file__", None) or "?").parent

    # --- waits of the robot's thread ------------------------------------------------------------------------------

    def alarm(self, handle: int) -> bool:
        """Wait for a notifier of the robot's; False: it was stopped."""
        self.start()
        expiry = self._alarms.pop(handle, None)
        if _HOLDS_BY_ALARM and expiry is not None:
            self._sleep_until(expiry)
            self._end_wait()
            return True
        if not _HOLDS_BY_ALARM:
            self._own = handle
            self._let_go()
        with _Waiting(self):
            if expiry is not None:
                if not self._run_until(handle, expiry):
                    return False
                _update(handle, expiry)
            goes_on = _wait(handle)
        self._end_wait()
        return bool(goes_on)

    def sleep(self, seconds: float) -> None:
        """As `time.sleep`; FPGA time."""
        if self._is_waiting or self._does_parts or (not self._has_started and not self._is_a_loop()):
            _sleep(seconds)  # in the middle of a part it is our own physics that waits for the devices
            return
        self.start()
        self._sleep_until(_now() + max(0, round(1e6 * seconds)))
        self._end_wait()

    def event(self, event: threading.Event, timeout: float | None) -> bool:
        """As `threading.Event.wait`; looks at the event every 5 ms."""
        if timeout is None or not self._has_started or self.parts is None:
            return _event_wait(event, timeout)
        end = _now() + max(0, round(1e6 * timeout))
        while not event.is_set() and _now() < end:
            self._sleep_until(min(_now() + _LOOK, end))
        self._end_wait()
        return event.is_set()

    def set_alarm(self, handle: int, when: int, interval: int = 0, absolute: bool = True, ack: bool = True) -> None:
        """The robot's thread has set an alarm, by the counts of its clock."""
        self._alarms[handle] = int(when / _COUNTS) + (0 if absolute else _now())

    def forget(self, handle: int, *_: Any) -> None:
        """The robot's thread is about to stop a notifier."""
        self._alarms.pop(handle, None)
        if handle == self._own:
            self._hold()  # before it goes, so that time stands still until the next one is there
            self._own = None

    def start(self) -> None:
        """The program has started, or waits for its first loop: build its physics."""
        if self._has_started:
            return
        self._has_started = True
        initialized = getattr(self.robot, "_TestRobot__robotInitialized", None)
        if initialized is not None:
            initialized()  # pyfrc waits for robotInit, which a program of its own may not have
        if self._build is not None:
            self._has_hooks = not self._build()

    # --- inside ---------------------------------------------------------------------------------------------------

    def _run_until(self, handle: int, end: int) -> bool:
        """Do the parts that are due before `end` [us]; returns whether the program goes on."""
        parts = self.parts
        if parts is None or self._is_ending:
            return True
        with self._lock:
            if parts.next_due <= 1e-6 * _now():
                parts.do_due()  # after a loop that took too long nothing is left to wait for
            while (due := int(1e6 * parts.next_due)) < end:
                _update(handle, due)
                if not _wait(handle):
                    return False
                parts.do_due()
        return True

    def _sleep_until(self, end: int) -> None:
        """On the notifier that the thread holds; FPGA time [us]."""
        handle = self._own if self._own is not None else self._hold()
        with _Waiting(self):
            # a notifier whose time has come already would wait for the next step of time
            if self._run_until(handle, end) and end > _now():
                _update(handle, end)
                _wait(handle)
            own = self._alarms.get(handle)
            if own is not None:
                _update(handle, own)

    def _end_wait(self) -> None:
        if not self._has_hooks and self._every_loop is not None:
            self._every_loop()

    def _is_a_loop(self) -> bool:
        """Whether a sleep is that of the program's loop, and does not wait for a device while the robot is built."""
        frame = sys._getframe(3)
        line = (frame.f_code.co_filename, frame.f_lineno)
        caller: types.FrameType | None = frame
        while caller is not None and caller.f_code.co_name not in _STARTS:
            if caller.f_code.co_name in _BUILDING:
                return False
            caller = caller.f_back
        self._lines[line] = self._lines.get(line, 0) + 1
        return self._lines[line] > _LOOP

    def _hold(self) -> int:
        if self._held is None and (self._holds or self._has_started):
            self._held = _create()
            if _HOLDS_BY_ALARM:
                _update(self._held, _now())  # so that the next step of time waits for an answer
        return self._held or 0

    def _let_go(self) -> None:
        held, self._held = self._held, None
        if held is not None:
            _free(held)

    def _watch(self) -> None:
        """Look whether the robot's thread comes by where it can be cut."""
        while not self._is_over:
            _sleep(0.1)
            if self._is_waiting:
                continue
            if is_timing_paused():
                if self._held is not None and self._is_stuck(_PATIENCE):
                    self._let_go()  # else whoever steps time would wait for ever
                    _log.error("%s", self._complaint(_PATIENCE))
            elif self._is_late():
                self._stand_in()

    def _is_late(self) -> bool:
        """Whether the program, which has started, has long not come by: by the FPGA's clock and by its own waits."""
        parts = self.parts
        patience = _UNCUT if self._has_started else _INIT_PATIENCE
        return (
            parts is not None
            and time.monotonic() - self._computes_since > patience
            and 1e-6 * _now() - parts.next_due > _UNCUT
        )

    def _stand_in(self) -> None:
        """Do the parts on this thread, in real time, until the robot's waits again."""
        parts = self.parts
        assert parts is not None
        if not self._has_warned:
            self._has_warned = True
            _log.warning(
                "%s has not waited for its next loop for %.1f s (it is at %s): until it does, physics runs beside it",
                *(type(self.robot).__name__, time.monotonic() - self._computes_since, self.where()),
            )
        handle = _create()
        try:
            while not (self._is_waiting or self._is_over):
                with self._lock:
                    parts.do_due()
                _update(handle, int(1e6 * parts.next_due))
                if not _wait(handle):
                    return
        except Exception as error:  # else the robot would go on without physics
            restore_stderr()
            leave(error, program="robotpy sim", folder=self._folder())
        finally:
            _free(handle)

    def _is_stuck(self, patience: float) -> bool:
        allowed = patience if self.parts is not None else _INIT_PATIENCE
        return time.monotonic() - self._computes_since > allowed

    def _complaint(self, patience: float) -> str:
        return (
            f"{type(self.robot).__name__} gets no physics: its loop is its own, and in {patience:g} s of wall time it "
            f"has not waited where simulated time can reach it; it is at {self.where()}. What can be reached: "
            "wpilib.TimedRobot, NotifierDelay, notifiers of hal, time.sleep, wpilib.wait, threading.Event.wait"
        )


def _now() -> int:
    """FPGA time [us]."""
    return int(RobotController.get_monotonic_time() / _COUNTS)


class _Waiting:
    """Notes that the robot's thread waits, so that time may be stepped."""

    def __init__(self, waits: LoopWaits) -> None:
        self._waits = waits

    def __enter__(self) -> None:
        self._waits._is_waiting = True

    def __exit__(self, *_: object) -> None:
        self._waits._is_waiting = False
        self._waits._computes_since = time.monotonic()
