"""Sweeps of a small game: the same table from everybody who plays it, and nothing that goes wrong stops it."""

from __future__ import annotations

import html
import json
import random
import signal
import sqlite3
import subprocess
import sys
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from time import monotonic, sleep

import numpy as np
import pandas as pd
import psutil
import pytest

from simcore import cli
from simcore.errors import ConfigError, OutputError, SimcoreError, UnknownNameError
from simcore.sweep import one_run
from simcore.sweep.api import sweep
from simcore.sweep.executors import play_all
from simcore.sweep.experiment import Experiment, StopRule
from simcore.sweep.factors import parse_factor
from simcore.sweep.results import Results
from simcore.sweep.run_store import RunStore

FOLDER = str(Path(__file__).parent)
MASS = parse_factor("robot.mass=45,60")


def experiment(**settings):
    return Experiment(game="sweep_game:SMALL", seconds=0.1, **settings)


def same(results):
    """What must be equal to the bit: all but the time that runs cost."""
    return results.table.drop(columns="cpu_seconds")


@pytest.fixture(autouse=True, scope="module")
def importable():
    """Workers find the game as they would a team's own module."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(FOLDER)
        yield


@pytest.fixture(scope="module")
def plain(importable):
    """Six runs in this process."""
    return sweep(experiment(factors=(MASS,), seeds=(0, 1, 2), metrics=("score", "distance_m", "sweep_game:ticks")),
                 executor="process")  # fmt: skip


def test_a_row_says_what_was_played_and_what_came_of_it(plain):
    table = plain.table
    assert list(table.columns) == [
        *("run", "point", "seed", "robot.mass", "score", "distance_m", "ticks"),
        *("digest", "version", "error", "cpu_seconds"),
    ]
    assert table["run"].tolist() == list(range(6)) and table["seed"].tolist() == [0, 0, 1, 1, 2, 2]
    assert set(table["ticks"]) == {5} and set(table["error"]) == {""}
    assert table["digest"].nunique() == 6  # mass and seed both matter
    assert (table["cpu_seconds"] > 0.0).all()


def test_order_does_not_matter(plain):
    runs = plain.experiment.runs()
    random.Random(1).shuffle(runs)
    rows = list(play_all(plain.experiment, runs, executor="process"))
    assert [row["run"] for row in rows] == [planned.number for planned in runs] != sorted(row["run"] for row in rows)
    pd.testing.assert_frame_equal(same(Results(rows, plain.experiment)), same(plain), check_exact=True)


def test_dask_with_two_processes_gives_the_same_table(plain):
    pd.testing.assert_frame_equal(
        same(sweep(plain.experiment, executor="dask", workers=2)), same(plain), check_exact=True
    )


def test_one_and_two_workers_give_the_same_table(plain, whole):
    if not whole:
        pytest.skip("with --whole; Dask and the one worker below are the sample")
    for workers in (1, 2):
        pd.testing.assert_frame_equal(same(sweep(plain.experiment, workers=workers)), same(plain), check_exact=True)


def test_what_goes_wrong_in_a_run_is_in_its_row_alone(plain, tmp_path, monkeypatch, whole):
    """Of one worker that is killed nothing is lost and nothing comes twice, in the store either."""
    monkeypatch.setenv("SWEEP_GAME_MARK", str(tmp_path / "mark"))
    deeds = ("die_once", "fail", "hang", "die") if whole else ("die_once", "fail", "hang")
    wrong = experiment(factors=(parse_factor(f"auto={','.join(deeds)}"),), seeds=(1, 2, 3), timeout=5.0)
    seen = []
    results = sweep(wrong, workers=2 if whole else 1, out=tmp_path, on_row=lambda row, stored: seen.append(row["run"]))
    assert (tmp_path / "mark").exists()
    assert sorted(seen) == results.table["run"].tolist() == list(range(3 * len(deeds)))
    errors = {row["auto"]: row["error"] for row in results.failures}
    assert errors.pop("hang") == "took longer than 5 s of wall time, and was ended"
    assert errors.pop("fail").startswith("ZeroDivisionError: in a team's own code (sweep_game.py, line ")
    assert not whole or errors.pop("die") == "its process died (SIGKILL(-9))"
    assert errors == {}
    assert {row["seed"] for row in results.failures} == {2}
    for seed in (1, 2, 3):  # what drives on drives as everybody
        assert len({row["digest"] for row in results.finished if row["seed"] == seed}) == 1, seed
    rows = sqlite3.connect(tmp_path / "runs.sqlite").execute("SELECT row FROM runs").fetchall()
    assert len(rows) == 3 * len(deeds)


# --- going on -----------------------------------------------------------------------------------------------------


def test_a_sweep_goes_on_where_it_was(tmp_path, monkeypatch):
    played = []
    real = one_run.play_values

    def play(common, planned):
        played.append(planned.number)
        if len(played) == 3:
            raise KeyboardInterrupt
        return real(common, planned)

    monkeypatch.setattr(one_run, "play_values", play)
    wanted = experiment(factors=(MASS,), seeds=(0, 1))
    with pytest.raises(KeyboardInterrupt):
        sweep(wanted, executor="process", out=tmp_path)
    assert played == [0, 1, 2]
    first = sweep(wanted, executor="process", out=tmp_path)
    assert played == [0, 1, 2, 2, 3]
    again = sweep(wanted, executor="process", out=tmp_path)
    assert len(played) == 5 and again.table.equals(first.table)
    more = sweep(experiment(factors=(parse_factor("robot.mass=45,50,60"),), seeds=(0, 1)), executor="process",
                 out=tmp_path)  # fmt: skip
    assert [more.table["robot.mass"][number] for number in played[5:]] == [50.0, 50.0]
    assert more.table["digest"].nunique() == 6


def test_runs_that_failed_are_tried_again(tmp_path):
    wrong = experiment(auto="fail", seeds=(1, 2))
    sweep(wrong, executor="process", out=tmp_path)
    rows = []
    sweep(wrong, executor="process", out=tmp_path, on_row=lambda row, stored: rows.append((row["seed"], stored)))
    assert rows == [(2, 1)]


def test_a_full_disk_stops_nothing(tmp_path):
    code = """
