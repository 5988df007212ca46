"""An experiment plans its runs and names their results."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from each_case import each

from simcore.errors import SimcoreError
from simcore.match.scatter import Scatter
from simcore.sweep.code_version import project_digest
from simcore.sweep.experiment import Experiment, programs_outside
from simcore.sweep.factors import parse_factor
from simcore.world.engine_choice import choose_engine

MASS, CHARGE = parse_factor("robot.mass=45,60"), parse_factor("robot.battery.initial_charge=0.3,0.6,1")
DRAWN = parse_factor("robot.mass=normal(55,1)")


def own_metric(run):
    return 1


def test_a_grid_combines_all_values_and_plays_the_first_seed_first():
    runs = Experiment(factors=(MASS, CHARGE), seeds=(4, 9)).runs()
    assert [run.number for run in runs] == list(range(12))
    assert [run.seed for run in runs] == [4] * 6 + [9] * 6
    assert [tuple(run.values.values()) for run in runs[:3]] == [(45.0, 0.3), (45.0, 0.6), (45.0, 1.0)]
    assert [run.point for run in runs[6:]] == list(range(6))


def test_random_points_are_reproducible():
    experiment = Experiment(factors=(DRAWN, CHARGE), samples=8)
    points = experiment.design_points()
    assert len(points) == 8 == experiment.count == len(experiment.runs())
    assert points == experiment.design_points() and len({mass for mass, _ in points}) == 8
    assert {charge for _, charge in points} <= {0.3, 0.6, 1.0}
    assert all(45.0 < mass < 65.0 for mass, _ in points)


def test_an_experiment_read_back_from_json_is_equal():
    experiment = Experiment(
        auto="depot",
        factors=(DRAWN, CHARGE),
        samples=4,
        seeds=range(3),
        scatter=Scatter().scaled(0.5),
        metrics=("score", "hits"),
        timeout=9.0,
    )
    again = Experiment.from_json(json.loads(json.dumps(experiment.to_json())))
    assert again == experiment and again.run_keys(again.runs()) == experiment.run_keys(experiment.runs())


def test_a_run_has_the_same_key_in_a_larger_experiment():
    few = Experiment(factors=(MASS,), seeds=(0, 1))
    more = Experiment(factors=(parse_factor("robot.mass=45,50,60"),), seeds=(0, 1, 2), timeout=9.0)
    assert set(few.run_keys(few.runs())) < set(more.run_keys(more.runs()))
    for changed in ({"auto": "tour"}, {"scatter": Scatter()}, {"seconds": 3.0}, {"metrics": ("score",)}):
        other = replace(few, **changed)
        assert not set(few.run_keys(few.runs())) & set(other.run_keys(other.runs()))
    named = replace(few, engine=choose_engine(None))
    assert named.run_keys(named.runs()) == few.run_keys(few.runs()), "whether or not the engine is named"


def test_the_key_of_a_run_changes_with_the_mesh_or_the_engine_package(tmp_path, monkeypatch):
    (tmp_path / "meshed_game.py").write_text("""
from dataclasses import replace
from pathlib import Path
from pathlib import Path
from simcore.match.registry import find_game

GAME = find_game("rebuilt", say=str)
GAME = replace(GAME, field=replace(GAME.field, mesh=Path(__file__).parent / "field.obj"))
""")
    mesh = tmp_path / "field.obj"
    mesh.write_text("v 0 0 0\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    wanted = Experiment(game="meshed_game:GAME", seeds=(3,))
    (first,) = wanted.run_keys(wanted.runs())
    assert wanted.run_keys(wanted.runs()) == [first]
    mesh.write_text("v 0 0 0\nv 1 0 0\n")
    (second,) = wanted.run_keys(wanted.runs())
    monkeypatch.setattr("simcore.sweep.experiment._version", lambda module: f"{module} 99")
    (third,) = wanted.run_keys(wanted.runs())
    assert len({first, second, third}) == 3


def test_the_key_of_a_run_changes_with_the_code_of_its_project(tmp_path):
    robot = tmp_path / "robot.py"
    robot.write_text("speed = 1\n")
    before = project_digest(tmp_path)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "log.json").write_text("{}")
    assert project_digest(tmp_path) == before
    robot.write_text("speed = 2\n")
    assert project_digest(tmp_path) != before


@each(
    ("settings", "said"),
    [
        ({"factors": (DRAWN,)}, "say how many samples"),
        ({"samples": 3}, "got 3 samples and no factor"),
        ({"factors": (MASS, MASS)}, "must differ"),
        ({"seeds": ()}, "at least one"),
        ({"seeds": (1, 1)}, "different"),
        ({"seeds": (-1,)}, "whole number from 0"),
        ({"seconds": -1.0}, "seconds must be"),
        ({"alliance": "green"}, "'blue' or 'red'"),
        ({"metrics": ("scor",)}, "Did you mean 'score'"),
        ({"metrics": (lambda run: 1,)}, "at the top of a module"),
        ({"metrics": ("nowhere:hits",)}, "cannot be found"),
        ({"robot": "a:b", "project": "."}, "a robot or a project"),
        ({"factors": (parse_factor("a=0:90000:1"), parse_factor("b=0:90000:1"))}, "too many"),
    ],
)
def test_invalid_experiments_are_refused_at_once(settings, said):
    with pytest.raises(SimcoreError, match=r"(?s).*") as caught:
        Experiment(**settings)
    assert said in str(caught.value)


def test_a_metric_function_is_stored_as_its_module_and_name():
    assert Experiment(metrics=(own_metric,)).metrics == (f"{__name__}:own_metric",)


def test_programs_outside_a_folder_are_found_without_importing_them(tmp_path, monkeypatch):
    for name in ("inside", "outside"):
        (tmp_path / name).mkdir()
        (tmp_path / name / f"{name}_code.py").write_text("raise SystemExit\n")
        monkeypatch.syspath_prepend(str(tmp_path / name))
    here, there = str(tmp_path / "inside" / "robot"), str(tmp_path / "outside" / "robot")
    told = {
        "project": here, "factors": [{"name": "project", "values": [here, there]}], "game": "rebuilt",
        "robot": "outside_code:robot", "metrics": ["score", "inside_code:a", "outside_code:b"],
    }  # fmt: skip
    wanted = [str(Path(there, "robot.py")), str(tmp_path / "outside" / "outside_code.py")]
    assert programs_outside(told, tmp_path / "inside") == wanted
    assert programs_outside(told, tmp_path) == []
