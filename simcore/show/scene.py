"""What a picture of a run shows beside its telemetry: the field, the shots, the robots' sizes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from simcore.errors import ConfigError, require_positive
from simcore.typing import FloatArray

__all__ = ["RobotLook", "Scene", "ShotTrace", "ShowsScene"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotTrace:
    """The flight of one piece."""

    points: FloatArray
    """Centers from the muzzle to where it scored or first touched, field frame [m], shape (m, 3)."""
    scored: bool
    time: float = 0.0
    """When it left the muzzle, simulated [s]."""
    robot: int = 0
    """Number of the robot that shot it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotLook:
    """How one robot is drawn, and which telemetry is its own."""

    alliance: str = "blue"
    bumpers: tuple[float, float] = (0.8, 0.8)
    """Length and width over the bumpers [m]."""
    prefix: str = "Sim"
    """Its keys begin so: `<prefix>/Robot/Pose3d`, `<prefix>/Debug/BatteryVoltage`."""

    def __post_init__(self) -> None:
        require_positive("RobotLook", "bumpers[0]", self.bumpers[0], "m")
        require_positive("RobotLook", "bumpers[1]", self.bumpers[1], "m")

    @property
    def pose_key(self) -> str:
        """Of its true pose."""
        return f"{self.prefix}/Robot/Pose3d"


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """Everything that is drawn and is in no telemetry key."""

    field_size: tuple[float, float]
    """Length and width of the field [m]."""
    field_outlines: Sequence[tuple[str, FloatArray]] = ()
    """Name and corners of each element from above [m], shape (n, 2); `blue...` and `red...` are tinted so."""
    robots: Sequence[RobotLook] = (RobotLook(),)
    shots: Sequence[ShotTrace] = ()
    """In the order in which they were shot."""
    intakes: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    """Where pieces were taken in, field frame [m], shape (n, 3)."""
    piece_radius: float = 0.075
    """As drawn [m]."""
    piece_name: str = "fuel"
    """What people call a piece."""

    def __post_init__(self) -> None:
        require_positive("Scene", "field_size[0]", self.field_size[0], "m")
        require_positive("Scene", "field_size[1]", self.field_size[1], "m")
        require_positive("Scene", "piece_radius", self.piece_radius, "m")
        if self.intakes.ndim != 2 or self.intakes.shape[1] != 3:
            raise ConfigError(f"Scene: intakes need shape (n, 3), got {self.intakes.shape}")

    @property
    def hits(self) -> int:
        """Shots that scored."""
        return sum(shot.scored for shot in self.shots)


class ShowsScene(Protocol):
    """A game that can be drawn, also after it was closed: `RebuiltSim`."""

    def scene(self) -> Scene:
        """As it is now."""
        ...