import resource, signal, sys
from simcore.sweep.api import sweep
from simcore.sweep.experiment import Experiment
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (24_000, 24_000))  # as a disk that is full after so many bytes
wanted = Experiment(game="sweep_game:SMALL", seconds=0.02, seeds=range(40))
print(len(sweep(wanted, executor="process", out=sys.argv[1]).finished))
"""
    run = subprocess.run([sys.executable, "-c", code, str(tmp_path)], capture_output=True, text=True, cwd=FOLDER)
    first, last = (line for line in run.stderr.splitlines() if "runs.sqlite" in line)
    assert run.stdout.strip() == "40", run.stderr
    assert "runs.sqlite cannot be written" in first and first.endswith("the runs go on, and are kept in memory")
    assert last.endswith("runs are not in it")
    kept = sqlite3.connect(tmp_path / "runs.sqlite").execute("SELECT count(*) FROM runs").fetchone()[0]
    assert 0 < kept < 40


@pytest.mark.parametrize("more", [0, 1], ids=["as it is closed", "with the next one"])
def test_rows_that_could_not_be_written_are_tried_again(tmp_path, caplog, more):
    """The file may have no page more for a while."""
    with closing(RunStore(tmp_path)) as store:
        ((pages,),) = store._base.execute("PRAGMA page_count").fetchall()
        store._base.execute(f"PRAGMA max_page_count = {pages}")
        store.add("large", {"error": "", "score": "7" * 50_000})
        store.add("small", {"error": ""})
        assert store.rows(["large", "small"]) == {}
        store._base.execute("PRAGMA max_page_count = 1000")
        for number in range(more):
            store.add(f"new {number}", {"error": ""})
            assert set(store.rows(["large", "small", "new 0"])) == {"large", "small", "new 0"}
    assert len(caplog.messages) == 1 and caplog.messages[0].endswith("kept in memory")
    with closing(RunStore(tmp_path)) as store:
        assert set(store.rows(["large", "small"])) == {"large", "small"}


def test_a_store_that_cannot_be_is_said(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="cannot be written"):
        sweep(experiment(), executor="process", out=tmp_path / "file")
    with pytest.raises(OutputError, match="no runs in it"):
        RunStore(tmp_path, must_exist=True)


# --- enough -------------------------------------------------------------------------------------------------------


def test_it_stops_when_the_share_is_known():
    rule = StopRule(condition="distance_m > 0", width=0.25, least=3)
    results = sweep(experiment(factors=(MASS,), seeds=range(50), stop=rule), executor="process")
    # 4 of 4 is known to +-0.245 by Wilson: z^2 / (n + z^2) / 2
    assert results.table["seed"].tolist() == [0, 0, 1, 1, 2, 2, 3, 3]


def test_it_stops_after_too_many_errors_or_too_long():
    results = sweep(experiment(auto="fail", seeds=(1, 2, 3, 4), stop=StopRule(errors=1)), executor="process")
    assert results.table["seed"].tolist() == [1, 2]
    assert len(sweep(experiment(seeds=range(9), stop=StopRule(seconds=1e-9)), executor="process").table) == 0


# --- what cannot be -----------------------------------------------------------------------------------------------


def test_nobody_is_there_to_play():
    with pytest.raises(UnknownNameError, match="Did you mean 'dask'"):
        sweep(experiment(), executor="dusk")
    with pytest.raises(ConfigError, match="workers must be"):
        sweep(experiment(), workers=-5)


def test_a_scheduler_that_is_not_there_is_said(monkeypatch):
    with pytest.raises(ConfigError, match="answers at file:///etc/passwd"):
        sweep(experiment(), executor="dask", scheduler="file:///etc/passwd")
    monkeypatch.setattr("simcore.sweep.executors._CONNECT", 1.0)
    with pytest.raises(ConfigError, match=r"answers at tcp://127\.0\.0\.1:9"):
        sweep(experiment(), executor="dask", scheduler="tcp://127.0.0.1:9")


def test_a_lost_scheduler_ends_the_sweep_with_a_sentence_and_its_rows_are_kept(tmp_path):
    code = """
