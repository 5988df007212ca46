"""Functions that play one run of an experiment and return the run's row of results, or a row with an error."""

from __future__ import annotations

import os
import traceback
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache, partial
from importlib import import_module
from pathlib import Path
from time import process_time
from typing import Any

from simcore.errors import ConfigError, SimcoreError, VendorError
from simcore.install_text import install_command
from simcore.match.game import Game
from simcore.match.players.lineup import ME, play_match, plays
from simcore.match.registry import find_game
from simcore.match.runner import AutoRun, play_auto
from simcore.match.starts import require_playable
from simcore.robot.dc_motor import motor
from simcore.robot.robot_config import RobotConfig
from simcore.robot.swerve_config import SwerveConfig
from simcore.robot_file.reader import read_settings
from simcore.robot_file.template import FILE_NAME as ROBOT_FILE
from simcore.sweep.code_version import code_version
from simcore.sweep.experiment import Experiment, PlannedRun
from simcore.sweep.factors import CONFIGS, PLAYED, PROJECT, RunSetup, vary, vary_scatter
from simcore.sweep.run_metrics import measure, named_object
from simcore.telemetry.wpilog import WpilogSink

__all__ = [
    "failed_row", "game_of", "planned_values", "play_run", "play_values", "require_playable_runs", "robot_of",
    "sentence_of", "setup_of",
]  # fmt: skip

_OF_PROJECTS = ("alliance", "auto", "engine", "seconds")
"""Names in `PLAYED` that are valid factors for a robot project. The project itself sets the other quantities."""


def play_run(experiment: Experiment, planned: PlannedRun, log: Path | None = None) -> dict[str, Any]:
    """Play a run in this process, and return the row of the run, with the error if the run fails.

    Args:
        experiment: Experiment of the run. A process can play only one run of a robot project.
        planned: Run to play.
        log: File for the telemetry of the run; None for no file.

    Returns:
        Values in plain types by column: run, point, seed, the factors, the metrics, digest, version, error and
        cpu_seconds. The error is empty for a successful run. A row with an error has no metrics and no digest.
    """
    start = process_time()
    try:
        measured = play_values(experiment, planned, log)
    except (Exception, SystemExit) as error:
        row = failed_row(planned, sentence_of(error))
    else:
        row = {**planned_values(planned), **measured, "version": code_version(), "error": ""}
    return {**row, "cpu_seconds": process_time() - start}


def play_values(experiment: Experiment, planned: PlannedRun, log: Path | None = None) -> dict[str, Any]:
    """Play a run and return the run's metrics and digest by column.

    Args:
        experiment: Experiment of the run.
        planned: Run to play.
        log: File for the telemetry of the run; None for no file.

    Raises:
        SimcoreError: If the run cannot be played.
    """
    if experiment.project is not None:
        return _play_project(experiment, planned, log)
    setup = vary(setup_of(experiment), planned.values)
    play: Callable[..., AutoRun] = partial(play_auto, setup.game, setup.auto, alliance=setup.alliance)
    if setup.seats:
        play = partial(play_match, setup.game, setup.seats, me=plays(setup.auto))
    played = play(
        seconds=setup.seconds,
        seed=planned.seed,
        robot=setup.robot,
        scatter=setup.scatter,
        options=experiment.options,
        engine=setup.engine,
        sinks=() if log is None else (WpilogSink(log),),
    )
    with played.match:
        metrics = measure(played.match, experiment.metrics)
        return {**metrics, "digest": played.report.digest}


def failed_row(planned: PlannedRun, error: str) -> dict[str, Any]:
    """Return the row of a failed run, with an error, without metrics and with a CPU time of 0."""
    return {**planned_values(planned), "version": code_version(), "error": error, "cpu_seconds": 0.0}


def planned_values(planned: PlannedRun) -> dict[str, Any]:
    """Return the columns of a row that are known before the run: run, point, seed and factors."""
    return {"run": planned.number, "point": planned.point, "seed": planned.seed, **planned.values}


def sentence_of(error: BaseException) -> str:
    """Return the message of an error as one line of text.

    For errors other than `SimcoreError`, add the type of the error and the file and line that raised the error.
    """
    text = " ".join(str(error).split())
    if isinstance(error, SimcoreError):
        return text
    places = traceback.extract_tb(error.__traceback__)
    at = f" ({os.path.basename(places[-1].filename)}, line {places[-1].lineno})" if places else ""
    return f"{type(error).__name__}: {text}{at}"


@lru_cache(maxsize=4)
def setup_of(experiment: Experiment) -> RunSetup:
    """Return the setup that an experiment's runs share, before the factor values are applied.

    Raises:
        SimcoreError: If the game, auto or robot does not exist.
    """
    game = game_of(experiment.game)
    return RunSetup(
        game=game,
        auto=game.auto(experiment.auto),
        robot=robot_of(experiment.robot, game),
        scatter=experiment.scatter,
        alliance=experiment.alliance,
        red=experiment.red,
        blue=experiment.blue,
        seconds=experiment.seconds,
        engine=experiment.engine,
    )


def require_playable_runs(experiment: Experiment) -> None:
    """Check an experiment before the first run.

    The check includes each listed value of every factor, or the median of a factor with a distribution.

    Raises:
        SimcoreError: If a game, auto, robot, factor or value is invalid; the message names the valid choices.
    """
    if experiment.project is not None:
        _require_project(experiment)
        return
    setup = setup_of(experiment)
    require_playable(setup.game, (), options=experiment.options, controllers=0, seed=0)
    for factor in experiment.factors:
        values = factor.values or (factor.at(0.5),)
        for value in values:
            _require_me(vary(setup, {factor.name: value}), factor.name)


