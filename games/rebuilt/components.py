"""The sixteen moving parts of the robot, for AdvantageScope: poses in the robot frame, from live mechanisms."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from simcore.typing import FloatArray

if TYPE_CHECKING:
    from games.rebuilt.robot import RebuiltRobot

__all__ = ["COMPONENTS", "Component", "component_poses"]


class Component(NamedTuple):
    """One part: where its origin is, about which axis it turns, and which mechanism moves it."""

    name: str
    place: tuple[float, float, float]
    """Origin in the robot frame [m]."""
    axis: str
    """`x`, `y` or `z` for a turn about it, `slide` for a move with the intake's rack, `fixed`."""
    mechanism: str
    """Attribute of `RebuiltRobot`, empty for none."""
    ratio: float = 1.0
    """Turns of the part per turn of the mechanism."""


COMPONENTS: tuple[Component, ...] = (
    Component("intake", (-0.30, 0.0, 0.15), "slide", "deploy"),
    Component("hopper", (-0.05, 0.0, 0.20), "slide", "deploy", 0.5),
    Component("intake roller, lower", (-0.36, 0.0, 0.10), "y", "roller"),
    Component("intake roller, upper", (-0.36, 0.0, 0.20), "y", "roller", -1.0),
    Component("hopper roller", (-0.20, 0.0, 0.12), "y", "roller"),
    Component("spindexer plate", (-0.02, 0.0, 0.14), "z", "spindexer"),
    Component("spindexer cone", (-0.02, 0.0, 0.18), "z", "spindexer"),
    Component("spindexer kicker", (0.10, 0.0, 0.16), "z", "spindexer", -2.0),
    Component("feeder wheel, lower left", (0.14, 0.08, 0.25), "y", "feeder"),
    Component("feeder wheel, lower right", (0.14, -0.08, 0.25), "y", "feeder"),
    Component("feeder wheel, upper left", (0.14, 0.08, 0.35), "y", "feeder"),
    Component("feeder wheel, upper right", (0.14, -0.08, 0.35), "y", "feeder"),
    Component("hood", (0.10, 0.0, 0.46), "y", "hood"),
    Component("shooter wheel, left", (0.10, 0.08, 0.46), "y", "shooter_wheels"),
    Component("shooter wheel, right", (0.10, -0.08, 0.46), "y", "shooter_wheels"),
    Component("shooter backspin roller", (0.16, 0.0, 0.56), "y", "shooter_wheels", -1.0),
)
"""In the order of the model files."""


def component_poses(robot: RebuiltRobot) -> FloatArray:
    """Pose rows `x, y, z, qw, qx, qy, qz` of all parts in the robot frame, shape (16, 7)."""
    rows = np.zeros((len(COMPONENTS), 7))
    rows[:, 3] = 1.0
    slide = robot.deploy.extension
    for row, part in zip(rows, COMPONENTS, strict=True):
        row[:3] = part.place
        if part.axis == "slide":
            row[0] -= part.ratio * slide
            continue
        half = 0.5 * math.fmod(part.ratio * getattr(robot, part.mechanism).position, 4.0 * math.pi)
        row[3] = math.cos(half)
        row[4 + "xyz".index(part.axis)] = math.sin(half)
    rows.setflags(write=False)
    return rows
