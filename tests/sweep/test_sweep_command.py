"""Command `simcore sweep`: output, stored files, repeated runs and refused options."""

import csv
from functools import partial
from pathlib import Path

import pytest

from simcore import cli
from simcore.sweep.api import sweep

from .made_sweep import blocks_of

SMALL = ["sweep", "sweep_game:SMALL", "--seconds", "0.1"]


def sweep_here(real, experiment, *, workers, **rest):
    return real(experiment, workers=0, **rest)


@pytest.fixture(autouse=True)
def here(monkeypatch):
    """Play runs in this process."""
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    monkeypatch.setattr("simcore.sweep.sweep_command.sweep", partial(sweep_here, sweep))


def test_failed_runs_are_reported_and_can_be_repeated(tmp_path, capsys):
    out = str(tmp_path / "two words")
    words = [*SMALL, "--out", out, "--auto", "fail", "--seeds", "1:3", "--success", "distance_m > 0"]
    assert cli.main(words) == 1
    said = capsys.readouterr().out
    assert "1 of 2 = 50 %" in said and "ZeroDivisionError: in a team's own code" in said
    assert f"run 1 alone: simcore sweep --out '{out}' --repeat 1" in said
    assert {path.name for path in Path(out).iterdir()} == {"runs.sqlite", "page.html"}
    assert cli.main(["sweep", "--out", out, "--repeat", "1"]) == 1
    assert "ZeroDivisionError" in capsys.readouterr().err
    assert cli.main([*words, "--csv"]) == 1
    with Path(out, "results.csv").open(newline="") as file:
        digest, failed = (row["digest"] for row in csv.DictReader(file))
    capsys.readouterr()
    assert cli.main(["sweep", "--out", out, "--repeat", "0"]) == 0
    assert digest in capsys.readouterr().out and failed == ""
    assert {"run_0.wpilog", "run_0.html"} <= {path.name for path in Path(out).iterdir()}
    Path(out, "run_0.html").unlink()
    Path(out, "run_0.html").mkdir()
    assert cli.main(["sweep", "--out", out, "--repeat", "0"]) == 0
    said = capsys.readouterr()
    assert "no page: cannot write the page" in said.err and digest in said.out and "run_0.wpilog" in said.out
    page = blocks_of(Path(out, "page.html").read_text("utf-8"))
    assert page[0]["text"].startswith("1 of 2, ") and f"--out '{out}' --repeat RUN" in page[-1]["caption"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--success", "scor > 0"], "Did you mean 'score'"),
        (["--success", "score"], "'score' is not a condition"),
        (["--metric", "hits", "--success", "score > 1"], "no metric or factor (of --success) named 'score'"),
        (["--set", "robot.mas=3"], "Did you mean 'mass'"),
        (["--repeat", "0"], "no runs in it"),
    ],
)
def test_invalid_options_are_refused_before_the_first_run(tmp_path, capsys, words, said):
    assert cli.main([*SMALL, "--out", str(tmp_path), *words]) == 1
    assert said in capsys.readouterr().err and list(tmp_path.iterdir()) == []


def test_abbreviated_options_are_refused(capsys):
    with pytest.raises(SystemExit):
        cli.main([*SMALL, "--seed", "7"])
    assert "unrecognized arguments: --seed" in capsys.readouterr().err
