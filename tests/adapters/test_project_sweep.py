"""A robot project's own code in a sweep: seeds, scatter and factors reach its match, and a seed repeats its run."""

from __future__ import annotations

from pathlib import Path

import pytest

from simcore.match.scatter import Scatter
from simcore.sweep.api import sweep
from simcore.sweep.experiment import Experiment, PlannedRun
from simcore.sweep.factors import parse_factor
from simcore.sweep.one_run import play_run

pytest.importorskip("pyfrc", reason="robot projects need the extra robotpy")
pytest.importorskip("phoenix6", reason="this example's motors are CTRE's")

PROJECT = str(Path(__file__).resolve().parents[2] / "examples" / "rebuilt_robot")
pytestmark = pytest.mark.slow


def check_match(run):
    """A metric that looks at what the project's own physics.py has built."""
    match = run.match
    return [match.seed, match.scatter.spin, match.robots[0].config.body.mass, match.pieces.types[0].mass]


def test_what_a_sweep_varies_reaches_the_match_of_a_project(monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    experiment = Experiment(
        project=PROJECT, auto="depot", seconds=0.1, metrics=("score", "test_project_sweep:check_match")
    )
    values = {"robot.mass": 48.0, "scatter.spin": 0.25, "pieces.fuel.mass": 0.22}
    row = play_run(experiment, PlannedRun(0, 0, 7, values))
    assert row["error"] == ""
    assert row["check_match"] == "[7, 0.25, 48.0, 0.22]"
    assert row["robot.mass"] == 48.0 and row["score"] == 0 and len(row["digest"]) == 64


def test_a_seed_of_a_project_has_one_digest(whole, tmp_path):
    if not whole:
        pytest.skip("with --whole: 20 seeds, each twice")
    experiment = Experiment(
        project=PROJECT, auto="depot", scatter=Scatter(), factors=(parse_factor("robot.mass=55"),), seeds=range(20)
    )
    first, second = (sweep(experiment, out=tmp_path / name).table for name in ("first", "second"))
    assert set(first["error"]) == {""}
    assert first["digest"].tolist() == second["digest"].tolist()
    assert first["digest"].nunique() == 20
