"""The picture of a run: the field from above, the robot's path, fuel and shots."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from games.rebuilt.field import FIELD_SIZE
from games.rebuilt.runner import AutoRun
from simcore.telemetry.picture import ShotTrace, draw_match

__all__ = ["draw_run"]


def draw_run(path: Path, run: AutoRun) -> None:
    """Write a PNG of a run.

    Raises:
        OutputError: The file cannot be written.
    """
    sim, report = run.sim, run.report
    chassis = sim.robots[0].chassis.config
    draw_match(
        path,
        field_outlines=sim.field.outlines(),
        field_size=FIELD_SIZE,
        robot_path=run.path,
        fuel_start=run.fuel_at_start,
        fuel_end=sim.pieces.state.pos[sim.pieces.on_field()],
        shots=[ShotTrace(points=np.array(shot.points), scored=shot.scored) for shot in sim.shots],
        intakes=np.array(sim.intakes).reshape(-1, 3),
        title=f"REBUILT, auto '{report.auto}', {report.alliance}, seed {report.seed}",
        subtitle=f"{report.score.total} points, {report.hits} of {report.shots} shots hit, "
        f"{report.distance_m:.1f} m driven, {report.sim_seconds:g} s",
        bumpers=(chassis.bumper_length, chassis.bumper_width),
    )
