"""The walk through a new game: the package that the command writes has the files of the page, and plays."""

from __future__ import annotations

import importlib
import re
import sys
from pathlib import Path

import pytest

from simcore import play_auto
from simcore.new_game.new_game_command import write_game
from simcore.testing.game_laws import check_conserved

PAGE = Path(__file__).resolve().parents[2] / "docs" / "new_game.md"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path / "discs"))
    yield tmp_path / "discs"
    for name in [name for name in sys.modules if name.split(".")[0] == "discs"]:
        del sys.modules[name]


def test_the_page_names_every_file_in_the_order_in_which_they_are_written(folder):
    written = [path.relative_to(folder).as_posix() for path in write_game("discs", year=2030, folder=folder)]
    assert written[:3] == ["README.md", "pyproject.toml", "discs/__init__.py"]
    rows = re.findall(r"^\| `([\w/]+\.py)` \|", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert [row if "/" in row else f"discs/{row}" for row in rows] == written[3:]


def test_the_game_that_was_written_plays_and_scores(folder):
    write_game("discs", year=2030, folder=folder)
    game = importlib.import_module("discs").DISCS
    assert sum(supply.count for supply in game.pieces) == 42  # as the page says
    run = play_auto(game, seconds=4.0)
    run.match.close()
    assert run.report.score.blue > 0
    check_conserved(game, "collect", seconds=1.0)
