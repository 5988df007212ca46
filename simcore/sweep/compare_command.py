"""`simcore compare OLD NEW`: two versions of robot code, two autos or two sweeps on common seeds."""

from __future__ import annotations

import argparse
import math
from collections import Counter
from contextlib import closing
from dataclasses import dataclass, replace
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
from simcore.sweep.run_store import FILE_NAME, RunStore
from simcore.sweep.sweep_command import (
    ProgressReport,
    add_played_options,
    chosen_scatter,
    experiment_fields,
    play_aloud,
    scatter_option,
    sigterm_as_interrupt,
)
from simcore.sweep.sweep_page import comparison_page, save_page, scene_of_results
from simcore.sweep.sweep_statistics import PairedDifference

__all__ = ["add_arguments", "run"]

_RESULTS = "results"


@dataclass(frozen=True, slots=True)
class _Side:
    """Meaning of one of the two words."""

    kind: str
    """`project`, `auto` or `results`: the name of the factor whose value it is."""
    value: str


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options of the command."""
    parser.allow_abbrev = False
    for name in ("old", "new"):
        parser.add_argument(name, help="a folder with a robot.py, an auto of the game, or the --out of a sweep")
    parser.add_argument("--game", metavar="GAME", help="which game (default: the newest that is installed)")
    parser.add_argument("--auto", metavar="NAME", help="which auto (default: what the chooser has)")
    parser.add_argument("--metric", default="score", metavar="NAME", help="what is compared (default: score)")
    parser.add_argument(
        "--seeds",
        type=number_flag(Quantity("", 2, 1_000_000, is_whole=True)),
        default=20,
        metavar="N",
        help="so many seeds of each (default: 20)",
    )
    scatter_option(parser)
    add_played_options(parser)
    parser.add_argument("--out", type=Path, default=Path("out/compare"), metavar="FOLDER", help="default: out/compare")
    parser.set_defaults(robot=None, project=None)


def run(options: argparse.Namespace) -> int:
    """Compare, and print what came of it; returns 0 if all runs are there, 1 if some have failed.

    Raises:
        SimcoreError: What was asked for cannot be.
    """
    words = (options.old, options.new)
    sides = [_side(word, options) for word in words]
    kind = sides[0].kind
    if kind != sides[1].kind:
        raise ConfigError(f"{words[0]!r} is of the kind {kind}, {words[1]!r} {sides[1].kind}; give two alike")
    if sides[0] == sides[1] or words[0] == words[1]:
        raise ConfigError(f"{words[0]!r} and {words[1]!r} are the same")
    if kind == _RESULTS:
        results = _stored(sides, words)
    elif options.metric in METRICS or options.metric.startswith("breakdown."):
        results = _played(sides, options)
    else:
        raise UnknownNameError("metric", options.metric, METRICS)
    errors = Counter(row["error"] for row in results.failures)
    if errors and not results.finished:
        raise ConfigError(f"all {len(results.rows)} runs ended with an error: {errors.most_common(1)[0][0]}")
    first, *rest = results.experiment.factors
    difference = results.paired(first.name, first.values[0], first.values[1], options.metric)
    print(f"{options.metric}, {options.new} less {options.old}: {difference}")
    if difference.is_clear:
        print("A clear difference.")
    else:
        more = "" if kind == _RESULTS else f" --seeds {2 * options.seeds} goes on from here."
        print(f"No clear difference: it may be anywhere in this interval.{more}")
    for failure, count in errors.most_common(5):
        print(f"{count} runs ended with an error: {failure}")
    names = dict(zip(first.values, words, strict=True))  # as the user has called them
    named = Results(
        [{**row, first.name: names[row[first.name]]} for row in results.rows],
        replace(results.experiment, factors=(Factor(first.name, words), *rest)),
    )
    scene = scene_of_results(results)
    print(save_page(comparison_page(named, options.metric, difference, options.out, scene), options.out))
    if kind != _RESULTS:
        print(_page_of_both(results, options, difference))
    return 1 if results.failures else 0


# --- what the words mean ------------------------------------------------------------------------------------------


def _side(word: str, options: argparse.Namespace) -> _Side:
    folder = Path(word)
    if (folder / "robot.py").is_file():
        return _Side(PROJECT, str(folder))
    if (folder / FILE_NAME).is_file():
        return _Side(_RESULTS, str(folder))
    if not Path("robot.py").is_file() and word in game_of(options.game).autos:
        return _Side("auto", word)
    raise ConfigError(
        f"{word!r} is neither a folder with a robot.py or {FILE_NAME} in it, nor an auto of the game; "
        "`git worktree add FOLDER COMMIT` makes a folder of an older version"
    )


# --- the runs -----------------------------------------------------------------------------------------------------


def _played(sides: list[_Side], options: argparse.Namespace) -> Results:
    """Play both on one seed after the other."""
    kind, values = sides[0].kind, tuple(side.value for side in sides)
    if kind == PROJECT:
        options.project = Path(values[0])
    experiment = Experiment(
        **experiment_fields(options),
        scatter=chosen_scatter(options),
        factors=(Factor(kind, values),),
        seeds=tuple(range(options.seeds)),
    )
    progress = ProgressReport(experiment.count)
    with progress, sigterm_as_interrupt():
        return sweep(experiment, workers=options.workers or None, out=options.out, on_row=progress.add)


def _stored(sides: list[_Side], words: tuple[str, str]) -> Results:
    """Read two sweeps as one, with the sweep as a factor."""
    rows, found = [], []
    for side, word in zip(sides, words, strict=True):
        with closing(RunStore(Path(side.value), must_exist=True)) as store:
            found.append(store.results())
        rows += [{**row, _RESULTS: word} for row in found[-1].rows]
    first, second = (set(results.factors) for results in found)
    if first != second:
        raise ConfigError(f"the sweeps vary different factors, {sorted(first)} and {sorted(second)}")
    experiment = found[0].experiment
    numbered = [{**row, "run": number} for number, row in enumerate(rows)]
    return Results(numbered, replace(experiment, factors=(Factor(_RESULTS, words), *experiment.factors)))


def _page_of_both(results: Results, options: argparse.Namespace, difference: PairedDifference) -> Path:
    """Play the seed that shows the difference most again, with a log each, and write the page of both."""
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
    says = [f"{options.metric} of {', '.join(says)}; {difference}", f"pieces that lie are those of {options.old}"]
    write_page_of_two(page, *logs, names=(options.old, options.new), title=title, subtitle="\n".join(says))
    return page
