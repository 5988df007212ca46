"""Robot programs whose loop is not wpilib's: where their waits are replaced, and their physics built."""

from __future__ import annotations

import functools
import sys
import threading
import time
import types
from collections.abc import Callable, Sequence
from typing import Any

from simcore import season
from simcore.robotpy.loop_waits import LoopWaits, TimedParts

TimedRobot = season.wpilib.TimedRobot
hal = season.hal
wpilib = season.wpilib

__all__ = ["attach_to_loop", "loop_waits", "with_own_loop"]

_active: LoopWaits | None = None


def loop_waits() -> LoopWaits | None:
    """The waits of the robot program that runs in this process; None: its loop is wpilib's."""
    return _active


def attach_to_loop(robot: Any, parts: TimedParts) -> LoopWaits | None:
    """Do parts in the waits of a robot's own loop from now on; called on the robot's thread.

    Returns:
        None where the loop is wpilib's, which has `addPeriodic`.
    """
    waits = _active
    if waits is None or waits.robot is not robot:
        if has_wpilib_loop(type(robot)):
            return None
        waits = _begin(LoopWaits(robot))
    waits.run(parts)
    return waits


def has_wpilib_loop(robot_class: type) -> bool:
    """Whether a robot class leaves its loop to wpilib's TimedRobot."""
    if not issubclass(robot_class, season.loop_classes()):
        return False
    start = season.own_name(wpilib.RobotBase, "start_competition")
    return next(c for c in robot_class.__mro__ if start in vars(c)).__module__.split(".")[0] == "wpilib"


def with_own_loop(robot_class: Any, interface: Any) -> Any:
    """The robot class, with physics in its loop if that is its own.

    Args:
        robot_class: Of the program.
        interface: pyfrc's, of its physics; its engine is built at the program's start if no hook has done so.
    """
    if has_wpilib_loop(robot_class):
        return robot_class
    start = season.own_name(wpilib.RobotBase, "start_competition")

    def start_competition(self: Any) -> None:
        def build() -> bool:
            if interface.engine is None:
                interface._simulationInit(self)
                return True
            return False

        def every_loop() -> None:
            hal.sim_periodic_before()
            interface._simulationPeriodic()
            hal.sim_periodic_after()

        waits = _begin(LoopWaits(self, build=build, every_loop=every_loop, holds=not isinstance(self, TimedRobot)))
        try:
            getattr(super(own_loop_robot, self), start)()
        finally:
            _end(waits)

    start_competition.__code__ = start_competition.__code__.replace(co_name=start)  # see `with_physics`
    names = {name: getattr(robot_class, name) for name in ("__module__", "__qualname__")}
    own_loop_robot = type(robot_class.__name__, (robot_class,), {start: start_competition, **names})
    return own_loop_robot


# --- where the waits are ------------------------------------------------------------------------------------------


def _here() -> LoopWaits | None:
    """The waits, if this is the robot's thread."""
    waits = _active
    return waits if waits is not None and waits.thread == threading.get_ident() else None


def _replacing(original: Callable[..., Any], name: str, *, before: bool = False) -> Any:
    """A function that on the robot's thread asks a method of its waits instead, or before the original."""

    @functools.wraps(original)
    def replaced(*args: Any, **kwargs: Any) -> Any:
        waits = _here()
        if waits is not None:
            answer = getattr(waits, name)(*args, **kwargs)
            if not before:
                return answer
        return original(*args, **kwargs)

    return replaced


def _wait(original: Callable[..., Any]) -> Any:
    @functools.wraps(original)
    def wait(handle: int, *timeout: float) -> Any:
        waits = _here()
        if waits is None or timeout:
            return original(handle, *timeout)
        goes_on = waits.alarm(handle)
        if season.time_waits_for_answers():
            return goes_on
        return (wpilib.RobotController.get_monotonic_time(), 0) if goes_on else (0, 0)

    return wait


def _event(original: Callable[..., bool]) -> Any:
    @functools.wraps(original)
    def wait(self: threading.Event, timeout: float | None = None) -> bool:
        waits = _here()
        return original(self, timeout) if waits is None else waits.event(self, timeout)

    return wait


_METHODS = {"set": "set_alarm", "forget": "forget"}
_PLACES: tuple[tuple[Any, str, Callable[[Any], Any]], ...] = (
    *(
        (module, name, _wait if kind == "wait" else lambda f, kind=kind: _replacing(f, _METHODS[kind], before=True))
        for module, name, kind in season.robots_notifier_calls()
    ),
    (hal, season.own_name(hal, "observe_user_program_starting"), lambda f: _replacing(f, "start", before=True)),
    (time, "sleep", lambda f: _replacing(f, "sleep")),
    (wpilib, "wait", lambda f: _replacing(f, "sleep")),
    (threading.Event, "wait", _event),
)
_originals: list[Any] = []


def _begin(waits: LoopWaits) -> LoopWaits:
    global _active
    if not _originals:
        _originals.extend(getattr(owner, name) for owner, name, _ in _PLACES)
        replace = [replacement for _, _, replacement in _PLACES]
        _rebind(_originals, [r(original) for r, original in zip(replace, _originals, strict=True)])
    _active = waits
    return waits


def _end(waits: LoopWaits) -> None:
    global _active
    waits.end()
    _active = None
    _rebind([getattr(owner, name) for owner, name, _ in _PLACES], _originals)
    _originals.clear()


def _rebind(old: Sequence[Any], new: Sequence[Any]) -> None:
    """Replace functions where they live, and where programs have taken them by `from ... import`."""
    for (owner, name, _), function in zip(_PLACES, new, strict=True):
        setattr(owner, name, function)
    by_id = {id(before): after for before, after in zip(old, new, strict=True)}
    ours = (LoopWaits.__module__, __name__)
    for module in list(sys.modules.values()):
        if not isinstance(module, types.ModuleType) or module.__name__ in ours:
            continue
        for key, value in list(vars(module).items()):
            after = by_id.get(id(value))
            if after is not None:
                setattr(module, key, after)
