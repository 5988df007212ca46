"""Command `simcore compare OLD NEW`, which compares two versions of robot code, or two autos, with the same seeds."""

from __future__ import annotations

import argparse
import math
from collections import Counter
from pathlib import Path

from simcore.errors import ConfigError, UnknownNameError
from simcore.quantities import Quantity, number_flag
from simcore.show.two_runs import write_page_of_two
from simcore.sweep.api import sweep
from simcore.sweep.experiment import Experiment
from simcore.sweep.factors import PROJECT, Factor
from simcore.sweep.one_run import game_of
from simcore.sweep.results import Results
from simcore.sweep.run_metrics import METRICS
from simcore.sweep.sweep_command import (
    PAGE_NAME,
    add_played_options,
    chosen_scatter,
    experiment_fields,
    play_aloud,
    progress,
    scatter_option,
    sigterm_as_interrupt,
)
from simcore.sweep.sweep_page import comparison_page
from simcore.sweep.sweep_statistics import PairedDifference
from simcore.telemetry.sinks import write_text

__all__ = ["add_arguments", "run"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments and options of `simcore compare`."""
    parser.allow_abbrev = False
    parser.add_argument("old", help="a folder with a robot.py, or an auto of the game")
    parser.add_argument("new", nargs="?", help="another folder or auto to compare with it")
    parser.add_argument("--game", metavar="GAME", help="game (default: the newest installed one)")
    parser.add_argument("--auto", metavar="NAME", help="auto (default: the chooser's)")
    parser.add_argument("--metric", default="score", metavar="NAME", help="metric to compare (default: score)")
    parser.add_argument(
        "--seeds",
        type=number_flag(Quantity("", 2, 1_000_000, is_whole=True)),
        default=20,
        metavar="N",
        help="number of seeds of each (default: 20)",
    )
    scatter_option(parser)
    add_played_options(parser)
    parser.add_argument("--out", type=Path, default=Path("out/compare"), metavar="FOLDER", help="default: out/compare")
    parser.set_defaults(robot=None, project=None)


def run(options: argparse.Namespace) -> int:
    """Compare two versions, print the difference, and write a page of the statistics and a page of two logs.

    Returns:
        Exit status: 0 if no run ended with an error, otherwise 1.

    Raises:
        SimcoreError: If the versions cannot be compared.
    """
    if options.new is None:
        raise ConfigError(
            f"{options.old!r} with what? Give two folders with a robot.py, or two autos of the game: "
            f"simcore compare {options.old} OTHER"
        )
    words = (options.old, options.new)
    kinds = [_kind(word, options) for word in words]
    if kinds[0] != kinds[1]:
        raise ConfigError(f"{words[0]!r} is of kind {kinds[0]}, {words[1]!r} of kind {kinds[1]}; give two of one kind")
    if words[0] == words[1] or (kinds[0] == PROJECT and Path(words[0]).resolve() == Path(words[1]).resolve()):
        raise ConfigError(f"{words[0]!r} and {words[1]!r} are the same")
    if options.metric not in METRICS and not options.metric.startswith("breakdown."):
        raise UnknownNameError("metric", options.metric, METRICS)
    results = _played(Factor(kinds[0], words), options)
    errors = Counter(row["error"] for row in results.failures)
    if errors and not results.finished:
        raise ConfigError(f"all {len(results.rows)} runs ended with an error: {errors.most_common(1)[0][0]}")
    difference = results.paired(kinds[0], *words, options.metric)
    print(f"{options.metric}, {options.new} minus {options.old}: {difference}")
    if difference.is_clear:
        print("A clear difference.")
    else:
        more = f"--seeds {2 * options.seeds} goes on from here."
        print(f"No clear difference: it may be anywhere in this interval. {more}")
    for failure, count in errors.most_common(5):
        print(f"{count} runs ended with an error: {failure}")
    page = options.out / PAGE_NAME
    write_text("page", page, comparison_page(results, options.metric, difference, options.out))
    print(page)
    print(_page_of_both(results, options, difference))
    return 1 if results.failures else 0


# --- kinds of arguments -------------------------------------------------------------------------------------------


def _kind(word: str, options: argparse.Namespace) -> str:
    """Return the name of the factor for an argument: `project` for a folder with a robot.py, `auto` for an auto.

    Inside a robot project, the argument must be a folder.

    Raises:
        ConfigError: If the argument is neither a folder with a robot.py nor, outside a robot project, an auto of the
            game.
    """
    if Path(word, "robot.py").is_file():
        return PROJECT
    near = ""
    if not Path("robot.py").is_file():
        autos = game_of(options.game).autos
        if word in autos:
            return "auto"
        near = f" ({', '.join(autos)})"
    raise ConfigError(
        f"{word!r} is neither a folder with a robot.py in it, nor an auto of the game{near}; "
        "`git worktree add FOLDER COMMIT` makes a folder of an older version"
    )


# --- runs ---------------------------------------------------------------------------------------------------------


def _played(factor: Factor, options: argparse.Namespace) -> Results:
    """Play both values of the factor with each seed, show the progress, and return the results."""
    if factor.name == PROJECT:
        options.project = Path(options.old)
    experiment = Experiment(
        **experiment_fields(options),
        scatter=chosen_scatter(options),
        factors=(factor,),
        seeds=tuple(range(options.seeds)),
    )
    with progress(experiment.count) as on_row, sigterm_as_interrupt():
        return sweep(experiment, workers=options.workers or None, out=options.out, on_row=on_row)


def _page_of_both(results: Results, options: argparse.Namespace, difference: PairedDifference) -> Path:
    """Write a page of two logs, one of each version, and return the path of the page.

    The function plays both versions again with one seed: that of the largest difference with the sign of the mean
    difference.
    """
    factor = results.experiment.factors[0]
    by_seed: list[dict[int, float]] = [{}, {}]
    for row, number in zip(results.finished, results.values(options.metric).tolist(), strict=True):
        if math.isfinite(number):
            by_seed[factor.values.index(row[factor.name])][row["seed"]] = number
    common = sorted(by_seed[0].keys() & by_seed[1].keys())
    sign = 1.0 if difference.mean >= 0.0 else -1.0
    seed = max(common, key=lambda seed: sign * (by_seed[1][seed] - by_seed[0][seed]))
    logs = [options.out / f"{name}.wpilog" for name in ("old", "new")]
    planned = [run for run in results.experiment.runs() if run.seed == seed]
    for one, log in zip(planned, logs, strict=True):
        play_aloud(results.experiment, one, log)
    page: Path = options.out / "both.html"
    says = [f"{word}: {by[seed]:g}" for word, by in zip((options.old, options.new), by_seed, strict=True)]
    title = f"{options.old} and {options.new}, seed {seed}"
    says = [f"{options.metric} of {', '.join(says)}; {difference}", f"pieces at rest are those of {options.old}"]
    write_page_of_two(page, *logs, names=(options.old, options.new), title=title, subtitle="\n".join(says))
    return page
