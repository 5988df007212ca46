"""Tells who wants to know when robot code sets the pose of a `SwerveDrivetrain` anew.

A vision measurement is no reset. Drivetrains are watched from their class on, because libraries keep a bound
`reset_pose` from the time when the drivetrain is built.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any
from weakref import WeakKeyDictionary

from phoenix6.swerve import SwerveDrivetrain

__all__ = ["PoseReset", "on_pose_reset"]

PoseReset = Callable[[tuple[float, float] | None, float | None], None]
"""Gets the position [m, m] and the heading [rad], field frame; None is what stays."""

_listeners: WeakKeyDictionary[Any, PoseReset] = WeakKeyDictionary()


def on_pose_reset(drivetrain: Any, tell: PoseReset) -> None:
    """Call `tell` after each reset of a drivetrain's pose, on the thread of robot code."""
    _listeners[drivetrain] = tell


def _pose(drivetrain: Any, pose: Any) -> tuple[tuple[float, float] | None, float | None]:
    return (float(pose.x), float(pose.y)), float(pose.rotation().radians())


def _translation(drivetrain: Any, translation: Any) -> tuple[tuple[float, float] | None, float | None]:
    return (float(translation.x), float(translation.y)), None


def _rotation(drivetrain: Any, rotation: Any) -> tuple[tuple[float, float] | None, float | None]:
    return None, float(rotation.radians())


def _field_centric(drivetrain: Any, rotation: Any = None) -> tuple[tuple[float, float] | None, float | None]:
    turn = 0.0 if rotation is None else float(rotation.radians())
    return None, turn + float(drivetrain.get_operator_forward_direction().radians())


def _watched(reset: Any, meaning: Callable[..., tuple[tuple[float, float] | None, float | None]]) -> Any:
    @functools.wraps(reset)
    def watched(self: Any, *args: Any, **kwargs: Any) -> Any:
        answer = reset(self, *args, **kwargs)
        tell = _listeners.get(self)
        if tell is not None:
            tell(*meaning(self, *args, **kwargs))
        return answer

    watched._tells = True  # type: ignore[attr-defined]
    return watched


def _watch() -> None:
    """Runs once when this module is imported, before the robot is built."""
    for name, meaning in (
        ("reset_pose", _pose),
        ("reset_translation", _translation),
        ("reset_rotation", _rotation),
        ("seed_field_centric", _field_centric),
    ):
        reset = getattr(SwerveDrivetrain, name)
        if not getattr(reset, "_tells", False):
            setattr(SwerveDrivetrain, name, _watched(reset, meaning))


_watch()
