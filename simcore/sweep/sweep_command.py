"""Command `simcore sweep`, which plays an auto or a match many times and reports success rates and statistics."""

from __future__ import annotations

import argparse
import re
import shlex
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from simcore.errors import ConfigError, SimcoreError, UnknownNameError
from simcore.match.scatter import Scatter
from simcore.quantities import Quantity, number_flag, text_flag
from simcore.robot_file.reader import read_settings
from simcore.robot_file.template import FILE_NAME as ROBOT_FILE
from simcore.show.log_page import write_log_page
from simcore.sweep.api import sweep
from simcore.sweep.experiment import Experiment, PlannedRun
from simcore.sweep.factors import parse_factor
from simcore.sweep.one_run import planned_values, play_values
from simcore.sweep.results import TABLE_NAME, Condition, Results
from simcore.sweep.run_metrics import METRICS
from simcore.sweep.run_store import RunStore
from simcore.sweep.sweep_page import summary_text, sweep_page
from simcore.sweep.workers import Crew
from simcore.telemetry.sinks import write_text
from simcore.world.engine_choice import add_engine_option

__all__ = [
    "PAGE_NAME", "add_arguments", "add_played_options", "chosen_scatter", "experiment_fields", "play_aloud",
    "progress", "run", "scatter_option", "sigterm_as_interrupt", "takes_command",
]  # fmt: skip

PAGE_NAME = "page.html"
takes_command = True
"""Whether the command line passes the words after `--` to this command; here the words are the command of `--serve`."""
_COUNT = number_flag(Quantity("", 1, 1_000_000, is_whole=True))
_WORKERS = number_flag(Quantity("", 0, 100_000, is_whole=True))
_SECONDS = number_flag(Quantity("s", 0.0, 3600.0, is_open=True))
_WALL = number_flag(Quantity("s", 0.0, 1e6, is_open=True))
_TIMEOUT = 600.0  # [s] of wall time; a whole match takes tens of seconds
_MOST_SEEDS = 1_000_000
_SAMPLES = 20  # default number of combinations if a factor is drawn
_RUN = number_flag(Quantity("", 0, 10_000_000, is_whole=True))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments and options of `simcore sweep`."""
    parser.allow_abbrev = False  # otherwise `--seed 7`, an option of single runs, would mean `--seeds 7`
    parser.add_argument("game", nargs="?", metavar="GAME", help="game (default: the newest installed one)")
    parser.add_argument("--auto", metavar="NAME", help="auto (default: the game's first, or the chooser's)")
    parser.add_argument("--project", type=Path, metavar="FOLDER", help="folder of a robot.py, whose code plays")
    parser.add_argument(
        "--serve",
        action="store_true",
        help="the project's program may be in any language; its command follows after --",
    )
    parser.add_argument(
        "--robot", metavar="FILE.toml", help=f"robot in place of the game's: a {ROBOT_FILE}, or module:function"
    )
    parser.add_argument(
        "--seeds", type=_seeds, default=range(10), metavar="N", help="number of seeds, or 5:20, or 1,7,9 (default: 10)"
    )
    parser.add_argument(
        "--set",
        dest="factors",
        action="append",
        default=[],
        type=text_flag(parse_factor),
        metavar="FACTOR=VALUES",
        help="vary a factor: robot.mass=45:60:5, robot.battery.initial_charge=0.3,1, auto=left,right, "
        "robot.mass=normal(55,1); may be given again",
    )
    parser.add_argument(
        "--samples", type=_COUNT, metavar="N", help="draw N combinations of the factors (default: all of a grid)"
    )
    scatter_option(parser)
    parser.add_argument("--success", default="", metavar="CONDITION", help="condition of a success: 'score >= 30'")
    parser.add_argument(
        "--metric",
        dest="metrics",
        action="append",
        default=[],
        metavar="NAME",
        help="measure only this metric, or your own function, module:function; may be given again",
    )
    add_played_options(parser)
    parser.add_argument("--cluster", metavar="ADDRESS", help="play on a Dask cluster, e.g. tcp://10.0.0.5:8786")
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="folder for rows and page (default: out/AUTO)")
    parser.add_argument("--csv", action="store_true", help=f"also write the table {TABLE_NAME}, e.g. for pandas")
    parser.add_argument(
        "--repeat",
        type=_RUN,
        metavar="RUN",
        help="play one run of --out again, with all its output, and write its log and page there",
    )


def add_played_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that describe a run (duration, alliance, players, engine, ...) and the number of processes."""
    parser.add_argument(
        "--seconds", type=_SECONDS, metavar="S", help="simulated time (default: the auto, or the match)"
    )
    parser.add_argument(
        "--alliance", choices=("blue", "red"), default="blue", help="alliance of the robot (default: blue)"
    )
    players = "players of a whole match, ROLE[:LEVEL] separated by commas; 'me' plays --auto"
    parser.add_argument("--red", metavar="PLAYERS", default="", help=f"red {players}")
    parser.add_argument("--blue", metavar="PLAYERS", default="", help=f"blue {players}")
    parser.add_argument(
        "--option", dest="options", action="append", default=[], metavar="NAME", help="option of the game to switch on"
    )
    add_engine_option(parser)
    parser.add_argument(
        "--timeout", type=_WALL, default=_TIMEOUT, metavar="S", help="limit of one run's wall time (default: 600)"
    )
    parser.add_argument(
        "-j", "--workers", type=_WORKERS, default=0, metavar="N", help="processes (default: 0, one for each core)"
    )


