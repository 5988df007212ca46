"""A newly written game has the files that the page names, and plays."""

from __future__ import annotations

import importlib
import re
import sys
from pathlib import Path

import pytest

from simcore import play_auto
from simcore.cli import main
from simcore.match.registry import installed_games
from simcore.match.scoring import ScoreEvent
from simcore.new_game.new_game_command import write_game
from simcore.pieces.resting_places import PlaceEvent, RestingPlace
from simcore.testing.game_laws import check_conserved
from simcore.world.zones import BoxZone

PAGE = Path(__file__).resolve().parents[2] / "docs" / "new_game.md"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path / "discs"))
    yield tmp_path / "discs"
    for name in [name for name in sys.modules if name.split(".")[0] == "discs"]:
        del sys.modules[name]


def test_the_page_names_every_file_in_the_order_of_writing(folder):
    written = [path.relative_to(folder).as_posix() for path in write_game("discs", year=2030, folder=folder)]
    assert written[:3] == ["README.md", "pyproject.toml", "discs/__init__.py"]
    rows = re.findall(r"^\| `([\w/]+\.py)` \|", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert [row if "/" in row else f"discs/{row}" for row in rows] == written[3:]


def test_the_newly_written_game_plays_and_scores(folder):
    write_game("discs", year=2030, folder=folder)
    importlib.invalidate_caches()  # the folder is newer than Python's import caches
    game = importlib.import_module("discs").DISCS
    assert sum(supply.count for supply in game.pieces) == 42  # as stated on the page
    run = play_auto(game, seconds=4.0)
    run.match.close()
    assert run.report.score.blue > 0
    check_conserved(game, "collect", seconds=1.0)


def test_a_new_game_does_not_become_the_default(folder, capsys):
    """The newest installed game is the default, which must stay simcore's own."""
    newest = max(game.year for game in installed_games().values())
    assert main(["new-game", "discs", "--folder", str(folder)]) == 0
    importlib.invalidate_caches()
    game = importlib.import_module("discs").DISCS
    assert game.year < newest and f"Its year is {game.year}" in capsys.readouterr().out


def test_the_table_of_events_names_existing_attributes():
    """Each word of a row is an attribute of the event or of its place."""
    rows = dict(re.findall(r"^\| `event` of ([^|]+?) \| (.+) \|$", PAGE.read_text(encoding="utf-8"), re.M))
    assert rows.keys() == {"`scored`", "`placed`, `removed`"}
    place = RestingPlace(name="a", zone=BoxZone((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)))
    scored = ScoreEvent(time=1.0, zone="a", alliance="blue", points=1, slot=0)
    for row, owners in (
        (rows["`scored`"], (scored,)),
        (rows["`placed`, `removed`"], (PlaceEvent(place, 0, -1), place)),
    ):
        for word in re.findall(r"`(\w+)`", row):
            assert any(hasattr(owner, word) for owner in owners), word
