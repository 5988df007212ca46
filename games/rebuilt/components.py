"""The sixteen moving parts of the robot, for AdvantageScope: poses in the robot frame, from live mechanisms."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from simcore.typing import FloatArray

if TYPE_CHECKING:
    from games.rebuilt.robot import RebuiltRobot

__all__ = ["COMPONENTS", "RAILS", "Component", "component_poses"]


class Component(NamedTuple):
    """One part: where its origin is, about which axis it turns, and which mechanism moves it."""

    name: str
    place: tuple[float, float, float]
    """Origin in the robot frame, with the intake in [m]."""
    axis: str = ""
    """`x`, `y` or `z`: what it turns about; empty for a part that does not turn."""
    mechanism: str = ""
    """Attribute of `RebuiltRobot` that turns it."""
    ratio: float = 1.0
    """Turns of the part per turn of the mechanism."""
    slides: float = 0.0
    """Share of the intake's travel that the part goes with it [-]."""


RAILS = (-1.0, 0.0, -0.5)
"""Where the intake goes per meter of its rack [m]: out at the back, and down over the bumper."""

COMPONENTS: tuple[Component, ...] = (
    Component("intake", (-0.30, 0.0, 0.35), slides=1.0),
    Component("hopper", (-0.05, 0.0, 0.30), slides=0.5),
    Component("intake roller, lower", (-0.37, 0.0, 0.31), "y", "roller", slides=1.0),
    Component("intake roller, upper", (-0.33, 0.0, 0.45), "y", "roller", -1.0, slides=1.0),
    Component("hopper roller", (-0.24, 0.0, 0.22), "y", "roller"),
    Component("spindexer plate", (-0.03, 0.0, 0.14), "z", "spindexer"),
    Component("spindexer cone", (-0.03, 0.0, 0.155), "z", "spindexer"),
    Component("spindexer kicker", (0.19, 0.0, 0.19), "z", "spindexer", -2.0),
    Component("feeder wheel, lower left", (0.25, 0.08, 0.25), "y", "feeder"),
    Component("feeder wheel, lower right", (0.25, -0.08, 0.25), "y", "feeder"),
    Component("feeder wheel, upper left", (0.25, 0.08, 0.36), "y", "feeder"),
    Component("feeder wheel, upper right", (0.25, -0.08, 0.36), "y", "feeder"),
    Component("hood", (0.27, 0.0, 0.50), "y", "hood"),
    Component("shooter wheel, left", (0.27, 0.08, 0.50), "y", "shooter_wheels"),
    Component("shooter wheel, right", (0.27, -0.08, 0.50), "y", "shooter_wheels"),
    Component("shooter backspin roller", (0.055, 0.0, 0.40), "y", "shooter_wheels", -1.0),
)
"""In the order of the model files. Fuel rises behind the feeder and shooter wheels, and leaves where the hood, which
turns about the shooter wheels' axle, lets it go: straight up at 20 degrees, at 45 degrees when it stands at 65."""


def component_poses(robot: RebuiltRobot) -> FloatArray:
    """Pose rows `x, y, z, qw, qx, qy, qz` of all parts in the robot frame, shape (16, 7)."""
    rows = np.zeros((len(COMPONENTS), 7))
    rows[:, 3] = 1.0
    extension = robot.deploy.extension
    for row, part in zip(rows, COMPONENTS, strict=True):
        row[:3] = part.place
        if part.slides:
            row[0] += part.slides * extension * RAILS[0]
            # what goes only some of the way, the hopper, stays level
            row[2] += extension * RAILS[2] if part.slides == 1.0 else 0.0
        if part.axis:
            half = 0.5 * math.fmod(part.ratio * getattr(robot, part.mechanism).position, 4.0 * math.pi)
            row[3] = math.cos(half)
            row[4 + "xyz".index(part.axis)] = math.sin(half)
    rows.setflags(write=False)
    return rows
