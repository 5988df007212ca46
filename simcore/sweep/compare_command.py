"""`simcore compare OLD NEW`: two versions of robot code, two autos or two sweeps on common seeds."""

from __future__ import annotations

import argparse
import io
import math
import subprocess
import tarfile
from collections import Counter
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from simcore.errors import ConfigError, OutputError, UnknownNameError
from simcore.quantities import Quantity, number_flag
from simcore.show.two_runs import write_page_of_two
from simcore.sweep.api import sweep
from simcore.sweep.experiment import Experiment, StopRule
from simcore.sweep.factors import PROJECT, Factor
from simcore.sweep.one_run import game_of, play_values
from simcore.sweep.results import ColumnExpression, Results, read_rows
from simcore.sweep.results_page import save_results
from simcore.sweep.run_metrics import METRICS
from simcore.sweep.run_store import FILE_NAME, RunStore
from simcore.sweep.sweep_command import (
    ProgressReport,
    add_played_options,
    chosen_scatter,
    experiment_fields,
    scatter_option,
    sigterm_as_interrupt,
)
from simcore.sweep.sweep_statistics import PairedDifference, paired_difference, sequential_difference

__all__ = ["add_arguments", "compare", "run"]

_LEAST = 10
"""Seeds before a difference may be clear: see `sequential_difference`."""
_RESULTS = "results"