def _require_me(setup: RunSetup, factor: str) -> None:
    """Raise a `ConfigError` if a factor concerns the robot or auto of the player `ME`, but the match has no `ME`."""
    of_all = ("blue", "engine", "pieces", "red", "scatter", "seconds")
    seats = setup.seats
    if seats and factor.partition(".")[0] not in of_all and all(seat.role != ME for seat in seats):
        raise ConfigError(f"factor {factor!r}: it applies to the robot {ME!r}, but neither --red nor --blue has {ME!r}")


def game_of(name: str | None) -> Game:
    """Return an installed game by name, or any game by `module:name`; None for the newest installed game.

    Raises:
        SimcoreError: If the game does not exist.
    """
    if name is None or ":" not in name:
        return find_game(name, say=str)
    game = named_object(name, "game")
    if not isinstance(game, Game):
        raise ConfigError(f"game {name!r} must be a Game, got a {type(game).__name__}")
    return game


def robot_of(name: str | None, game: Game) -> RobotConfig:
    """Return the robot config that a name selects.

    The robot of a `simcore.toml` has the storage and the drivetrain of the game's robot, with the mass, the motors and
    the wheel friction of the file.

    Args:
        name: `module:function` of a function that returns a config, `module:name` of a config, or the path of a
            `simcore.toml`; None for the game's robot.
        game: Game that provides the default robot.

    Raises:
        ConfigError: If the file or function does not exist, or the result is not a `RobotConfig`.
    """
    own = game.robot()
    if name is None:
        return own
    if name.endswith(".toml"):
        if not Path(name).is_file():
            raise ConfigError(f"robot: there is no file {name!r}")
        settings = read_settings(Path(name))
        drivetrain = replace(own.drivetrain, mass=settings.mass)
        if isinstance(drivetrain, SwerveConfig):
            motors = {"drive_motor": settings.drive_motor, "steer_motor": settings.steer_motor}
            given = {part: motor(kind) for part, kind in motors.items() if kind is not None}
            modules = (replace(m, wheel_cof=settings.wheel_cof, **given) for m in drivetrain.modules)  # type: ignore[arg-type]
            drivetrain = replace(drivetrain, modules=tuple(modules))
        return settings.robot_config(drivetrain, storage=own.storage)
    made = named_object(name, "robot")
    config = made() if callable(made) else made
    if not isinstance(config, RobotConfig):
        raise ConfigError(f"robot {name!r} must return a RobotConfig, got a {type(config).__name__}")
    return config


# --- robot projects -------------------------------------------------------------------------------------------------


def _require_project(experiment: Experiment) -> None:
    """Check the folders, the factor names and the scatter values of a project experiment, without running robot code.

    Raises:
        ConfigError: If a folder has no robot.py (no simcore.toml if the experiment has a command), or if a factor or a
            scatter value is not valid for a project.
    """
    folders = {str(experiment.project), *(str(v) for f in experiment.factors if f.name == PROJECT for v in f.values)}
    for folder in map(Path, sorted(folders)):
        file = ROBOT_FILE if experiment.command else "robot.py"
        if not (folder / file).is_file():
            raise ConfigError(f"project: there is no {file} in {folder}; name the folder that it is in")
    for factor in experiment.factors:
        first = factor.name.partition(".")[0]
        if first == PROJECT:
            continue
        if first not in CONFIGS and factor.name not in _OF_PROJECTS:
            raise ConfigError(
                f"factor {factor.name!r}: factors of a project are {', '.join(_OF_PROJECTS)}, robot.*, scatter.* or "
                "pieces.*; the project itself decides where it starts and with how many pieces"
            )
        for value in factor.values:
            vary_scatter(experiment.scatter, {factor.name: value})


def _play_project(experiment: Experiment, planned: PlannedRun, log: Path | None) -> dict[str, Any]:
    """Play a run with the code of a robot project, and return the run's metrics and digest by column.

    Raises:
        SimcoreError: If the robot's code fails; the message contains the error of the robot's code.
        VendorError: If RobotPy is not installed.
    """
    try:
        adapter = import_module(
            "simcore.bridge.served_run" if experiment.command else "simcore.robotcode.sim.project_run"
        )
    except ImportError as error:
        raise VendorError(f"robot projects need RobotPy: {install_command('robotpy')}") from error
    values = planned.values
    scatter = vary_scatter(experiment.scatter, values)
    measured: dict[str, Any] = adapter.play_project(
        {
            "project": str(Path(str(values.get(PROJECT, experiment.project))).resolve()),
            "auto": values.get("auto", experiment.auto),
            "alliance": values.get("alliance", experiment.alliance),
            "seconds": values.get("seconds", experiment.seconds),
            "engine": values.get("engine", experiment.engine),
            "game": experiment.game,
            "seed": planned.seed,
            "scatter": None if scatter is None else scatter.text,
            "values": {
                name: v for name, v in values.items() if name.partition(".")[0] not in (*PLAYED, PROJECT, "scatter")
            },
            "metrics": experiment.metrics,
            "log": None if log is None else str(log.resolve()),
            "command": experiment.command,
        }
    )
    return measured
