"""Options that `simcore sweep` and `simcore tune` share: of whom the runs are, and how each of them is played."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from simcore.physics.engine_choice import add_engine_option
from simcore.quantities import Quantity, number_flag
from simcore.robot_file.template import FILE_NAME as ROBOT_FILE

__all__ = ["COUNT_FLAG", "WORKERS_FLAG", "add_played_options", "add_player_options", "experiment_fields"]

COUNT_FLAG = number_flag(Quantity("", 1, 1_000_000, is_whole=True))
WORKERS_FLAG = number_flag(Quantity("", 0, 100_000, is_whole=True))
_SECONDS = number_flag(Quantity("s", 0.0, 3600.0, is_open=True))
_WALL = number_flag(Quantity("s", 0.0, 1e6, is_open=True))
_TIMEOUT = 600.0  # [s]; a whole match takes some tens


def add_player_options(parser: argparse.ArgumentParser) -> None:
    """Game, auto, and whose robot or code plays it."""
    parser.allow_abbrev = False  # `--seed 7`, as of one run, would be `--seeds 7`
    parser.add_argument("game", nargs="?", metavar="GAME", help="which game (default: the newest that is installed)")
    parser.add_argument("--auto", metavar="NAME", help="which auto (default: the game's first, or the chooser's)")
    parser.add_argument("--project", type=Path, metavar="FOLDER", help="the folder of a robot.py, whose own code plays")
    parser.add_argument(
        "--robot", metavar="FILE.toml", help=f"another robot than the game's own: a {ROBOT_FILE}, or module:function"
    )


def add_played_options(parser: argparse.ArgumentParser) -> None:
    """How long, for which alliance, with which options of the game, on which engine, and when a run is given up."""
    parser.add_argument(
        "--seconds", type=_SECONDS, metavar="S", help="simulated time (default: the auto, or the match)"
    )
    parser.add_argument("--alliance", choices=("blue", "red"), default="blue", help="whose robot (default: blue)")
    players = "who plays a whole match, ROLE[:LEVEL] with commas between; 'me' plays --auto"
    parser.add_argument("--red", metavar="PLAYERS", default="", help=players)
    parser.add_argument("--blue", metavar="PLAYERS", default="", help="the same")
    parser.add_argument(
        "--option", action="append", default=[], metavar="NAME", help="an option of the game that is on"
    )
    add_engine_option(parser)
    parser.add_argument(
        "--timeout", type=_WALL, default=_TIMEOUT, metavar="S", help="wall time of one run (default: 600)"
    )


def experiment_fields(options: argparse.Namespace) -> dict[str, Any]:
    """What these options say, by the fields of `Experiment`."""
    return {
        "game": options.game,
        "auto": options.auto,
        "alliance": options.alliance,
        "red": options.red,
        "blue": options.blue,
        "seconds": options.seconds,
        "options": tuple(options.option),
        "engine": options.engine,
        "robot": options.robot,
        "project": options.project,
        "timeout": options.timeout,
    }
