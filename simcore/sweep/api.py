"""`sweep`: play an experiment and get its table."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from simcore.errors import VendorError
from simcore.install_text import install_command
from simcore.sweep.experiment import Experiment
from simcore.sweep.one_run import play_run, require_playable_runs

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["rows_table", "sweep_table"]

_HEAD, _TAIL = ("run", "point", "seed"), ("digest", "version", "error", "cpu_seconds")


def sweep_table(experiment: Experiment) -> pd.DataFrame:
    """Play all runs in this process.

    Returns:
        A row a run, by number: run, point, seed, factors, metrics, digest, version, error, cpu_seconds.

    Raises:
        SimcoreError: What was asked for cannot be played.
    """
    require_playable_runs(experiment)
    common = experiment.common
    return rows_table(experiment, [play_run(common, planned) for planned in experiment.runs()])


def rows_table(experiment: Experiment, rows: Iterable[Mapping[str, Any]]) -> pd.DataFrame:
    """The table of rows in any order.

    Raises:
        VendorError: pandas is not installed.
    """
    try:
        import pandas as pd
    except ImportError as error:
        raise VendorError(f"a sweep's table needs pandas: {install_command('sweep')}") from error
    ordered = sorted(rows, key=lambda row: row["run"])
    factors = [factor.name for factor in experiment.factors]
    metrics: dict[str, None] = {}
    for row in ordered:
        metrics.update(dict.fromkeys(name for name in row if name not in (*_HEAD, *factors, *_TAIL)))
    table = pd.DataFrame(ordered, columns=[*_HEAD, *factors, *metrics, *_TAIL])
    for name in metrics:  # what could not be measured is NaN
        if all(value is None or isinstance(value, (int, float)) for value in table[name]):
            table[name] = pd.to_numeric(table[name])
    return table
