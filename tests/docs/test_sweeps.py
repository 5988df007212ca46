"""Every command on the page about sweeps works as described, with one seed and a short auto."""

from __future__ import annotations

import re
import shlex
from contextlib import closing
from pathlib import Path

import pytest

from simcore.cli import main
from simcore.sweep.run_store import RunStore

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "sweeps.md").read_text(encoding="utf-8")
COMMANDS = re.findall(r"^    simcore ((?!compare).+)$", PAGE, re.MULTILINE)
SHORT = ["--seeds", "1", "--seconds", "0.5", "-j", "1"]
"""Options that shorten a run; the last value of an option counts."""


def short(command: str) -> list[str]:
    words = [*shlex.split(command), *SHORT]
    return [*words, "--samples", "2"] if "--samples" in words else words


@pytest.mark.parametrize("command", [c for c in COMMANDS if "--project" not in c])
def test_each_command_on_the_page_runs_and_writes_a_page_and_a_store(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(short(command)) == 0
    out = tmp_path / re.search(r"--out (\S+)", command)[1]
    said = capsys.readouterr().out
    with closing(RunStore(out, must_exist=True)) as store:
        experiment = store.experiment()
        rows = store.rows(experiment.run_keys(experiment.runs()))
    values = re.search(r"--set (\S+)=(\S+)", command)
    count = 1 if values is None else 4 if values[2] == "45:60:5" else values[2].count(",") + 1
    runs = 2 if "--samples" in command else count
    assert len(rows) == runs and f"{runs} run" in said
    assert {path.name for path in out.iterdir()} >= {"page.html", "runs.sqlite"}
    if "--success" in command:
        condition = re.search(r'--success "(.+?)"', command)[1]
        assert re.search(rf"{condition}: 0 of \d+ = 0 % \(95 % interval 0 to \d+ %\)", said), said