def experiment_fields(options: argparse.Namespace) -> dict[str, Any]:
    """Return the fields of an `Experiment` that have the same names as command-line options."""
    names = "game auto alliance red blue seconds options engine robot project timeout"
    return {name: getattr(options, name) for name in names.split()}


def scatter_option(parser: argparse.ArgumentParser) -> None:
    """Add the option `--scatter`, which `chosen_scatter` reads."""
    parser.add_argument(
        "--scatter",
        type=text_flag(Scatter.parse),
        metavar="SPREADS",
        help="scatter of robot, pieces and shots from seed to seed: 1 for the default spreads, 0 for none, "
        "1,exit_speed=0.03 to change one of them",
    )


def run(options: argparse.Namespace) -> int:
    """Play the sweep, print a summary and write the page; with `--repeat`, play one run of an earlier sweep again.

    Returns:
        Exit status: 0 if no run ended with an error, 1 if at least one run ended with an error, 130 after an interrupt.

    Raises:
        SimcoreError: If the sweep cannot be played.
    """
    if options.repeat is not None:
        return _repeat(options)
    experiment = _experiment(options)
    is_match = experiment.red or experiment.blue
    out = options.out or Path("out") / re.sub(r"[^\w.-]", "_", "matches" if is_match else experiment.auto or "sweep")
    try:
        with progress(experiment.count) as on_row, sigterm_as_interrupt():
            results = sweep(
                experiment, workers=options.workers or None, cluster=options.cluster, out=out, on_row=on_row
            )
    except KeyboardInterrupt:
        print(
            "simcore: interrupted; runs that are over are kept, and the same command goes on with them", file=sys.stderr
        )
        return 130
    print(summary_text(results, options.success), flush=True)  # before files are written: the disk may be full
    _print_replays(results, out)
    if options.csv:
        print(f"\n{results.save_table(out)}")
    write_text("page", out / PAGE_NAME, sweep_page(results, options.success, out))
    print(f"\n{out / PAGE_NAME}")
    return 1 if results.failures else 0


