"""Worker processes: all kinds of workers return equal rows, and no fault loses or repeats a row."""

import json
import os
import signal
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path
from time import monotonic, sleep

import numpy as np
import psutil
import pytest

from simcore.errors import ConfigError, SimcoreError
from simcore.sweep.api import sweep
from simcore.sweep.experiment import Experiment
from simcore.sweep.factors import parse_factor
from simcore.sweep.workers import Crew

from .made_sweep import same

FOLDER = str(Path(__file__).parent)
CLUSTER = """
import distributed, sys
if __name__ == "__main__":
    cluster = distributed.LocalCluster(n_workers={workers}, threads_per_worker=1, processes={processes},
                                       protocol="tcp://", host="127.0.0.1", dashboard_address=None)
    print(cluster.scheduler_address, flush=True)
    sys.stdin.read()
"""


def experiment(**settings):
    return Experiment(game="sweep_game:SMALL", seconds=0.1, **settings)


@pytest.fixture(autouse=True)
def importable(monkeypatch):
    """Make the game importable, as a team's own module is for workers."""
    monkeypatch.syspath_prepend(FOLDER)


@pytest.fixture
def cluster(request, tmp_path):
    """Start a Dask cluster with a number of worker processes; with 0, a worker is in the scheduler's process."""
    code = tmp_path / "cluster.py"
    code.write_text(CLUSTER.format(workers=max(1, request.param), processes=bool(request.param)))
    with subprocess.Popen(
        [sys.executable, str(code)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        env={**os.environ, "PYTHONPATH": FOLDER},
    ) as process:  # fmt: skip
        yield process, process.stdout.readline().strip()
        process.kill()


@pytest.mark.parametrize("cluster", [2], indirect=True)
def test_all_kinds_of_workers_return_equal_rows(cluster, whole):
    plan = experiment(factors=(parse_factor("robot.mass=45,60"),), seeds=(0, 1), metrics=("score", "distance_m"))
    plain = same(sweep(plan, workers=0))
    assert same(sweep(plan, cluster=cluster[1])) == plain
    for workers in (1, 2) if whole else (2,):
        assert same(sweep(plan, workers=workers)) == plain


def test_the_error_of_a_run_is_only_in_its_own_row(tmp_path, monkeypatch):
    """If a process is killed, no row is lost and no row comes twice, even in the store."""
    monkeypatch.setenv("SWEEP_GAME_MARK", str(tmp_path / "mark"))
    deeds = ("die_once", "fail", "hang", "die", "leave")
    wrong = experiment(factors=(parse_factor(f"auto={','.join(deeds)}"),), seeds=(1, 2, 3), timeout=6.0)
    seen = []
    results = sweep(wrong, workers=2, out=tmp_path, on_row=lambda row, stored: seen.append(row["run"]))
    assert (tmp_path / "mark").exists()
    assert sorted(seen) == [row["run"] for row in results.rows] == list(range(3 * len(deeds)))
    errors = {row["auto"]: row["error"] for row in results.failures}
    assert errors.pop("hang") == "took longer than 6 s of wall time, and was stopped"
    assert errors.pop("fail").startswith("ZeroDivisionError: in a team's own code (sweep_game.py, line ")
    assert errors.pop("die") == "its process died (SIGKILL(-9)); its last output: so much for that"
    assert errors.pop("leave").startswith("SystemExit: 3 (sweep_game.py, line ")
    assert errors == {} and {row["seed"] for row in results.failures} == {2}
    for seed in (1, 2, 3):  # autos that drive give the same digest
        assert len({row["digest"] for row in results.finished if row["seed"] == seed}) == 1, seed
    assert stored_runs(tmp_path / "runs.sqlite") == 3 * len(deeds)


def test_a_crew_keeps_its_process_until_it_is_closed():
    plan = experiment(seeds=(0, 1, 2), metrics=("sweep_game:process",))
    with closing(Crew()) as crew:
        first, second, _ = (crew.play(plan.common, run)["process"] for run in plan.runs())
        assert first == second and psutil.pid_exists(int(first))
    assert not psutil.pid_exists(int(first))
    with pytest.raises(SimcoreError, match="is over"):
        crew.play(plan.common, plan.runs()[0])


def test_a_missing_scheduler_is_reported(monkeypatch):
    monkeypatch.setattr("simcore.sweep.workers._CONNECT", 1.0)
    for address in ("file:///etc/passwd", "tcp://127.0.0.1:9"):
        with pytest.raises(ConfigError, match=f"answers at {address}"):
            sweep(experiment(), cluster=address)


@pytest.mark.parametrize("cluster", [0], indirect=True)
def test_a_lost_scheduler_ends_the_sweep_with_an_error_and_keeps_its_rows(cluster, tmp_path):
    process, address = cluster
    rows = []

    def end(row, stored):
        rows.append(row["run"])
        process.kill()

    with pytest.raises(SimcoreError, match="scheduler is lost; runs that were stored are kept"):
        sweep(experiment(seeds=range(200)), cluster=address, out=tmp_path, on_row=end)
    assert 0 < len(rows) < 200 and stored_runs(tmp_path / "runs.sqlite") == len(rows)


@pytest.mark.skipif(sys.platform != "linux", reason="looks for children as Linux has them")
def test_killed_sweeps_leave_no_process_and_lose_or_repeat_no_row(tmp_path, whole):
    """The sweep or one of its workers is killed at some time; each time it is started again and continues."""
    seeds, store, rng = 600, tmp_path / "runs.sqlite", np.random.default_rng(6)
    words = ["sweep", "sweep_game:SMALL", "--seconds", "0.1", "--seeds", str(seeds), "-j", "2", "--out", str(tmp_path)]
    command = [sys.executable, "-c", "import sys; from simcore import cli; sys.exit(cli.main(sys.argv[1:]))", *words]
    ends = {signal.SIGKILL: -signal.SIGKILL, signal.SIGTERM: 130, signal.SIGINT: 130, signal.SIGHUP: -signal.SIGHUP}
    deeds = [*ends, "worker"] * 3 if whole else [signal.SIGKILL, "worker"]
    kept = 0
    for deed in deeds:
        process = subprocess.Popen(command, cwd=FOLDER, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        end = monotonic() + 120.0
        while stored_runs(store) <= kept:
            assert process.poll() is None and monotonic() < end
            sleep(0.05)
        sleep(rng.uniform(0.0, 0.3))
        children = psutil.Process(process.pid).children(recursive=True)
        assert len(children) >= 2
        if deed == "worker":
            max(children, key=lambda child: child.cpu_times().user).kill()
            sleep(0.5)
            assert process.poll() is None, "the others go on"
            process.send_signal(signal.SIGTERM)
        else:
            process.send_signal(deed)
        assert process.wait(30.0) == ends.get(deed, 130)
        assert psutil.wait_procs(children, timeout=5.0)[1] == []
        before, kept = kept, stored_runs(store)
        assert before < kept < seeds
    if whole:
        assert subprocess.run(command, cwd=FOLDER, capture_output=True, check=False).returncode == 0
        assert stored_runs(store) == seeds
    rows = [json.loads(row) for (row,) in sqlite3.connect(store).execute("SELECT row FROM runs")]
    assert len({row["run"] for row in rows}) == len(rows) and all(row["digest"] for row in rows)


def stored_runs(store):
    try:
        return sqlite3.connect(store).execute("SELECT count(*) FROM runs").fetchone()[0]
    except sqlite3.OperationalError:  # not made yet
        return 0
