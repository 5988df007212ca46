"""Pose estimate of a robot program, and pose resets, from WPILib's odometry or a maker's drivetrain.

A vision measurement does not count as a reset.
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
"""Position [m, m] and heading [rad] set by a reset, field frame; None for an unchanged part."""
PoseReset: TypeAlias = Callable[[tuple[float, float] | None, float | None], object]
"""Callback that takes the position and heading of a `Reset`."""

_EARLY = 10  # maximum number of resets kept before a listener is registered


class PoseResets:
    """Pose resets by robot code, kept for each odometry object until a listener is registered."""

    def __init__(self) -> None:
        self._listeners: WeakKeyDictionary[Any, PoseReset] = WeakKeyDictionary()
        self._early: WeakKeyDictionary[Any, deque[Reset]] = WeakKeyDictionary()

    def listen(self, made: Any, tell: PoseReset) -> None:
        """Call `tell` for the latest resets of an object at once, and for each later reset on robot code's thread."""
        self._listeners[made] = tell
        for reset in self._early.pop(made, ()):
            tell(*reset)

    def note(self, made: Any, reset: Reset) -> None:
        """Pass a pose reset by robot code to the object's listener, or keep the reset without a listener."""
        tell = self._listeners.get(made)
        if tell is None:
            self._early.setdefault(made, deque(maxlen=_EARLY)).append(reset)
        else:
            tell(*reset)


# --- WPILib's odometry ------------------------------------------------------------------------------------------------


class _Program:
    """Key of the resets of the odometry in use, for `PoseResets`."""


_resets = PoseResets()
_built: list[Any] = []  # odometry objects; the object that was set last is at the end


def on_pose_reset(tell: PoseReset) -> None:
    """Call `tell` with position and heading for the program's latest pose resets, and for each later reset."""
    _resets.listen(_Program, tell)


def estimated_pose() -> tuple[float, float, float] | None:
    """Return the program's estimated pose in the field frame [m, m, rad], or None without WPILib odometry."""
    main = _main()
    return None if main is None else _pose(main)


def _main() -> Any:
    """Return the pose estimator that was built or set last, else the last odometry object; None without odometry."""
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
        _note(made)  # the initial pose
    else:
        _built.append(made)


_distances: list[Callable[[list[float]], object]] = []
_WHEELS = ("front_left", "front_right", "rear_left", "rear_right")
_updates: WeakKeyDictionary[Any, float] = WeakKeyDictionary()
"""Time of the last `update` call of each odometry [s]."""


def on_wheel_distances(tell: Callable[[list[float]], object]) -> None:
    """Call `tell` with the wheel or side distances [m], left first, after each update of the program's odometry.

    The function replaces an earlier callback. Swerve odometry is not reported.
    """
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
    """Return whether an odometry was updated in the last 90 ms; True for a maker's drivetrain, which updates itself."""
    now = float(season.wpilib.Timer.get_monotonic_timestamp())
    return made not in _built or now - _updates.get(made, -math.inf) < 2.0 * _NEXT_LOOP


def why_still() -> str:
    """Return the reason why no update reaches the program's odometry; empty if the odometry is updated or missing."""
    main, asked = _main(), place_of_question()
    if main is None or _is_updated(main):
        return ""
    if not asked:
        return "Nothing updates it: the program never calls update of its odometry"
    return (
        f"Nothing updates it in simulation: the program asks isReal or isSimulation ({asked}), and updates its "
        "odometry only on the real robot; real = true under [robot] in simcore.toml makes isReal true"
    )


class _EveryLoop:
    """Detector for a program that sets a pose or heading in every loop while enabled."""

    def __init__(self, what: str) -> None:
        self._what = what
        self._last = -math.inf
        self._in_a_row = 0
        self._is_logged = False

    def is_left_out(self, is_of_simulation: bool, is_seen: bool, place: str, *, is_updated: bool = True) -> bool:
        """Record a setter call, and return whether to drop the call.

        Args:
            is_of_simulation: Whether simulation-only code makes the call.
            is_seen: Whether the value is close to the robot's true position, as a camera measurement would be.
            place: File and line of the call.
            is_updated: Whether the odometry is also updated from sensors; if not, the call is kept.
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
                "%s: the program sets its %s in every loop while it drives%s; in simulation such calls are ignored "
                "from now on, because sensors say where the robot is",
                *(place, self._what, ", in code for simulation" if is_of_simulation else ""),
            )
        return True


_NEXT_LOOP = 0.045  # [s], longest time between calls in consecutive 20 ms loops, with one loop missed
_FEW, _MANY = 2, 10  # consecutive calls that pass: from simulation code, and from other code
_SEEN = 0.5  # [m], largest distance from the true position
_sets: WeakKeyDictionary[Any, _EveryLoop] = WeakKeyDictionary()
_truth: list[Callable[[], tuple[float, float, float]]] = []


def set_truth(pose: Callable[[], tuple[float, float, float]]) -> None:
    """Set the function that returns the robot's true pose in the field frame [m, m, rad]."""
    _truth[:] = [pose]


def _caller() -> tuple[bool, str]:
    """Return whether simulation code is in the call stack, and file and line of the program's innermost frame."""
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
    """Wrap a setter to drop calls that a program repeats in every loop while the robot is enabled; see `_EveryLoop`.

    Args:
        cls: Class that has the method.
        method: Name of the method that sets a pose or heading.
        what: Name of the value, for the warning.
        dropped: Return value of a dropped call.
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
    """Return x and y [m] of the pose or translation among the arguments of a reset, or None without a position."""
    for value in args:
        value = value.to_pose2d() if hasattr(value, "to_pose2d") else value
        if hasattr(value, "x") and hasattr(value, "y") and not callable(value.x):
            return float(value.x), float(value.y)
    return None


for _cls in odometry_classes():  # watch from the import of this module on, before the robot is built
    record_class(_cls, _note_built)
    for _name in ("update", season.own_name(_cls, "update_with_time")):
        if hasattr(_cls, _name):  # only pose estimators have update_with_time
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
