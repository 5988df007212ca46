"""Two versions on common seeds: what the words mean, when it stops, and one page with both."""

from __future__ import annotations

import math
import shutil
import subprocess
from html import escape
from pathlib import Path

import numpy as np
import pytest
from made_up_run import SCENE, SHOTS, recorded
from page_reader import PageReader

from simcore import cli
from simcore.show.shots import shots_of
from simcore.show.two_runs import merged
from simcore.sweep import one_run
from simcore.sweep.api import sweep
from simcore.sweep.experiment import Experiment, StopRule
from simcore.sweep.factors import Factor
from simcore.sweep.results_page import save_results
from simcore.sweep.sweep_statistics import paired_difference, sequential_difference

SMALL = ["--game", "sweep_game:SMALL", "--seconds", "0.1"]


@pytest.fixture(autouse=True)
def here(monkeypatch, tmp_path):
    """Runs are played in this process, in a folder of its own."""
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        "simcore.sweep.executors._play",
        lambda experiment, runs, *_: (one_run.play_run(experiment.common, planned) for planned in runs),
    )


# --- the rule -----------------------------------------------------------------------------------------------------


def test_whoever_looks_after_every_seed_is_rarely_wrong():
    """Without an effect 5 % at most, whatever the scale; Student's interval, looked at as often, is wrong much more."""
    rng = np.random.default_rng(4)
    wrong = {sequential_difference: 0, paired_difference: 0}
    for scale in rng.uniform(0.01, 100.0, 200):
        rows = scale * rng.normal(size=30)
        for judge in wrong:
            wrong[judge] += any(judge(np.zeros(n), rows[:n]).is_clear for n in range(3, 31))
    assert wrong[sequential_difference] <= 0.05 * 200 < 0.15 * 200 < wrong[paired_difference]


def test_interval_and_p_value_say_the_same():
    """0 is left out exactly where p is below 5 %; the interval moves and grows with the differences."""
    rng = np.random.default_rng(5)
    for n in range(2, 40):
        rows = rng.normal(rng.uniform(0.0, 1.0), 1.0, n)
        found = sequential_difference(np.zeros(n), rows)
        assert found.is_clear == (found.p_value < 0.05)
        moved = sequential_difference(np.zeros(n), 3.0 * rows + 7.0)
        assert (moved.lower, moved.upper) == pytest.approx((3.0 * found.lower + 7.0, 3.0 * found.upper + 7.0))
        student = paired_difference(np.zeros(n), rows)
        assert found.lower < student.lower and found.upper > student.upper


def test_p_follows_the_closed_form():
    """n = 4, nu = 3, g = 5, t^2 = 12: e = (5 / 1.8)^2 / sqrt 5 = 3.45."""
    rows = np.array([1.0, 1.0, 3.0, 3.0])  # mean 2, deviation 2 / sqrt 3, t = 2 sqrt 3
    assert sequential_difference(np.zeros(4), rows).p_value == pytest.approx(math.sqrt(5.0) / (5.0 / 1.8) ** 2)


def test_a_comparison_stops_when_the_difference_is_clear():
    """A sure difference, the same in all seeds, is clear with the fifth; none at all never is."""
    long = Factor("seconds", (0.06, 0.1))
    base = {"game": "sweep_game:SMALL", "factors": (long,), "seeds": range(20, 32)}
    for metric, runs in (("seconds", 10), ("score", 24)):
        rule = StopRule(difference=metric, least=2)
        results = sweep(Experiment(**base, stop=rule, metrics=("seconds", "score")), executor="process")
        assert len(results.rows) == runs
    assert Experiment.from_json(results.experiment.to_json()) == results.experiment


# --- what the words mean ------------------------------------------------------------------------------------------