@contextmanager
def sigterm_as_interrupt() -> Iterator[None]:
    """Raise `KeyboardInterrupt` on SIGTERM in the block, because an interrupted sweep ends the worker processes.

    The context manager has no effect outside the main thread.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _experiment(options: argparse.Namespace) -> Experiment:
    if options.serve != bool(options.behind):
        raise ConfigError("--serve and a command behind -- belong together: --serve -- ./gradlew simulateJavaRelease")
    if options.serve and options.project is None:
        options.project = Path()
    if options.success:
        _require_columns(options.success, options)
    is_drawn = any(factor.distribution is not None for factor in options.factors)
    return Experiment(
        **experiment_fields(options),
        command=tuple(options.behind),
        scatter=chosen_scatter(options),
        factors=tuple(options.factors),
        samples=options.samples or (_SAMPLES if is_drawn else 0),
        seeds=tuple(options.seeds),
        metrics=tuple(options.metrics),
    )


def _require_columns(text: str, options: argparse.Namespace) -> None:
    """Raise an `UnknownNameError` if a condition names a column that no run will have."""
    condition = Condition(text)
    if any(":" in metric for metric in options.metrics):
        return  # a function's metrics are unknown before a run
    known = {*(options.metrics or METRICS), *(factor.name for factor in options.factors), "seed"}
    for name in condition.names:
        if name not in known and not name.startswith("breakdown."):
            raise UnknownNameError("metric or factor (of --success)", name, known)


def chosen_scatter(options: argparse.Namespace) -> Scatter | None:
    """Return the scatter of the options, or the default scatter if `--scatter` is missing.

    If `--scatter` is missing and the project's `simcore.toml` sets a scatter, return None.
    """
    if options.scatter is not None:
        found: Scatter = options.scatter
        return found
    if options.project is not None and read_settings(options.project / ROBOT_FILE).scatter is not None:
        return None
    return Scatter()


def _print_replays(results: Results, out: Path) -> None:
    """Print, for each different error, the command that repeats the first run with this error."""
    for number in {row["error"]: row["run"] for row in reversed(results.failures)}.values():
        print(f"run {number} alone: simcore sweep --out {shlex.quote(str(out))} --repeat {number}")


def _repeat(options: argparse.Namespace) -> int:
    """Play a stored run again with console output, write the log and the page of the run, and return exit status 0.

    The function does not catch errors of the run. The page is also written for a run that fails.
    """
    if options.out is None:
        raise ConfigError("--repeat needs --out: the folder whose run it is")
    with closing(RunStore(options.out, must_exist=True)) as store:
        experiment = store.experiment()
    runs = experiment.runs()
    if options.repeat >= len(runs):
        raise ConfigError(f"--repeat: {options.out} has runs 0 to {len(runs) - 1}, got {options.repeat}")
    planned = runs[options.repeat]
    values = "".join(f", {name} = {value}" for name, value in planned.values.items())
    print(f"run {planned.number}: auto {experiment.auto or 'as chosen'}, seed {planned.seed}{values}", flush=True)
    log = options.out / f"run_{planned.number}.wpilog"
    try:
        for name, value in play_aloud(experiment, planned, log).items():
            print(f"    {name:24} {value}")
    finally:  # the page of a failed run shows the run up to the failure
        _draw(log)
    return 0


def _draw(log: Path) -> None:
    """Write the page of a log, and print the paths of the page and the log; do nothing if the log does not exist.

    If the page cannot be written, print the reason instead of raising an error.
    """
    if not log.is_file():  # the run failed before it began
        return
    try:
        print(f"page       {write_log_page(log)}")
    except SimcoreError as error:
        print(f"simcore: no page: {error}", file=sys.stderr)
    print(f"log        {log}")


def play_aloud(experiment: Experiment, planned: PlannedRun, log: Path) -> dict[str, Any]:
    """Play a run with a log and console output, and return the metrics and the digest of the run.

    A run of a robot project is played in a new process, because a process can run only one robot program.

    Raises:
        SimcoreError: If the run cannot be played or the robot's code fails.
    """
    if experiment.project is None:
        return play_values(experiment.common, planned, log)
    with closing(Crew(is_quiet=False)) as crew:
        row = crew.play(experiment.common, planned, log)
    if row["error"]:
        raise SimcoreError(row["error"])
    return {name: value for name, value in row.items() if name not in (*planned_values(planned), "error")}


@contextmanager
def progress(count: int) -> Iterator[Callable[[dict[str, Any], int], None]]:
    """Show a progress bar on a terminal, and yield the `on_row` function for `sweep` that updates the bar.

    Args:
        count: Number of runs.
    """
    columns = (
        TextColumn("runs"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.description}"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as bar:
        task, failed = bar.add_task("", total=count), 0

        def on_row(row: dict[str, Any], stored: int) -> None:
            nonlocal failed
            failed += bool(row["error"])
            done = bar.tasks[0].completed or stored
            bar.update(task, completed=done + 1, description=f"{failed} failed" if failed else "")

        yield on_row


def _seeds(text: str) -> tuple[int, ...]:
    """Parse seeds on the command line: a count, a range `first:end` without the end, or a list.

    >>> _seeds("3"), _seeds("5:8"), _seeds("1,7")
    ((0, 1, 2), (5, 6, 7), (1, 7))
    """
    try:
        if ":" in text:
            first, last = (int(part) for part in text.split(":"))
            found = range(first, last)
        elif "," in text:
            return tuple(int(part) for part in text.split(","))
        else:
            found = range(int(text))
    except ValueError:
        found = range(0)
    if not 0 < len(found) <= _MOST_SEEDS:
        raise argparse.ArgumentTypeError(
            f"give a number of seeds (1 to {_MOST_SEEDS}), or from:to, or a list such as 1,7,9, got {text!r}"
        )
    return tuple(found)
