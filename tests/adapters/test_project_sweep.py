"""Sweep of a robot project: seeds, scatter and factors reach its match, and a seed repeats its run."""

from __future__ import annotations

import json
import math
import shutil
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from page_reader import PageReader

from simcore import cli
from simcore.match.scatter import Scatter, ScatterDraws, start_error
from simcore.sweep.api import sweep
from simcore.sweep.experiment import Experiment, PlannedRun
from simcore.sweep.factors import parse_factor
from simcore.sweep.run_store import RunStore
from simcore.sweep.workers import Crew

pytest.importorskip("pyfrc", reason="robot projects need the extra robotpy")
pytest.importorskip("phoenix6", reason="this example's motors are CTRE's")

PROJECT = str(Path(__file__).resolve().parents[2] / "examples" / "rebuilt_robot")
START = (2.6, 5.3, -0.5)
"""Start in the project's constants.py [m, m, rad]."""
pytestmark = pytest.mark.slow


def check_match(match):
    """Return values of the match that the project's physics.py has built, as a metric."""
    robot = match.robots[0]
    return [match.seed, match.scatter.spin, robot.config.body.mass, match.pieces.types[0].mass, *robot.chassis.pose]


def test_sweep_factors_change_the_match_of_a_project(monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    experiment = Experiment(
        project=PROJECT, auto="depot", seconds=0.02, metrics=("score", "test_project_sweep:check_match")
    )
    spreads = {"scatter.spin": 0.25, "scatter.start_position": 0.05, "scatter.start_heading": 0.1}
    values = {"robot.mass": 48.0, **spreads, "pieces.Fuel.mass": 0.22}
    with closing(Crew()) as crew:
        row = crew.play(experiment, PlannedRun(0, 0, 7, values))
    assert row["error"] == ""
    *built, x_true, y_true, heading_true = json.loads(row["check_match"])
    assert built == [7, 0.25, 48.0, 0.22]
    # people miss the start of the auto, which its first loop writes to odometry, by an error from the seed
    x, y, heading = START
    scatter = replace(Scatter.none(), start_position=0.05, start_heading=0.1)
    ahead, left, turn = start_error(ScatterDraws(scatter, 7), 0)
    missed_x = x + ahead * math.cos(heading) - left * math.sin(heading)
    missed_y = y + ahead * math.sin(heading) + left * math.cos(heading)
    assert math.hypot(ahead, left) > 0.01
    assert (x_true, y_true, heading_true) == pytest.approx((missed_x, missed_y, heading + turn), abs=1e-3)
    assert row["robot.mass"] == 48.0 and row["score"] == 0 and len(row["digest"]) == 64


def test_equal_seeds_of_a_project_give_equal_digests(whole, tmp_path):
    if not whole:
        pytest.skip("with --whole: 20 seeds, each twice")
    experiment = Experiment(
        project=PROJECT, auto="depot", scatter=Scatter(), factors=(parse_factor("robot.mass=55"),), seeds=range(20)
    )
    first, second = (sweep(experiment, out=tmp_path / name) for name in ("first", "second"))
    assert first.failures == []
    digests = [row["digest"] for row in first.rows]
    assert digests == [row["digest"] for row in second.rows] and len(set(digests)) == 20


def test_two_versions_of_a_project_are_compared_and_shown_on_one_page(tmp_path, monkeypatch, capsys):
    """The new version backs up slowly; two seeds leave the difference uncertain, though both have the same sign."""
    monkeypatch.chdir(tmp_path)
    for name in ("old", "new"):
        shutil.copytree(PROJECT, name, ignore=shutil.ignore_patterns("tests", "test_output", "out", "__pycache__"))
    container = Path("new", "robotcontainer.py")
    container.write_text(
        container.read_text().replace("to(x + 1.4, y, 0.0, 3.0, 2.5)", "to(x + 1.4, y, 0.0, 0.3, 2.5)")
    )
    words = ["--auto", "depot", "--seconds", "4", "--seeds", "2", "--metric", "distance_m", "-j", "2"]
    assert cli.main(["compare", "old", "new", *words]) == 0
    said = capsys.readouterr().out
    assert said.startswith("distance_m, new minus old: ") and "2 seeds: 0 more, 2 less" in said, said
    page = PageReader(Path("out/compare/both.html"))
    assert page.meta["title"].startswith("old and new, seed") and [r["name"] for r in page.meta["robots"]] == [
        "old",
        "new",
    ]
    (row,) = sweep(Experiment(project="old", auto="depot", seconds=4.0, scatter=Scatter())).rows
    with closing(RunStore(Path("out/compare"), must_exist=True)) as store:
        compared = store.experiment()
        rows = store.rows(compared.run_keys(compared.runs())).values()
    (same,) = (r for r in rows if r["seed"] == 0 and r["project"] == "old")
    assert same["digest"] == row["digest"], "the run as it is alone"
