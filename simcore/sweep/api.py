"""The function `sweep`, which plays all runs of an experiment and stores the row of each run when the run ends."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

from simcore.quantities import Quantity, require
from simcore.sweep.experiment import Experiment
from simcore.sweep.one_run import planned_values, require_playable_runs
from simcore.sweep.results import Results
from simcore.sweep.run_store import RunStore
from simcore.sweep.workers import play_all

__all__ = ["sweep"]

_WORKERS = Quantity("", 0, 100_000, is_whole=True)


def sweep(
    experiment: Experiment,
    *,
    workers: int | None = None,
    cluster: str | None = None,
    out: str | Path | None = None,
    on_row: Callable[[dict[str, Any], int], None] | None = None,
) -> Results:
    """Play all runs of an experiment and return the results.

    The row of a run that crashes or takes too long has an error. The function does not play a run again if the store
    already has a successful row of the run, from this experiment or from another experiment with the same run.

    Args:
        experiment: Experiment to play.
        workers: Number of processes on this machine; None for one process per core; 0 to play in this process without
            a time limit. A run of a robot project always plays in a separate process.
        cluster: Address of a Dask scheduler; the workers of the cluster play the runs. None to play on this machine.
        out: Folder for the store of rows, `runs.sqlite`; None to keep rows only in memory.
        on_row: Function to call with each new row and the number of rows from the store; None to call no function.

    Returns:
        Results of the played and the stored runs. The columns of a row are run, point, seed, the factors, the metrics,
        digest, version, error and cpu_seconds.

    Raises:
        SimcoreError: If the experiment cannot be played, or if the cluster has no worker.
    """
    if workers is not None:
        require("sweep", "workers", workers, _WORKERS)
    require_playable_runs(experiment)
    runs = experiment.runs()
    rows: list[dict[str, Any]] = []
    with ExitStack() as stack:
        store, keys, rest = None, [], runs
        if out is not None:
            store, keys = stack.enter_context(closing(RunStore(Path(out)))), experiment.run_keys(runs)
            known = store.rows(keys)
            store.set_experiment(experiment)
            rows = [{**known[key], **planned_values(run)} for run, key in zip(runs, keys, strict=True) if key in known]
            rest = [run for run, key in zip(runs, keys, strict=True) if key not in known]
        stored = len(rows)
        played = play_all(experiment, rest, workers=workers, cluster=cluster)
        for row in stack.enter_context(closing(played)):  # type: ignore[type-var]  # a generator
            rows.append(row)
            if store is not None:
                store.add(keys[row["run"]], row)
            if on_row is not None:
                on_row(row, stored)
    return Results(rows, experiment)
