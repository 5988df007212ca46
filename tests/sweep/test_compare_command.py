"""Comparison of two versions on common seeds: its arguments, and a page with both versions."""

from functools import partial
from pathlib import Path

import pytest
from made_up_run import SCENE, SHOTS, recorded
from page_reader import PageReader

from simcore import cli
from simcore.show.shots import shots_of
from simcore.show.two_runs import merged
from simcore.sweep import one_run
from simcore.sweep.api import sweep
from simcore.sweep.experiment import Experiment
from simcore.sweep.factors import Factor

from .made_sweep import blocks_of

SMALL = ["--game", "sweep_game:SMALL", "--seconds", "0.1"]


def sweep_here(real, experiment, *, workers, **rest):
    return real(experiment, workers=0, **rest)


@pytest.fixture(autouse=True)
def here(monkeypatch, tmp_path):
    """Play runs in this process, in a folder of the test."""
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("simcore.sweep.compare_command.sweep", partial(sweep_here, sweep))


# --- arguments --------------------------------------------------------------------------------------------------------


def test_two_autos_of_a_game_are_compared_on_a_common_page(capsys):
    """`fail` raises an error with seed 2 and is `drive` otherwise: two pairs show no clear difference."""
    assert cli.main(["compare", "drive", "fail", *SMALL, "--metric", "distance_m", "--seeds", "3"]) == 1
    said = capsys.readouterr().out
    difference = "+0 (95 % interval +0 to +0), 2 seeds: 0 more, 0 less, 2 equal"
    assert said.startswith(f"distance_m, fail minus drive: {difference}")
    assert "No clear difference" in said and "--seeds 6 goes on from here" in said
    assert "1 runs ended with an error: ZeroDivisionError" in said
    both = PageReader(Path("out/compare/both.html"))
    names = [one["name"] for one in both.meta["robots"]]
    assert both.meta["title"] == "drive and fail, seed 0" and names == ["drive", "fail"]
    assert len({one["ink"] for one in both.meta["robots"]}) == 2 and "score blue" not in both.facts
    assert {"score drive", "score fail", "driven, drive", "driven, fail"} <= set(both.facts)
    assert difference in both.meta["notes"][0]
    page = Path("out/compare/page.html").read_text(encoding="utf-8")
    head, *blocks = blocks_of(page)
    assert "<h1>drive against fail</h1>" in page and head["text"] == "No clear difference: distance_m +0"
    assert head["detail"] == f"distance_m, fail minus drive: {difference}", "the console's own"
    charts = [block for block in blocks if block["kind"] == "chart"]
    assert charts
    for one in charts:
        assert [curve["name"] for curve in one["series"]] == ["drive", "fail"], "both on one axis"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["drive", "fail", "--metric", "scores"], "no metric named 'scores'. Did you mean 'score'"),
        (["drive", "drive"], "are the same"),
        (["drive", "HEAD"], "`git worktree add FOLDER COMMIT` makes a folder of an older version"),
        (["drive", "robot"], "'drive' is of kind auto, 'robot' of kind project"),
        (["drive", "fail", "--red", "rusher"], "neither --red nor --blue has 'me'"),
    ],
)
def test_incomparable_arguments_are_refused_before_the_first_run(capsys, words, said):
    Path("robot").mkdir()
    Path("robot", "robot.py").touch()
    assert cli.main(["compare", *words, *SMALL]) == 1
    assert said in capsys.readouterr().err
    assert not Path("out").exists()


def test_the_error_of_the_runs_is_reported_if_all_runs_fail(capsys, monkeypatch):
    monkeypatch.setattr(one_run, "measure", lambda *_: 1 / 0)
    assert cli.main(["compare", "drive", "fail", *SMALL, "--seeds", "2"]) == 1
    assert "all 4 runs ended with an error: ZeroDivisionError" in capsys.readouterr().err


def test_the_rows_of_a_project_are_identified_by_its_content():
    for name, text in (("a", "1"), ("b", "2"), ("c", "1")):
        Path(name).mkdir()
        Path(name, "robot.py").write_text(text)

    def keys(*folders: str) -> list[str]:
        experiment = Experiment(project=folders[0], factors=(Factor("project", folders),))
        return experiment.run_keys(experiment.runs())

    assert keys("a", "b") == keys("c", "b") and len(set(keys("a", "b"))) == 2
    assert set(keys("b", "a")) == set(keys("a", "b")), "wherever it is, and in whatever order"


# --- a page with both -------------------------------------------------------------------------------------------------


def test_a_merged_recording_contains_both_runs():
    old, new = recorded(50), recorded(30)
    both = merged(old, new)
    assert both.times == pytest.approx(old.times), "as long as the longer one"
    assert both.poses("Sim/Robots/1/Robot/Pose3d")[1][:30] == pytest.approx(new.poses("Sim/Robot/Pose3d")[1])
    assert both.series("Sim/Score/Old")[1][-1] == 4 and both.series("Sim/Score/New")[1][-1] == 2
    assert not both.has("Sim/Score/Blue")
    shots = shots_of(both, SCENE)
    assert [shot.robot for shot in shots] == [0, 1, 0, 1]
    assert [shot.scored for shot in shots[::2]] == [hit for _, _, hit in SHOTS.values()]
    for robot, run in enumerate((old, new)):
        alone, here = shots_of(run, SCENE), [shot for shot in shots if shot.robot == robot]
        assert [shot.time for shot in here] == pytest.approx([shot.time for shot in alone])
        assert here[0].points == pytest.approx(alone[0].points)
    assert [shot.piece for shot in shots] == [2000, 102000, 2001, 102001]
