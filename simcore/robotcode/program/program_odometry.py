"""Estimated pose of a robot program and its resets, from WPILib's odometry or a maker's drivetrain.

A vision measurement is no reset.
"""

from __future__ import annotations

import functools
import logging
import math
import sys
import types
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias
from weakref import WeakKeyDictionary

from simcore import season
from simcore.robotcode.program.recorder import after_call, odometry_classes, record_class
from simcore.robotcode.program.simulation_questions import is_of_program, place_of_question, simulation_code

__all__ = [
    "PoseReset", "PoseResets", "estimated_pose", "on_pose_reset", "on_wheel_distances", "set_truth", "watch_sets",
    "why_still",
]  # fmt: skip

_log = logging.getLogger(__name__)

Reset: TypeAlias = tuple[tuple[float, float] | None, float | None]
"""Position [m, m] and heading [rad] that were set, field frame; None is a part left unchanged."""
PoseReset: TypeAlias = Callable[[tuple[float, float] | None, float | None], object]
"""Callback for a reset."""

_EARLY = 10  # resets kept until a listener comes


class PoseResets:
    """Resets of objects of robot code, kept until a listener comes."""

    def __init__(self) -> None:
        self._listeners: WeakKeyDictionary[Any, PoseReset] = WeakKeyDictionary()
        self._early: WeakKeyDictionary[Any, deque[Reset]] = WeakKeyDictionary()

    def listen(self, made: Any, tell: PoseReset) -> None:
        """Call `tell` after each reset of an object, on the thread of robot code, and at once for resets so far."""
        self._listeners[made] = tell
        for reset in self._early.pop(made, ()):
            tell(*reset)

    def note(self, made: Any, reset: Reset) -> None:
        """Record that robot code has set the pose of an object."""
        tell = self._listeners.get(made)
        if tell is None:
            self._early.setdefault(made, deque(maxlen=_EARLY)).append(reset)
        else:
            tell(*reset)


# --- WPILib's odometry ------------------------------------------------------------------------------------------------


class _Program:
    """Key for whichever odometry the program uses."""


_resets = PoseResets()
_built: list[Any] = []  # the one set last at the end


def on_pose_reset(tell: PoseReset) -> None:
    """Call `tell` with position and heading after each pose reset of the program, and at once for resets so far."""
    _resets.listen(_Program, tell)


def estimated_pose() -> tuple[float, float, float] | None:
    """Return the program's estimated pose, field frame [m, m, rad]; None: it keeps no odometry of WPILib's."""
    main = _main()
    return None if main is None else _pose(main)


def _main() -> Any:
    """Return the odometry that the program uses: an estimator before plain odometry, of several the last one set."""
    estimators = [made for made in _built if hasattr(made, "get_estimated_position")]
    return (estimators or _built or [None])[-1]


def _pose(made: Any) -> tuple[float, float, float]:
    pose = made.get_estimated_position() if hasattr(made, "get_estimated_position") else made.get_pose()
    pose = pose.to_pose2d() if hasattr(pose, "to_pose2d") else pose
    return pose.x, pose.y, pose.rotation().radians()


def _note(made: Any, *, turns: bool = True, moves: bool = True) -> None:
    _built[:] = [*(other for other in _built if other is not made), made]
    x, y, heading = _pose(made)
    if made is _main():
        _resets.note(_Program, ((x, y) if moves else None, heading if turns else None))


def _note_built(made: Any, args: tuple[Any, ...], settings: dict[str, Any]) -> None:
    if any(_pose(made)):
        _note(made)  # its initial pose
    else:
        _built.append(made)


_distances: list[Callable[[list[float]], object]] = []
_WHEELS = ("front_left", "front_right", "rear_left", "rear_right")
_updates: WeakKeyDictionary[Any, float] = WeakKeyDictionary()
"""Time of the last update of each odometry [s]."""


def on_wheel_distances(tell: Callable[[list[float]], object]) -> None:
    """Call `tell` with distances of sides or wheels, left first, on each update of the program's odometry [m]."""
    _distances[:] = [tell]


def _note_distances(made: Any, args: tuple[Any, ...]) -> None:
    if made is not _main():
        return
    wheels = [getattr(value, season.own_name(type(value), name), None) for value in args for name in _WHEELS]
    distances = [float(value) for value in (*args, *wheels) if isinstance(value, (int, float))]
    for tell in _distances if distances else ():
        tell(distances)


def _note_update(made: Any, *_: object) -> None:
    _updates[made] = float(season.wpilib.Timer.get_monotonic_timestamp())


def _is_updated(made: Any) -> bool:
    """Return whether the program updates it loop by loop; a maker's drivetrain does so by itself."""
    now = float(season.wpilib.Timer.get_monotonic_timestamp())
    return made not in _built or now - _updates.get(made, -math.inf) < 2.0 * _NEXT_LOOP


def why_still() -> str:
    """Say why the program's pose does not follow its sensors if nothing updates it; else return nothing."""
    main, asked = _main(), place_of_question()
    if main is None or _is_updated(main):
        return ""
    if not asked:
        return "Nothing updates it: the program calls update of its odometry in no loop"
    return (
        f"Nothing updates it in simulation: the program asks isReal or isSimulation ({asked}), and updates its "
        "odometry on the robot alone; real = true under [robot] of simcore.toml answers that it is real"
    )


