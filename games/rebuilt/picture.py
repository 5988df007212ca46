"""The picture of a run: the field from above, the robot's path, fuel and shots."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from games.rebuilt.field import FIELD_SIZE
from games.rebuilt.runner import AutoRun
from games.rebuilt.sim import RebuiltSim
from simcore.telemetry.picture import ShotTrace, draw_match
from simcore.typing import FloatArray

__all__ = ["draw_game", "draw_run"]


def draw_run(path: Path, run: AutoRun) -> None:
    """Write a PNG of a run.

    Raises:
        OutputError: The file cannot be written.
    """
    report = run.report
    draw_game(
        path,
        run.sim,
        robot_path=run.path,
        fuel_at_start=run.fuel_at_start,
        title=f"REBUILT, auto '{report.auto}', {report.alliance}, seed {report.seed}",
        subtitle=f"{report.score.total} points, {report.hits} of {report.shots} shots hit, "
        f"{report.distance_m:.1f} m driven, {report.sim_seconds:g} s",
    )


def draw_game(
    path: Path, sim: RebuiltSim, *, robot_path: FloatArray, fuel_at_start: FloatArray, title: str, subtitle: str
) -> None:
    """Write a PNG of a game as it stands.

    Args:
        path: Of the file.
        sim: The game.
        robot_path: Of its first robot, a row a tick: x, y, yaw [m, m, rad].
        fuel_at_start: Places of all fuel on the field [m], shape (n, 3).
        title: Headline.
        subtitle: Second line.

    Raises:
        OutputError: The file cannot be written.
    """
    chassis = sim.robots[0].chassis.config
    draw_match(
        path,
        field_outlines=sim.field.outlines(),
        field_size=FIELD_SIZE,
        robot_path=robot_path,
        fuel_start=fuel_at_start,
        fuel_end=sim.pieces.state.pos[sim.pieces.on_field()],
        shots=[ShotTrace(points=np.array(shot.points), scored=shot.scored) for shot in sim.shots],
        intakes=np.array(sim.intakes).reshape(-1, 3),
        title=title,
        subtitle=subtitle,
        bumpers=(chassis.bumper_length, chassis.bumper_width),
    )