import distributed, sys
cluster = distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=False, protocol="tcp://",
                                   host="127.0.0.1", dashboard_address=None)
print(cluster.scheduler_address, flush=True)
sys.stdin.read()
"""
    with subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=FOLDER
    ) as process:
        address = process.stdout.readline().strip()
        rows = []

        def end(row, stored):
            rows.append(row["run"])
            process.kill()

        with pytest.raises(SimcoreError, match="scheduler is lost; runs that were stored are kept"):
            sweep(experiment(seeds=range(200)), executor="dask", scheduler=address, out=tmp_path, on_row=end)
    assert 0 < len(rows) < 200
    kept = sqlite3.connect(tmp_path / "runs.sqlite").execute("SELECT count(*) FROM runs").fetchone()[0]
    assert kept == len(rows)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"auto": "dive"}, "Did you mean 'drive'"),
        ({"factors": (parse_factor("robot.mas=3"),)}, "Did you mean 'mass'"),
        ({"factors": (parse_factor("robot.mass=60,-3"),)}, "got -3.0"),
        ({"robot": "nowhere.toml"}, "there is no file"),
        ({"options": ("fast",)}, "no option of small named 'fast'"),
        ({"project": FOLDER}, "no robot.py"),
        ({"project": FOLDER, "red": "me"}, "match = '...'"),
        ({"red": "rushr"}, "Did you mean 'rusher'"),
        ({"blue": "rusher", "factors": (parse_factor("red=rusher,rusher:9"),)}, "factor 'red'"),
        ({"blue": "rusher", "factors": (MASS,)}, "none of --red and --blue is 'me'"),
        ({"blue": "me", "alliance": "red"}, "leave alliance out"),
    ],
)
def test_what_no_run_can_be_is_said_before_the_first(settings, said):
    with pytest.raises((ConfigError, UnknownNameError)) as caught:
        sweep(experiment(**settings), executor="process")
    assert said in str(caught.value)


def test_matches_are_swept_over_who_plays_them():
    """The first robot is the alliance's of `me`, and has the factors of a robot."""
    players = parse_factor("blue=rusher:1,rusher:3,me+rusher:3")
    plan = replace(experiment(red="rusher", factors=(players,), seeds=(0, 1)), seconds=0.4)
    matches = sweep(plan, executor="process").table
    assert list(matches["error"]) == [""] * 6
    slow, fast, mine = (matches[matches["blue"] == who] for who in players.values)
    assert fast["distance_m"].min() > 1.5 * slow["distance_m"].max() > 0.0, "as fast as the level"
    assert mine["digest"].nunique() == 2, "its auto draws its volts, players here draw nothing"
    heavier = sweep(experiment(red="rusher,me", factors=(MASS,)), executor="process").table
    assert heavier["distance_m"].iloc[0] > 1.1 * heavier["distance_m"].iloc[1] > 0.0


