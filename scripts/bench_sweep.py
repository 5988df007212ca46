"""What a sweep costs beside its matches, and what two processes gain: `python scripts/bench_sweep.py [RUNS]`."""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

from simcore.match.registry import find_game
from simcore.match.runner import play_auto
from simcore.match.scatter import Scatter
from simcore.sweep.api import sweep
from simcore.sweep.experiment import Experiment
from simcore.sweep.one_run import play_run
from simcore.sweep.run_store import RunStore

_PAIRS = 4  # of a bare match and the same one in a sweep
_TINY = 10_000
_PARTS = 4  # of the runs of the throughput, so that both numbers of processes see the same machine
_LEAST = 8  # runs of a part


def measure_sweep(runs: int, *, auto: str = "neutral", seconds: float | None = None) -> dict[str, Any]:
    """Figures of a sweep over seeds.

    Each is on stderr as soon as it is measured.

    Args:
        runs: How many, for the throughput of two processes.
        auto: Which.
        seconds: Of each, simulated [s]; None: the whole auto.
    """
    experiment = Experiment(auto=auto, seconds=seconds, scatter=Scatter(), seeds=tuple(range(runs)))
    figures: dict[str, Any] = {"auto": auto}
    for name, measure in (
        ("tiny_tasks_on_dask", _tiny_tasks),
        ("overhead", partial(_overhead, experiment)),
        ("throughput", partial(_throughput, experiment)),
    ):
        figures[name] = measure()
        print(f"{name}: {figures[name]}", file=sys.stderr, flush=True)
    return figures


def _overhead(experiment: Experiment) -> dict[str, Any]:
    """CPU time of runs of a sweep over that of the same bare matches, in turn, so that both see the same machine."""
    game = find_game(experiment.game, say=str)
    planned = experiment.runs()[:_PAIRS]
    keys = experiment.run_keys(planned)
    play_auto(game, experiment.auto, seconds=0.1).match.close()  # what is loaded once
    bare = swept = 0.0
    row: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        store = RunStore(Path(folder))
        for one, key in zip(planned, keys, strict=True):
            start = process_time()
            play_auto(
                game, experiment.auto, seed=one.seed, seconds=experiment.seconds, scatter=experiment.scatter
            ).match.close()
            middle = process_time()
            row = play_run(experiment.common, one)
            store.add(key, row)
            bare += middle - start
            swept += process_time() - middle
        store.close()
        size = store.path.stat().st_size
    return {
        "cpu_seconds_per_match": round(bare / len(planned), 3),
        "cpu_seconds_per_run": round(swept / len(planned), 3),
        "overhead_percent": round(100.0 * (swept / bare - 1.0), 2),
        "bytes_per_row": len(json.dumps(row)),
        "bytes_of_store": size,
    }


def _throughput(experiment: Experiment) -> dict[str, Any]:
    """What a second process gains: parts of the runs are played in turn by one process and by two.

    The rate counts from the row with which all workers have shown that they are there; before it they start.
    Where the gain is less than 2, `cpu_seconds_per_run` tells whether cores slow each other down, and `busy_percent`
    whether workers have waited.
    """
    parts = max(1, min(_PARTS, experiment.count // _LEAST))
    wall, cpu, busy, start = {1: 0.0, 2: 0.0}, {1: 0.0, 2: 0.0}, {1: 0.0, 2: 0.0}, {1: 0.0, 2: 0.0}
    for part in range(parts):
        some = replace(experiment, seeds=experiment.seeds[part::parts])
        digests = []
        for workers in wall:
            times = [perf_counter()]
            results = sweep(
                some,
                workers=workers,
                executor="process" if workers == 1 else "joblib",
                on_row=lambda row, stored, times=times: times.append(perf_counter()),
            )
            rest = some.count - workers
            seconds_a_row = (times[-1] - times[workers]) / rest
            wall[workers] += seconds_a_row / parts
            start[workers] += (times[workers] - times[0] - workers * seconds_a_row) / parts
            seconds = float(results.table["cpu_seconds"].mean())
            cpu[workers] += seconds / parts
            busy[workers] += 100.0 * seconds / (workers * seconds_a_row) / parts
            digests.append(results.table["digest"].tolist())
        assert digests[0] == digests[1], "two processes gave another table"
    return {
        "runs": experiment.count,
        "runs_per_minute": {str(workers): round(60.0 / seconds, 2) for workers, seconds in wall.items()},
        "speedup_of_two": round(wall[1] / wall[2], 2),
        "start_seconds": {str(workers): round(seconds, 2) for workers, seconds in start.items()},
        "cpu_seconds_per_run": {str(workers): round(seconds, 3) for workers, seconds in cpu.items()},
        "busy_percent": {str(workers): round(share, 1) for workers, share in busy.items()},
    }


def _tiny_tasks() -> dict[str, Any]:
    """What Dask's client and scheduler, in this process, cost for each of many tasks that do nothing."""
    import distributed

    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1"
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        cpu, wall = process_time(), perf_counter()
        futures = client.map(_nothing, range(_TINY), pure=False)
        count = len(client.gather(futures))
        return {
            "tasks": count,
            "cpu_ms_per_task": round(1e3 * (process_time() - cpu) / count, 3),
            "tasks_per_second": round(count / (perf_counter() - wall)),
        }


def _nothing(number: int) -> int:
    return number


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", type=int, nargs="?", default=200, help="for the throughput (default: 200)")
    parser.add_argument("--auto", default="neutral", help="of the newest game (default: neutral)")
    parser.add_argument("--seconds", type=float, help="of each run (default: the whole auto)")
    options = parser.parse_args()
    if options.runs < _LEAST:
        parser.error(f"want {_LEAST} runs or more, got {options.runs}")
    print(json.dumps(measure_sweep(options.runs, auto=options.auto, seconds=options.seconds), indent=2))
