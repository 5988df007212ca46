"""What a picture of REBUILT shows beside its telemetry."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from games.rebuilt.field import FIELD_SIZE, load_field
from games.rebuilt.fuel import FUEL
from simcore.show.scene import PieceLook, RobotLook, Scene, ShotTrace

if TYPE_CHECKING:
    from games.rebuilt.sim import RebuiltSim

__all__ = ["bare_scene", "scene_of"]

_PIECES = {
    FUEL.name: PieceLook(radius=FUEL.bounding_radius, color="#ffd923", air_color="#ff9800", edge_color="#7d6400")
}


def bare_scene() -> Scene:
    """The field alone, for a run of which only the log is left."""
    return Scene(
        field_size=FIELD_SIZE,
        field_outlines=load_field().outlines(),
        pieces=_PIECES,
    )


def scene_of(sim: RebuiltSim) -> Scene:
    """The scene of a match as it is now, also after it was closed."""
    robots = []
    for robot in sim.robots:
        c = robot.chassis.config
        look = RobotLook(
            alliance=sim.alliances[robot.number],
            bumpers=(c.bumper_length, c.bumper_width),
            prefix="Sim" if robot.number == 0 else f"Sim/Robots/{robot.number}",
        )
        robots.append(look)
    return Scene(
        field_size=FIELD_SIZE,
        field_outlines=sim.field.outlines(),
        robots=robots,
        shots=[
            ShotTrace(points=np.array(shot.points), scored=shot.scored, time=shot.time, robot=shot.robot)
            for shot in sim.shots
        ],
        intakes=np.array(sim.intakes, dtype=np.float64).reshape(-1, 3),
        pieces=_PIECES,
    )
