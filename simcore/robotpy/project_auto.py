"""The robot test that is a run of a sweep; `project_run` lets pytest run it."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from simcore.robotpy.project_run import ProjectRun
    from simcore.robotpy.robot_test import RobotTest

__all__ = ["test_auto"]


def test_auto(sim: RobotTest, project_run: ProjectRun) -> None:
    """Play the auto, and measure what came of it."""
    project_run.play(sim)
