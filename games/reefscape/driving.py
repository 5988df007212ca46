"""Driver controls of the REEFSCAPE robot."""

from __future__ import annotations

import math
from collections.abc import Callable

from games.reefscape.handling import (
    SETTINGS,
    before_algae,
    before_branch,
    make_ready,
    place_coral,
    process,
    raised_to,
    take_algae,
    tuck,
)
from simcore.match.players.driven_robot import DriverControls
from simcore.match.scripted import ScriptedRobot, Steps

__all__ = ["DRIVING"]

_FACES = range(6)


def _place_near(level: int) -> Callable[[ScriptedRobot], Steps]:
    """Return a script that places the coral on the nearest branch of a level."""
    branches = {(face, side): before_branch(face, side, level)[:2] for face in _FACES for side in ("left", "right")}

    def script(robot: ScriptedRobot) -> Steps:
        yield from raised_to(robot, level)  # else a robot at the reef would lower the coral onto the branches
        face, side = min(branches, key=lambda branch: math.dist(robot.pose[:2], branches[branch]))
        yield from place_coral(robot, face, side, level)

    return script


def _algae_near(robot: ScriptedRobot) -> Steps:
    """Bring a held algae to the processor, or take the algae from the nearest face of the reef."""
    if robot.robot.placers[1].piece is not None:
        yield from process(robot)
    else:
        yield from take_algae(robot, min(_FACES, key=lambda face: math.dist(robot.pose[:2], before_algae(face)[:2])))


def _rest(robot: ScriptedRobot) -> None:
    tuck(robot)
    make_ready(robot)


DRIVING = DriverControls(
    settings=SETTINGS,
    actions={**{f"level {level}": _place_near(level) for level in (4, 3, 2)}, "algae": _algae_near},
    rest=_rest,
)
"""Driver controls: actions that place coral on the nearest branch of level 4, 3 or 2, and an action for algae."""