@pytest.mark.skipif(sys.platform != "linux", reason="looks for children as Linux has them")
def test_kills_leave_no_process_and_lose_and_double_no_row(tmp_path, whole):
    """Twelve times the sweep or one of its workers is ended, somewhere; each time it is started again and goes on."""
    seeds, store, rng = 400, tmp_path / "runs.sqlite", np.random.default_rng(6)
    words = ["sweep", "sweep_game:SMALL", "--seconds", "0.1", "--seeds", str(seeds), "-j", "2", "--out", str(tmp_path)]
    command = [sys.executable, "-c", "import sys; from simcore import cli; sys.exit(cli.main(sys.argv[1:]))", *words]
    ends = {signal.SIGKILL: -signal.SIGKILL, signal.SIGTERM: 130, signal.SIGINT: 130}
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


# --- the command --------------------------------------------------------------------------------------------------


def test_the_command_says_what_failed_and_plays_it_again(tmp_path, capsys, monkeypatch):
    def play_here(experiment, runs, *_):
        return (one_run.play_run(experiment.common, planned) for planned in runs)

    monkeypatch.setattr("simcore.sweep.executors._play", play_here)
    out = str(tmp_path / "two words")
    words = ["sweep", "sweep_game:SMALL", "--seconds", "0.1", "--out", out]
    assert cli.main([*words, "--auto", "fail", "--seeds", "1:3", "--success", "distance_m > 0"]) == 1
    said = capsys.readouterr().out
    assert "1 of 2 = 50 %" in said and "ZeroDivisionError: in a team's own code" in said
    assert f"run 1 alone: simcore sweep --out '{out}' --repeat 1" in said
    assert cli.main(["sweep", "--out", out, "--repeat", "1"]) == 1
    assert "ZeroDivisionError" in capsys.readouterr().err
    assert cli.main(["sweep", "--out", out, "--repeat", "0"]) == 0
    table = pd.read_csv(Path(out, "results.csv"))
    assert table["digest"].dropna().item() in capsys.readouterr().out
    assert {f"run_0.{kind}" for kind in ("wpilog", "html", "png")} <= {path.name for path in Path(out).iterdir()}
    assert f"simcore sweep --out '{out}' --repeat RUN" in html.unescape(Path(out, "page.html").read_text("utf-8"))
    assert cli.main([*words, "--success", "scor > 0"]) == 1
    assert "Did you mean 'score'" in capsys.readouterr().err
    assert cli.main([*words, "--success", "score"]) == 1  # and not after all runs
    assert "'score' is no condition" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        cli.main([*words, "--seed", "7"])
    assert "unrecognized arguments: --seed" in capsys.readouterr().err
