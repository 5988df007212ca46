"""Command `simcore shots`, which computes the shot table of a shooter: the best shot at each distance."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from rich.console import Console
from rich.table import Table

from simcore.errors import ConfigError
from simcore.match.registry import find_game
from simcore.match.scatter import Scatter
from simcore.quantities import FIELD_LENGTH, Quantity, number_flag, require, text_flag
from simcore.sweep.factors import parse_factor, vary_robot
from simcore.sweep.one_run import robot_of
from simcore.sweep.shot_files import table_cells, table_csv, table_page, table_python
from simcore.sweep.shot_table import ShotTable, ShotTableRow, make_table
from simcore.sweep.shot_task import ShotTask
from simcore.telemetry.sinks import require_writable, write_text

__all__ = ["add_arguments", "run"]

_NUMBER = number_flag(Quantity("", 0, 100, is_whole=True))
_FILES = ("shots.csv", "shot_table.py", "shots.html")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments and options of `simcore shots`."""
    add = parser.add_argument
    add("game", nargs="?", metavar="GAME", help="game (default: the newest installed one)")
    add("--robot", metavar="FILE.toml", help="robot in place of the game's: a simcore.toml, or module:function")
    add("--set", dest="values", action="append", default=[], type=text_flag(parse_factor), metavar="PATH=VALUE",
        help="change the robot, e.g. robot.shooters.0.exit_efficiency=0.45; may be given again")  # fmt: skip
    add("--target", metavar="NAME", help="target zone (default: the first of the alliance)")
    add("--alliance", choices=("blue", "red"), default="blue", help="alliance of the zone (default: blue)")
    add("--shooter", type=_NUMBER, default=0, metavar="N", help="number of the shooter, from 0 (default: 0)")
    add("--distances", type=text_flag(_distances), default=_distances("1:8:1"), metavar="FROM:TO:STEP",
        help="distances from the robot's center to the target's [m]; or a list, 2,2.5,3 (default: 1:8:1)")  # fmt: skip
    add("--scatter", type=text_flag(Scatter.parse), default=Scatter(), metavar="SPREADS",
        help="scatter of the shots: 1 for the default spreads, 0 for none, 1,exit_speed=0.03 to change one of them",
        )  # fmt: skip
    add("--out", type=Path, default=Path("out/shots"), metavar="FOLDER", help="default: out/shots")


def _distances(text: str) -> tuple[float, ...]:
    try:
        values = parse_factor(f"distances={text}").values
    except ConfigError as error:
        raise ConfigError(
            f"{text!r} cannot be read: write from:to:step, the nearest first, e.g. 2:6:0.5, or a list, e.g. 2,2.5,3"
        ) from error
    for value in values:
        require("simcore shots", "distances", value, FIELD_LENGTH)
    return tuple(float(value) for value in values)


def run(options: argparse.Namespace) -> int:
    """Compute a shot table, print the table, and write the CSV, Python and HTML files.

    Returns:
        Exit status: 0, or 1 if no row has a shot.

    Raises:
        SimcoreError: If the table cannot be computed or written.
    """
    game = find_game(options.game, say=lambda which: print(f"simcore: {which}", file=sys.stderr))
    values = {}
    for factor in options.values:
        if len(factor.values) != 1:
            raise ConfigError(f"factor {factor.name}: only one value is allowed here, as in {factor.name}=0.45")
        values[factor.name] = factor.values[0]
    robot = vary_robot(robot_of(options.robot, game), values)
    task = ShotTask(game, robot, target=options.target, alliance=options.alliance, shooter=options.shooter)
    paths = [require_writable("table", options.out / name) for name in _FILES]
    table = make_table(
        task, options.distances, scatter=options.scatter,
        on_row=lambda row: print(f"simcore: {_said(row)}", file=sys.stderr),
    )  # fmt: skip
    for path, text in zip(paths, (table_csv(table), table_python(table), table_page(table)), strict=True):
        write_text("table", path, text)
    _print(table)
    print(f"written {', '.join(_FILES)} in {options.out}")
    return 0 if table.feasible else 1


def _said(row: ShotTableRow) -> str:
    share = "" if row.share is None else f"{row.share:.1%} go in"
    return f"{row.stand.distance:g} m: {row.problem or share}"


def _print(table: ShotTable) -> None:
    """Print the table on the console."""
    task = table.task
    shown = Table(title=f"{task.zone.name}, {task.kind.name.lower()}, all {len(task.barrels)} barrels")
    heads, lines = table_cells(table)
    for head in heads:
        shown.add_column(head, justify="right")
    for line in lines:
        shown.add_row(*line)
    Console(width=150).print(shown)
