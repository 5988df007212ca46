"""`simcore tune`: the values of a robot with which an auto does best, on common seeds."""

from __future__ import annotations

import argparse
import csv
import io
import math
import shlex
import sys
from pathlib import Path

from simcore.errors import ConfigError
from simcore.match.scatter import Scatter
from simcore.quantities import Quantity, number_flag, text_flag
from simcore.sweep.experiment import Experiment
from simcore.sweep.experiment_options import (
    COUNT_FLAG,
    WORKERS_FLAG,
    add_played_options,
    add_player_options,
    experiment_fields,
)
from simcore.sweep.factors import parse_factor
from simcore.sweep.run_metrics import METRICS
from simcore.sweep.tuning import TunedTrial, Tuning, TuningResult, tune
from simcore.telemetry.sinks import require_writable, write_text

__all__ = ["add_arguments", "run"]

_SEED = number_flag(Quantity("", 0, 2**31, is_whole=True))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    add_player_options(parser)
    parser.add_argument(
        "--set",
        dest="factors",
        action="append",
        required=True,
        type=text_flag(parse_factor),
        metavar="FACTOR=VALUES",
        help="what may change: shooter.exit_efficiency=uniform(0.3,0.5), or a list; may be given again",
    )
    wanted = parser.add_mutually_exclusive_group(required=True)
    for word, end in (("minimize", "least"), ("maximize", "most")):
        wanted.add_argument(
            f"--{word}", metavar="METRIC", help=f"what is to be {end}: a metric such as score, or 'shots - hits'"
        )
    parser.add_argument(
        "--metric", dest="metrics", action="append", default=[], metavar="MODULE:FUNCTION",
        help="measure this, too; its function's name is then a metric",
    )  # fmt: skip
    parser.add_argument("--trials", type=COUNT_FLAG, default=40, metavar="N", help="of the study in all (default: 40)")
    parser.add_argument("--seeds", type=COUNT_FLAG, default=4, metavar="N", help="played in each trial (default: 4)")
    parser.add_argument(
        "--storage", metavar="URL", help="a database that machines share (default: sqlite in the folder of --out)"
    )
    parser.add_argument("--study", metavar="NAME", default="tune", help="name of the study in it (default: tune)")
    parser.add_argument("--sampler-seed", type=_SEED, default=0, metavar="N", help="seed of the trials' draws")
    parser.add_argument(
        "--scatter", type=text_flag(Scatter.parse), default=Scatter(), metavar="SPREADS",
        help="by how much robot, pieces and shots differ from seed to seed: 1 is the default spreads, 0 none",
    )  # fmt: skip
    add_played_options(parser)
    parser.add_argument(
        "-j", "--workers", type=WORKERS_FLAG, default=1, metavar="N",
        help="processes that play the seeds of a trial (default: 1; 0: one for each core)",
    )  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="for the study and its table (default: out/tune)")


def run(options: argparse.Namespace) -> int:
    """Play the trials; 0 if there is a best one, 1 if all have failed, 130 interrupted.

    Raises:
        SimcoreError: What was asked for cannot be.
    """
    out = options.out or Path("out/tune")
    path = require_writable("table", out / "trials.csv")
    experiment = Experiment(
        **experiment_fields(options),
        scatter=options.scatter,
        seeds=tuple(range(options.seeds)),
        metrics=_metrics(options),
    )
    tuning = Tuning(
        experiment=experiment,
        factors=tuple(options.factors),
        metric=options.minimize or options.maximize,
        direction="minimize" if options.minimize else "maximize",
        sampler_seed=options.sampler_seed,
    )
    storage = options.storage or f"sqlite:///{out.resolve() / 'study.db'}"
    try:
        result = tune(
            tuning,
            options.trials,
            storage=storage,
            name=options.study,
            workers=options.workers,
            on_trial=lambda trial: print(f"simcore tune: {_line(tuning, trial)}", file=sys.stderr, flush=True),
        )
    except KeyboardInterrupt:
        print("simcore tune: interrupted; its trials are kept, and the same command goes on with them", file=sys.stderr)
        return 130
    write_text("table", path, _csv(result))
    best = result.best
    if best is None:
        print(f"all {len(result.trials)} trials failed: {result.trials[-1].error}")
        return 1
    as_it_is = f"{result.as_it_is:g}" if math.isfinite(result.as_it_is) else "not known"
    print(f"best of {len(result.trials)} trials: {_line(tuning, best)}; with nothing changed: {as_it_is}")
    print(f"table  {path}")
    words = [f"--set {shlex.quote(f'{name}={value:.6g}' if isinstance(value, float) else f'{name}={value}')}"
             for name, value in best.values.items()]  # fmt: skip
    seeds = f"{options.seeds}:{options.seeds + 50}"
    print(f"how good it is on other seeds: simcore sweep ... --seeds {seeds} {' '.join(words)}")
    return 0


def _metrics(options: argparse.Namespace) -> tuple[str, ...]:
    """Those of the runs: functions of one's own replace the usual ones, so these are named as well."""
    for name in options.metrics:
        if ":" not in name:
            raise ConfigError(f"--metric is for functions, module:function, got {name!r}; the others are there anyway")
    return (*METRICS, *options.metrics) if options.metrics else ()


def _line(tuning: Tuning, trial: TunedTrial) -> str:
    values = ", ".join(
        f"{name} = {value:.5g}" if isinstance(value, float) else f"{name} = {value}"
        for name, value in trial.values.items()
    )
    return f"trial {trial.number}: {tuning.metric} {trial.error or f'{trial.value:g}'} with {values}"


def _csv(result: TuningResult) -> str:
    """A line a trial: number, factors, metric, error."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    names = [factor.name for factor in result.tuning.factors]
    writer.writerow(["trial", *names, result.tuning.metric, "error"])
    for trial in result.trials:
        value = trial.value if math.isfinite(trial.value) else ""
        writer.writerow([trial.number, *(trial.values.get(name, "") for name in names), value, trial.error])
    return stream.getvalue()