class _EveryLoop:
    """Sets of one value by a program, and whether it sets it in every loop while enabled."""

    def __init__(self, what: str) -> None:
        self._what = what
        self._last = -math.inf
        self._in_a_row = 0
        self._is_logged = False

    def is_left_out(self, is_of_simulation: bool, is_seen: bool, place: str, *, is_updated: bool = True) -> bool:
        """Record a set and return whether to drop it, as for writes to devices.

        Args:
            is_of_simulation: Whether simulation-only code sets it.
            is_seen: Whether the value is the robot's true position, as from a camera.
            place: File and line.
            is_updated: Whether sensors give the position, too; a set that nothing replaces stays.
        """
        now = float(season.wpilib.Timer.get_monotonic_timestamp())
        if not season.wpilib.RobotState.is_enabled():
            self._in_a_row = 0
            return False
        if now - self._last > _NEXT_LOOP:
            self._in_a_row = 0
        if now > self._last:
            self._in_a_row += 1
        self._last = now
        if self._in_a_row <= (_FEW if is_of_simulation else _MANY) or (is_seen and not is_of_simulation):
            return False
        is_logged, self._is_logged = self._is_logged, True
        if not is_updated:
            if not is_logged:
                _log.warning("%s: the program sets its %s itself while it drives. %s", place, self._what, why_still())
            return False
        if not is_logged:
            _log.warning(
                "%s: the program sets its %s in every loop while it drives%s; in simulation that is left out from here "
                "on, as sensors say where the robot is",
                *(place, self._what, ", in code for simulation" if is_of_simulation else ""),
            )
        return True


_NEXT_LOOP = 0.045  # [s] from one set to that of the next loop, of 20 ms, with one missed
_FEW, _MANY = 2, 10  # consecutive sets that pass: of simulation code, and of other code
_SEEN = 0.5  # [m]
_sets: WeakKeyDictionary[Any, _EveryLoop] = WeakKeyDictionary()
_truth: list[Callable[[], tuple[float, float, float]]] = []


def set_truth(pose: Callable[[], tuple[float, float, float]]) -> None:
    """Set the true pose of the program's robot, field frame [m, m, rad], until the next call."""
    _truth[:] = [pose]


def _caller() -> tuple[bool, str]:
    """Return whether simulation code is the caller, and the program's file and line."""
    frame: types.FrameType | None = sys._getframe(1)
    place, is_of_simulation = "", False
    while frame is not None:
        code = frame.f_code
        if is_of_program(code):
            place = place or f"{Path(code.co_filename).name}:{frame.f_lineno}"
            is_of_simulation |= simulation_code(code)
        frame = frame.f_back
    return is_of_simulation, place


def watch_sets(cls: Any, method: str, what: str, dropped: object = None) -> None:
    """Drop pose or heading sets that come in every loop while the robot is enabled; see `_EveryLoop`.

    Args:
        cls: Class that has the method.
        method: Its name.
        what: Value that is set, for the warning.
        dropped: Result of a dropped call.
    """
    call = getattr(cls, method)
    if hasattr(call, "_leaves_out"):
        return

    @functools.wraps(call)
    def set_anew(made: Any, *args: Any, **settings: Any) -> Any:
        position = _position(*args, *settings.values())
        is_seen = bool(_truth) and position is not None and math.dist(position, _truth[0]()[:2]) < _SEEN
        is_of_simulation, place = _caller()
        sets = _sets.setdefault(made, _EveryLoop(what))
        if sets.is_left_out(is_of_simulation, is_seen, place, is_updated=_is_updated(made)):
            return dropped
        return call(made, *args, **settings)

    set_anew._leaves_out = True  # type: ignore[attr-defined]
    setattr(cls, method, set_anew)


def _position(*args: Any) -> tuple[float, float] | None:
    """Return the position of the pose among the arguments of a reset."""
    for value in args:
        value = value.to_pose2d() if hasattr(value, "to_pose2d") else value
        if hasattr(value, "x") and hasattr(value, "y") and not callable(value.x):
            return float(value.x), float(value.y)
    return None


for _cls in odometry_classes():  # watched from the import of this module on, before the robot is built
    record_class(_cls, _note_built)
    for _name in ("update", season.own_name(_cls, "update_with_time")):
        if hasattr(_cls, _name):  # an estimator's method
            after_call(_cls, _name, _note_update)
    if "Swerve" not in _cls.__name__:
        after_call(_cls, "update", lambda made, _, args, settings: _note_distances(made, (*args, *settings.values())))
    for _method, _moved in (
        ("reset_position", {}),
        ("reset_pose", {}),
        ("reset_translation", {"turns": False}),
        ("reset_rotation", {"moves": False}),
    ):
        _name = season.own_name(_cls, _method)
        after_call(_cls, _name, lambda made, *_, moved=_moved: _note(made, **moved))
        watch_sets(_cls, _name, "pose")