def test_two_autos_of_a_game_and_a_page_with_both(capsys):
    """`fail` raises with seed 2, and is `drive` otherwise: of two pairs nothing is clear."""
    assert cli.main(["compare", "drive", "fail", *SMALL, "--metric", "distance_m", "--seeds", "3"]) == 1
    said = capsys.readouterr().out
    assert said.startswith(
        "distance_m, fail less drive: +0 (95 % interval -inf to +inf), 2 seeds: 0 more, 0 less, 2 equal"
    )
    assert "No clear difference" in said and "--seeds 6 goes on from here" in said
    assert "1 runs ended with an error: ZeroDivisionError" in said
    both = PageReader(Path("out/compare/both.html"))
    assert both.meta["title"] == "drive and fail, seed 0" and [one["name"] for one in both.meta["robots"]] == [
        "drive",
        "fail",
    ]
    assert len({one["ink"] for one in both.meta["robots"]}) == 2 and "score blue" not in both.facts
    assert {"score drive", "score fail", "driven, drive", "driven, fail"} <= set(both.facts)
    difference = said.partition(": ")[2].partition("\n")[0]
    assert difference in both.meta["notes"][0]
    page = Path("out/compare/page.html").read_text(encoding="utf-8")
    assert "<h1>drive against fail</h1>" in page and f"difference: {escape(difference)}" in page, "the console's own"


def test_a_metric_that_there_is_not_is_refused_before_the_first_run(capsys):
    assert cli.main(["compare", "drive", "fail", *SMALL, "--metric", "scores - 1"]) == 1
    assert "no metric named 'scores'. Did you mean 'score'" in capsys.readouterr().err
    assert not Path("out").exists()


def test_result_folders_of_sweeps(capsys):
    for name, seconds in (("a", 0.06), ("b", 0.1)):
        experiment = Experiment(game="sweep_game:SMALL", seconds=seconds, seeds=range(20, 24), metrics=("seconds",))
        save_results(sweep(experiment, executor="process", out=name), name)
    assert cli.main(["compare", "a", "b", *SMALL, "--metric", "seconds"]) == 0
    assert capsys.readouterr().out.startswith(
        "seconds, b less a: +0.04 (95 % interval +0.04 to +0.04), 4 seeds: 4 more"
    )


def git(*words: str) -> None:
    if shutil.which("git") is None:
        pytest.skip("git is not installed")
    identity = ["-c", "user.name=a", "-c", "user.email=a@b.c", "-c", "commit.gpgsign=false"]
    subprocess.run(["git", *identity, *words], check=True, capture_output=True)


def test_a_commit_is_this_folder_as_it_was(monkeypatch, capsys):
    Path("robot").mkdir()
    monkeypatch.chdir("robot")
    git("init", "-q", "..")
    for speed in ("1.0", "2.0"):
        Path("robot.py").write_text(f"SPEED = {speed}\n")
        git("add", "-A", "..")
        git("commit", "-qm", speed)
    played = []
    monkeypatch.setattr(
        "simcore.sweep.compare_command.sweep", lambda experiment, **_: played.append(experiment) or 1 / 0
    )
    assert cli.main(["compare", "HEAD~1", ".", "--seeds", "2"]) == 1
    assert "ZeroDivisionError" in capsys.readouterr().err
    old, new = played[0].factors[0].values
    assert Path(old, "robot.py").read_text() == "SPEED = 1.0\n" and new == "."
    assert cli.main(["compare", "HEAD~7", "."]) == 1
    assert "'HEAD~7' is neither a folder with a robot.py or runs.sqlite in it, nor a commit" in capsys.readouterr().err
    assert cli.main(["compare", ".", "."]) == 1
    assert "are the same" in capsys.readouterr().err


def test_rows_of_a_project_are_known_by_what_is_in_it():
    for name, text in (("a", "1"), ("b", "2"), ("c", "1")):
        Path(name).mkdir()
        Path(name, "robot.py").write_text(text)

    def keys(*folders: str) -> list[str]:
        experiment = Experiment(project=folders[0], factors=(Factor("project", folders),))
        return experiment.run_keys(experiment.runs())

    assert keys("a", "b") == keys("c", "b") and len(set(keys("a", "b"))) == 2
    assert set(keys("b", "a")) == set(keys("a", "b")), "wherever it is, and in whatever order"


# --- one page -----------------------------------------------------------------------------------------------------


def test_both_runs_are_in_one_recording():
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
    assert both.integers_at("Sim/ShotIds", 1.0).tolist() == [2000, 102000, 2001, 102001]
