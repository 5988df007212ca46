"""Sweeps of a small game, played in this process: rows, their order, and stored rows."""

import random
import sqlite3
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from each_case import each

from simcore.errors import ConfigError, OutputError, UnknownNameError
from simcore.sweep import workers
from simcore.sweep.api import sweep
from simcore.sweep.experiment import Experiment
from simcore.sweep.factors import parse_factor

from .made_sweep import same

FOLDER = str(Path(__file__).parent)
MASS = parse_factor("robot.mass=45,60")


def experiment(**settings):
    return Experiment(game="sweep_game:SMALL", seconds=0.1, **settings)


@pytest.fixture(autouse=True)
def importable(monkeypatch):
    """Make the game importable, as a team's own module is for workers."""
    monkeypatch.syspath_prepend(FOLDER)


def test_a_row_contains_the_plan_and_the_result_of_its_run():
    plan = experiment(factors=(MASS,), seeds=(0, 1, 2), metrics=("score", "distance_m", "sweep_game:ticks"))
    found = sweep(plan, workers=0)
    assert found.columns == (
        *("run", "point", "seed", "robot.mass", "score", "distance_m", "ticks"),
        *("digest", "version", "error", "cpu_seconds"),
    )
    assert [(row["run"], row["seed"], row["ticks"], row["error"]) for row in found.rows] == [
        (number, number // 2, 5, "") for number in range(6)
    ]
    assert len({row["digest"] for row in found.rows}) == 6, "mass and seed both matter"
    assert all(row["cpu_seconds"] > 0.0 for row in found.rows)
    runs = plan.runs()
    random.Random(1).shuffle(runs)
    rows = list(workers.play_all(plan, runs, workers=0))
    assert [row["run"] for row in rows] == [run.number for run in runs] != sorted(row["run"] for row in rows)
    assert same(replace(found, rows=rows)) == same(found), "the order does not matter"


def test_a_resumed_sweep_plays_only_the_missing_runs(tmp_path, monkeypatch):
    played = []
    real = workers.play_run

    def play(common, planned):
        played.append(planned.number)
        if len(played) == 3:
            raise KeyboardInterrupt
        return real(common, planned)

    monkeypatch.setattr(workers, "play_run", play)
    wanted = experiment(factors=(MASS,), seeds=(0, 1))
    with pytest.raises(KeyboardInterrupt):
        sweep(wanted, workers=0, out=tmp_path)
    assert played == [0, 1, 2]
    first = sweep(wanted, workers=0, out=tmp_path)
    assert played == [0, 1, 2, 2, 3]
    assert sweep(wanted, workers=0, out=tmp_path).rows == first.rows and len(played) == 5
    more = sweep(experiment(factors=(parse_factor("robot.mass=45,50,60"),), seeds=(0, 1)), workers=0, out=tmp_path)
    assert [more.rows[number]["robot.mass"] for number in played[5:]] == [50.0, 50.0]
    assert len({row["digest"] for row in more.rows}) == 6


def test_runs_that_failed_are_tried_again(tmp_path):
    wrong = experiment(auto="fail", seeds=(1, 2))
    assert (
        sweep(wrong, workers=0, out=tmp_path)
        .failures[0]["error"]
        .startswith("ZeroDivisionError: in a team's own code (sweep_game.py, line ")
    )
    rows = []
    sweep(wrong, workers=0, out=tmp_path, on_row=lambda row, stored: rows.append((row["seed"], stored)))
    assert rows == [(2, 1)]


def test_a_full_disk_does_not_stop_a_sweep(tmp_path):
    code = """
import resource, signal, sys
from simcore.sweep.api import sweep
from simcore.sweep.experiment import Experiment
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (28_000, 28_000))  # like a disk that is full after this many bytes
wanted = Experiment(game="sweep_game:SMALL", seconds=0.02, seeds=range(40))
print(len(sweep(wanted, workers=0, out=sys.argv[1]).finished))
"""
    run = subprocess.run([sys.executable, "-c", code, str(tmp_path)], capture_output=True, text=True, cwd=FOLDER)
    first, last = (line for line in run.stderr.splitlines() if "runs.sqlite" in line)
    assert run.stdout.strip() == "40", run.stderr
    assert "runs.sqlite cannot be written" in first and first.endswith("the runs go on, and are kept in memory")
    assert last.endswith("runs are not in it")
    kept = sqlite3.connect(tmp_path / "runs.sqlite").execute("SELECT count(*) FROM runs").fetchone()[0]
    assert 0 < kept < 40


def test_a_store_that_cannot_be_used_is_reported(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="cannot be written"):
        sweep(experiment(), workers=0, out=tmp_path / "file")


@each(
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
        ({"blue": "rusher", "factors": (MASS,)}, "neither --red nor --blue has 'me'"),
        ({"blue": "me", "alliance": "red"}, "leave alliance out"),
    ],
)
def test_unplayable_experiments_are_refused_before_the_first_run(settings, said):
    with pytest.raises((ConfigError, UnknownNameError)) as caught:
        sweep(experiment(**settings), workers=0)
    assert said in str(caught.value)


def test_a_negative_number_of_workers_is_refused():
    with pytest.raises(ConfigError, match="workers must be"):
        sweep(experiment(), workers=-5)


def test_a_sweep_of_matches_can_vary_the_players():
    """The first robot is in the alliance with `me`, and has the factors of a robot."""
    players = parse_factor("blue=rusher:1,rusher:3,me+rusher:3")
    plan = replace(experiment(red="rusher", factors=(players,), seeds=(0, 1)), seconds=0.4)
    matches = sweep(plan, workers=0)
    assert matches.failures == []
    slow, fast, mine = ([row for row in matches.rows if row["blue"] == who] for who in players.values)
    least = min(row["distance_m"] for row in fast)
    assert least > 1.5 * max(row["distance_m"] for row in slow) > 0.0, "as fast as the level"
    assert len({row["digest"] for row in mine}) == 2, "its auto draws its volts, players here draw nothing"
    light, heavy = sweep(experiment(red="rusher,me", factors=(MASS,)), workers=0).values("distance_m")
    assert light > 1.1 * heavy > 0.0
