"""Runs of a robot project: its own code plays an auto of its chooser, in a process of its own."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from simcore.errors import ConfigError, SimcoreError
from simcore.sweep.child_process import ask_process
from simcore.sweep.experiment import Experiment, PlannedRun
from simcore.sweep.factor_paths import PLAYED, vary_scatter
from simcore.sweep.factors import PROJECT

__all__ = ["play_project", "require_project"]

_OF_PROJECTS = ("alliance", "auto", "engine", "seconds")
"""Those of `PLAYED` that a project can be told; where it starts is its auto's affair."""


def require_project(experiment: Experiment) -> None:
    """Refuse what no run can be played with, as far as that shows without the robot's code.

    Raises:
        ConfigError: There is no robot.py, or a factor is one of scripted autos.
    """
    folders = {str(experiment.project), *(str(v) for f in experiment.factors if f.name == PROJECT for v in f.values)}
    for folder in map(Path, sorted(folders)):
        if not (folder / "robot.py").is_file():
            raise ConfigError(f"project: there is no robot.py in {folder}; name the folder that it is in")
    for factor in experiment.factors:
        first = factor.name.partition(".")[0]
        if first == PROJECT:
            continue
        if first in PLAYED and factor.name not in _OF_PROJECTS:
            raise ConfigError(
                f"factor {factor.name!r}: of a project want {', '.join(_OF_PROJECTS)}, robot.*, scatter.* or pieces.*; "
                "where it starts, with how many pieces, is the project's own affair"
            )
        for value in factor.values:
            vary_scatter(experiment.scatter, {factor.name: value})


def play_project(experiment: Experiment, planned: PlannedRun, log: Path | None = None) -> dict[str, Any]:
    """Metrics, digest and cpu_seconds of a run; its telemetry goes to a log, if one is asked for.

    Raises:
        SimcoreError: The robot's code has failed, or its process has ended; the text says how.
    """
    values = planned.values
    scatter = vary_scatter(experiment.scatter, values)
    task = {
        "auto": values.get("auto", experiment.auto),
        "alliance": values.get("alliance", experiment.alliance),
        "seconds": values.get("seconds", experiment.seconds),
        "engine": values.get("engine", experiment.engine),
        "game": experiment.game,
        "seed": planned.seed,
        "scatter": None if scatter is None else scatter.text,
        "values": {name: value for name, value in values.items() if _is_of_match(name)},
        "metrics": experiment.metrics,
        "log": None if log is None else str(log.resolve()),
    }
    folder = Path(str(values.get(PROJECT, experiment.project))).resolve()
    task["project"] = str(folder)
    answer = ask_process("simcore.robotpy.project_run", task, timeout=experiment.timeout, folder=folder)
    if "error" in answer:
        raise SimcoreError(answer["error"])
    measured: dict[str, Any] = answer
    return measured


def _is_of_match(name: str) -> bool:
    return name.partition(".")[0] not in (*PLAYED, PROJECT, "scatter")