@dataclass(frozen=True, slots=True)
class _Side:
    """What one of the two words means."""

    kind: str
    """`project`, `auto` or `results`: the name of the factor whose value it is."""
    value: str


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.allow_abbrev = False
    for name in ("old", "new"):
        parser.add_argument(
            name, help="a folder with a robot.py, a git branch or commit of this one, an auto, or the --out of a sweep"
        )
    parser.add_argument("--game", metavar="GAME", help="which game (default: the newest that is installed)")
    parser.add_argument("--auto", metavar="NAME", help="which auto (default: what the chooser has)")
    parser.add_argument("--metric", default="score", metavar="NAME", help="what is compared (default: score)")
    parser.add_argument(
        "--seeds",
        type=number_flag(Quantity("", 2, 1_000_000, is_whole=True)),
        default=50,
        metavar="N",
        help="stop undecided after so many (default: 50)",
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
    sides = [_side(word, options) for word in (options.old, options.new)]
    if sides[0].kind != sides[1].kind:
        raise ConfigError(
            f"{options.old!r} is of the kind {sides[0].kind}, {options.new!r} {sides[1].kind}; want two alike"
        )
    if sides[0] == sides[1] or options.old == options.new:
        raise ConfigError(f"{options.old!r} and {options.new!r} are the same")
    took = ""
    for name in ColumnExpression(options.metric).names if sides[0].kind != _RESULTS else ():
        if name not in METRICS and not name.startswith("breakdown."):
            raise UnknownNameError("metric", name, METRICS)
    if sides[0].kind == _RESULTS:
        results, judge = _stored(sides, (options.old, options.new)), paired_difference
    else:
        results, took = _played(sides, options)
        judge = sequential_difference
    difference = compare(results, options.metric, judge)
    print(f"{options.metric}, {options.new} less {options.old}: {difference}")
    if difference.is_clear:
        print(f"A clear difference.{took}")
    else:
        more = f" --seeds {2 * options.seeds} goes on from here." if took else ""
        print(f"No clear difference: it may be anywhere in this interval.{took}{more}")
    for failure, count in Counter(row["error"] for row in results.failures).most_common(5):
        print(f"{count} runs ended with an error: {failure}")
    named = _named(results, sides, (options.old, options.new))
    print(save_results(named, options.out, compared=difference)["page.html"])
    if sides[0].kind != _RESULTS:
        print(_page_of_both(results, options, difference))
    return 1 if results.failures else 0


def compare(results: Results, metric: str, judge: Callable[..., PairedDifference]) -> PairedDifference:
    """What the second value of the first factor changes against its first one.

    Raises:
        ConfigError: There are not two common seeds in which both came to an end.
        UnknownNameError: There is no such metric.
    """
    factor = results.experiment.factors[0]
    first, second = factor.values
    return results.paired(factor.name, first, second, metric, judge=judge)


# --- what the words mean ------------------------------------------------------------------------------------------


def _side(word: str, options: argparse.Namespace) -> _Side:
    folder = Path(word)
    if (folder / "robot.py").is_file():
        return _Side(PROJECT, str(folder))
    if (folder / FILE_NAME).is_file():
        return _Side(_RESULTS, str(folder))
    if not Path("robot.py").is_file() and word in game_of(options.game).autos:
        return _Side("auto", word)
    commit = _git("rev-parse", "--verify", "--quiet", "--end-of-options", f"{word}^{{commit}}").decode().strip()
    if commit:
        return _Side(PROJECT, str(_checked_out(commit, options.out / "versions" / commit[:12])))
    raise ConfigError(
        f"{word!r} is neither a folder with a robot.py or {FILE_NAME} in it, nor a commit of the git "
        "repository here, nor an auto of the game"
    )


def _git(*words: str) -> bytes:
    """What git answers; nothing where it cannot."""
    try:
        return subprocess.run(["git", *words], capture_output=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return b""


_SAFELY: dict[str, Any] = {"filter": "data"} if hasattr(tarfile, "data_filter") else {}
"""Of `extractall`: nothing outside of the folder; before Python 3.10.12 and 3.11.4 it cannot be asked for."""


def _checked_out(commit: str, folder: Path) -> Path:
    """The working folder as it was in a commit, in a folder of its own.

    Raises:
        OutputError: It cannot be written.
        ConfigError: There was no robot.py in it.
    """
    if not (folder / "robot.py").is_file():
        packed = _git("archive", "--format=tar", commit, ".")  # of this folder, whatever the repository has beside it
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if packed:
                with tarfile.open(fileobj=io.BytesIO(packed)) as tar:
                    tar.extractall(folder, **_SAFELY)
        except OSError as error:
            raise OutputError(f"cannot write {commit[:12]} to {str(folder)!r}: {error.strerror or error}") from error
    if not (folder / "robot.py").is_file():
        raise ConfigError(f"{commit[:12]} has no robot.py in this folder")
    return folder


# --- the runs -----------------------------------------------------------------------------------------------------


def _played(sides: list[_Side], options: argparse.Namespace) -> tuple[Results, str]:
    """Both on one seed after the other, until their difference is clear; and how long that took, in words."""
    kind, values = sides[0].kind, tuple(side.value for side in sides)
    if kind == PROJECT:
        options.project = Path(values[0])
    experiment = Experiment(
        **experiment_fields(options),
        scatter=chosen_scatter(options),
        factors=(Factor(kind, values),),
        seeds=tuple(range(options.seeds)),
        stop=StopRule(difference=options.metric, least=min(_LEAST, options.seeds)),
    )
    progress = ProgressReport(experiment.count)
    with progress, sigterm_as_interrupt():
        results = sweep(experiment, workers=options.workers, out=options.out, on_row=progress.add)
    seeds = len({row["seed"] for row in results.rows})
    return results, f" {seeds} seeds, {progress.minutes:.1f} min."


def _stored(sides: list[_Side], words: tuple[str, str]) -> Results:
    """The tables of two sweeps as one, with the sweep as a factor."""
    rows, experiments = [], []
    for side, word in zip(sides, words, strict=True):
        with closing(RunStore(Path(side.value), must_exist=True)) as store:
            experiments.append(store.experiment())
        rows += [{**row, _RESULTS: word} for row in read_rows(side.value)]
    first, second = ({factor.name for factor in experiment.factors} for experiment in experiments)
    if first != second:
        raise ConfigError(f"the sweeps vary different factors, {sorted(first)} and {sorted(second)}")
    factors = (Factor(_RESULTS, words), *experiments[0].factors)
    numbered = [{**row, "run": number} for number, row in enumerate(rows)]
    return Results(numbered, replace(experiments[0], factors=factors, stop=StopRule()))


def _named(results: Results, sides: list[_Side], words: tuple[str, str]) -> Results:
    """The same with what the user has called them in place of folders."""
    first, *rest = results.experiment.factors
    names = dict(zip(first.values, words, strict=True))
    rows = [{**row, first.name: names[row[first.name]]} for row in results.rows]
    return Results(rows, replace(results.experiment, factors=(Factor(first.name, words), *rest)))


def _page_of_both(results: Results, options: argparse.Namespace, difference: PairedDifference) -> Path:
    """The page of the seed that shows the difference most, played again with a log each."""
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
        play_values(results.experiment.common, one, log)
    page: Path = options.out / "both.html"
    says = [f"{word}: {by[seed]:g}" for word, by in zip((options.old, options.new), by_seed, strict=True)]
    title = f"{options.old} and {options.new}, seed {seed}"
    says = [f"{options.metric} of {', '.join(says)}; {difference}", f"pieces that lie are those of {options.old}"]
    write_page_of_two(page, *logs, names=(options.old, options.new), title=title, subtitle="\n".join(says))
    return page
