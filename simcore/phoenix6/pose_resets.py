"""Notes when robot code sets the pose of a `SwerveDrivetrain` anew."""

from __future__ import annotations

from typing import Any

from phoenix6.swerve import SwerveDrivetrain

from simcore.devices.program_odometry import PoseResets
from simcore.devices.recorder import after_call

__all__ = ["RESETS"]

RESETS = PoseResets()
"""Of every drivetrain that is built from now on."""


def _heading(drivetrain: Any, rotation: Any = None) -> float:
    """That `seed_field_centric` sets [rad]."""
    turn = 0.0 if rotation is None else float(rotation.radians())
    return turn + float(drivetrain.get_operator_forward_direction().radians())


_MEANINGS: dict[str, Any] = {
    "reset_pose": lambda drivetrain, pose: ((float(pose.x), float(pose.y)), float(pose.rotation().radians())),
    "reset_translation": lambda drivetrain, place: ((float(place.x), float(place.y)), None),
    "reset_rotation": lambda drivetrain, rotation: (None, float(rotation.radians())),
    "seed_field_centric": lambda drivetrain, rotation=None: (None, _heading(drivetrain, rotation)),
}
"""What each method sets: position [m, m] and heading [rad]."""


def _noting(meaning: Any) -> Any:
    def note(drivetrain: Any, _: Any, args: tuple[Any, ...], settings: dict[str, Any]) -> None:
        RESETS.note(drivetrain, meaning(drivetrain, *args, **settings))

    return note


for _method, _meaning in _MEANINGS.items():
    after_call(SwerveDrivetrain, _method, _noting(_meaning))
