"""Where a robot program believes to be, and when it sets that anew: of WPILib's odometry, and of a maker's drivetrain.

A vision measurement is no reset.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any, TypeAlias
from weakref import WeakKeyDictionary

from simcore import season
from simcore.devices.recorder import after_call, odometry_classes, record_class

__all__ = ["PoseReset", "PoseResets", "estimated_pose", "on_pose_reset"]

Reset: TypeAlias = tuple[tuple[float, float] | None, float | None]
"""Position [m, m] and heading [rad] that were set, field frame; None is what stays."""
PoseReset: TypeAlias = Callable[[tuple[float, float] | None, float | None], object]
"""Gets a reset."""

_EARLY = 10  # resets that are kept until somebody listens


class PoseResets:
    """Resets of objects of robot code; those before anybody listens are kept."""

    def __init__(self) -> None:
        self._listeners: WeakKeyDictionary[Any, PoseReset] = WeakKeyDictionary()
        self._early: WeakKeyDictionary[Any, deque[Reset]] = WeakKeyDictionary()

    def listen(self, made: Any, tell: PoseReset) -> None:
        """Call `tell` after each reset of an object, on the thread of robot code; at once of those until now."""
        self._listeners[made] = tell
        for reset in self._early.pop(made, ()):
            tell(*reset)

    def note(self, made: Any, reset: Reset) -> None:
        """Robot code has set the pose of an object anew."""
        tell = self._listeners.get(made)
        if tell is None:
            self._early.setdefault(made, deque(maxlen=_EARLY)).append(reset)
        else:
            tell(*reset)


# --- WPILib's odometry ------------------------------------------------------------------------------------------------


class _Program:
    """In place of an object: whichever odometry the program goes by."""


_resets = PoseResets()
_built: list[Any] = []  # the one that was set last at the end


def on_pose_reset(tell: PoseReset) -> None:
    """Call `tell` with position and heading whenever the program sets its pose anew; at once of those until now."""
    _resets.listen(_Program, tell)


def estimated_pose() -> tuple[float, float, float] | None:
    """Where the program believes to be, field frame [m, m, rad]; None: it keeps no odometry of WPILib's."""
    main = _main()
    return None if main is None else _pose(main)


def _main() -> Any:
    """What the program goes by: an estimator before mere odometry, and of several the one that was set last."""
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
        _note(made)  # it begins somewhere
    else:
        _built.append(made)


for _cls in odometry_classes():  # from the import of this module on, before the robot is built
    record_class(_cls, _note_built)
    for _method, _moved in (
        ("reset_position", {}),
        ("reset_pose", {}),
        ("reset_translation", {"turns": False}),
        ("reset_rotation", {"moves": False}),
    ):
        after_call(_cls, season.own_name(_cls, _method), lambda made, *_, moved=_moved: _note(made, **moved))
