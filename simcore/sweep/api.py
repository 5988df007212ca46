"""`sweep`: play an experiment, keep its rows as they come, and get its results."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing, suppress
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np

from simcore.errors import ConfigError
from simcore.sweep.executors import play_all
from simcore.sweep.experiment import Experiment, PlannedRun
from simcore.sweep.one_run import planned_values, require_playable_runs
from simcore.sweep.results import Results
from simcore.sweep.run_store import RunStore
from simcore.sweep.sweep_statistics import sequential_difference, wilson_share

__all__ = ["sweep"]


def sweep(
    experiment: Experiment,
    *,
    workers: int = -1,
    executor: str = "joblib",
    scheduler: str | None = None,
    out: str | Path | None = None,
    on_row: Callable[[dict[str, Any], int], None] | None = None,
) -> Results:
    """Play all runs of an experiment.

    A run that crashes or takes too long is a row with an error. Runs that are in the store already, of this experiment
    or of another one that they belong to as well, are not played again, but for those that failed.

    Args:
        experiment: What is played.
        workers: Processes on this machine; 0 or -1: one for each core.
        executor: `process` (this one), `joblib` (all cores) or `dask` (a cluster).
        scheduler: Address of a Dask scheduler; None: with `dask`, a cluster on this machine.
        out: Folder for the store of rows, `runs.sqlite`; None: they are kept in memory only.
        on_row: Called with each row that is there, and with how many were taken from the store.

    Returns:
        Their rows, by number: run, point, seed, factors, metrics, digest, version, error, cpu_seconds.

    Raises:
        SimcoreError: What was asked for cannot be played, or nobody is there to play it.
    """
    require_playable_runs(experiment)
    runs = experiment.runs()
    keys = experiment.run_keys(runs)
    store = None if out is None else RunStore(Path(out))
    rounds = _Rounds(experiment, runs)
    end = None if experiment.stop.seconds is None else monotonic() + experiment.stop.seconds
    try:
        if store is not None:
            known = store.rows(keys)
            store.set_experiment(experiment)
            for planned, key in zip(runs, keys, strict=True):
                if key in known:
                    rounds.add({**known[key], **planned_values(planned)})
        stored = len(rounds.rows)
        rest = [planned for planned in runs if planned.number not in rounds.rows]
        played = play_all(experiment, rest, executor=executor, workers=workers, scheduler=scheduler)
        with closing(played):  # type: ignore[type-var]  # a generator
            while not rounds.is_over and (end is None or monotonic() < end):
                row = next(played, None)
                if row is None:
                    break
                rounds.add(row)
                if store is not None:
                    store.add(keys[row["run"]], row)
                if on_row is not None:
                    on_row(row, stored)
    finally:
        if store is not None:
            store.close()
    return Results(rounds.counted, experiment)


class _Rounds:
    """The rows so far, and whether the stop rule is met.

    A round is one seed at every point. The rule is asked of whole rounds in their order, so that what counts does not
    depend on which run was done first.
    """

    def __init__(self, experiment: Experiment, runs: list[PlannedRun]) -> None:
        self.rows: dict[int, dict[str, Any]] = {}
        """By number of the run."""
        self._experiment = experiment
        self._points = 1 + max(planned.point for planned in runs)
        self._count = len(runs)
        self._whole = 0
        self._failed = 0
        self._last: int | None = None

    def add(self, row: dict[str, Any]) -> None:
        """One more row."""
        self.rows[row["run"]] = row
        while self._last is None and (self._whole + 1) * self._points <= self._count:
            numbers = range(self._whole * self._points, (self._whole + 1) * self._points)
            if not all(number in self.rows for number in numbers):
                return
            self._whole += 1
            self._failed += len([number for number in numbers if self.rows[number]["error"]])
            if self._is_met():
                self._last = self._whole

    @property
    def is_over(self) -> bool:
        """Whether no further run is needed."""
        return self._last is not None or len(self.rows) == self._count

    @property
    def counted(self) -> list[dict[str, Any]]:
        """The rows up to the round in which the rule was met."""
        end = self._count if self._last is None else self._last * self._points
        return [row for number, row in self.rows.items() if number < end]

    def _is_met(self) -> bool:
        """Whether the rule is met by the whole rounds so far."""
        rule, whole = self._experiment.stop, self._whole
        if rule.errors is not None and self._failed >= rule.errors:
            return True
        step = 10 ** max(0, len(str(whole)) - 2)  # of many rounds some ninety in each power of ten are asked
        if not (rule.condition or rule.difference) or whole < rule.least or whole % step:
            return False
        results = Results([self.rows[number] for number in range(whole * self._points)], self._experiment)
        if rule.difference:
            with suppress(ConfigError):  # there are not two seeds yet in which both came to an end
                factor = self._experiment.factors[0]
                first, second = factor.values[:2]
                judged = results.paired(factor.name, first, second, rule.difference, judge=sequential_difference)
                return judged.is_clear
            return False
        by_point = results.succeeded(rule.condition).reshape(whole, self._points)  # rows are in the order of runs
        shares = (wilson_share(int(np.sum(held)), whole) for held in by_point.T)
        return all(0.5 * (share.upper - share.lower) <= rule.width for share in shares)
