"""A game package that does not load is left out, without an effect on other games, commands or robot tests."""

import re

import pytest

from simcore.cli import main
from simcore.errors import ConfigError
from simcore.match.registry import find_game, installed_games
from simcore.sweep.sweep_page import _title

NAN = """from dataclasses import replace
from games.rebuilt import REBUILT

GAME = replace(REBUILT, name="mine", starts=((float("nan"), 1.0, 0.0),))
"""
OTHER = """from dataclasses import replace
from games.rebuilt import REBUILT

GAME = replace(REBUILT, name="mine", year=2999)
"""
WAYS = {
    "syntax": ("GAME = 1\nHEIGHT = = 2\n", r"mine/game\.py, line 2: SyntaxError: invalid syntax"),
    "import": ("import no_such_module\n", r"mine/game\.py, line 1: ModuleNotFoundError: No module named 'no_such_mod"),
    "raising": ("\nGAME = 1 / 0\n", r"mine/game\.py, line 2: ZeroDivisionError: division by zero"),
    "leaving": ("import sys\nsys.exit(3)\n", r"mine/game\.py, line 2: SystemExit: 3"),
    "type": ("GAME = {}\n", r"mine\.game:GAME must be a Game, got \{\}"),
    "missing": (None, r"ModuleNotFoundError: No module named 'mine\.game'"),
    "nan": (NAN, r"mine/game\.py, line 4: Game mine: starts\[0\]\[0\] must be .*, got nan"),
}


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Return a function that writes a game's package and its metadata as pip installs them."""
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.chdir(tmp_path)

    def install(source: str | None, *, package: str = "mine", name: str = "mine", fresh: bool = True) -> None:
        (tmp_path / package).mkdir(exist_ok=not fresh)
        (tmp_path / package / "__init__.py").write_text("")
        if source is not None:
            (tmp_path / package / "game.py").write_text(source)
        info = tmp_path / f"{package}_game-0.1.0.dist-info"
        info.mkdir(exist_ok=not fresh)
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}-game\nVersion: 0.1.0\n")
        (info / "entry_points.txt").write_text(f"[simcore.games]\n{name} = {package}.game:GAME\n")
        for module in (package, f"{package}.game"):
            monkeypatch.delitem(__import__("sys").modules, module, raising=False)

    return install


@pytest.mark.parametrize("way", WAYS)
def test_a_broken_game_is_left_out_and_the_others_stay_installed(installed, way, capsys):
    source, why = WAYS[way]
    installed(source)
    said = []
    assert {"rebuilt", "reefscape"} <= {*installed_games(say=said.append)} and "mine" not in installed_games()
    (line,) = said
    assert re.fullmatch(rf"left out: game mine of the package mine-game.*{why}.*", line) and "\n" not in line
    assert find_game("rebuilt").name == "rebuilt"
    said.clear()
    assert find_game(say=said.append).name == "rebuilt" and line in said, "the newest of those that load"
    with pytest.raises(ConfigError, match=why):
        find_game("mine")
    assert main(["play", "mine"]) == 1
    captured = capsys.readouterr()
    assert re.search(why, captured.err) and len(captured.err.strip().splitlines()) == 1 and not captured.out
    assert main(["play", "--list"]) == 0 and line in capsys.readouterr().err


def test_only_the_named_game_is_loaded(installed):
    installed("raise RuntimeError\n")
    installed("open('was_loaded', 'w')\n", package="other", name="other")
    assert find_game("rebuilt").name == "rebuilt"
    assert not list(__import__("pathlib").Path().glob("was_loaded"))


def test_a_traceback_starts_in_the_rules_of_the_game(installed, capsys):
    installed(
        OTHER
        + """
from simcore.match.game import Rules


class Mine(Rules):
    def after_tick(self):
        self.point.count += 1


GAME = replace(GAME, rules=Mine)
"""
    )
    outputs = ["--log", "run.wpilog", "--page", "run.html"]
    assert main(["play", "mine", "--seconds", "0.1", *outputs]) == 1
    said = capsys.readouterr().err.strip().splitlines()
    assert said[-1] == "AttributeError: 'Mine' object has no attribute 'point'"
    assert 'mine/game.py", line 11, in after_tick' in said[1] and len(said) < 6


def test_viewing_a_log_reports_that_its_game_does_not_load(installed, capsys):
    installed(OTHER)
    outputs = ["--log", "run.wpilog", "--page", "run.html"]
    assert main(["play", "mine", "--seconds", "0.1", *outputs]) == 0
    installed("raise RuntimeError('half written')\n", fresh=False)
    capsys.readouterr()
    assert main(["view", "--no-browser", "run.wpilog"]) == 0
    said = capsys.readouterr().err
    assert "mine/game.py, line 1: RuntimeError: half written; the field is drawn empty" in said


def test_two_games_with_one_name_are_both_left_out(installed):
    installed(OTHER)
    installed(OTHER, package="other")
    said = []
    assert "mine" not in installed_games(say=said.append) and "rebuilt" in installed_games()
    assert len(said) == 1 and "mine-game (mine.game:GAME)" in said[0] and "other-game (other.game:GAME)" in said[0]


def test_an_installed_game_cannot_take_the_name_of_simcores_game(installed):
    installed(OTHER, name="rebuilt")
    said = []
    assert installed_games(say=said.append)["rebuilt"].year == find_game("rebuilt").year == 2026
    assert said == ["left out: game rebuilt of the package mine-game: simcore has one of that name: rename it"]


def test_a_sweep_has_a_title_even_if_its_game_does_not_load(installed):
    installed("raise RuntimeError\n")
    experiment = type("Experiment", (), dict(project=None, game="mine", auto="depot", red=None, blue=None))
    assert _title(type("Results", (), dict(experiment=experiment, factors={}))) == "Sweep: mine, auto depot"
    experiment.game = None
    assert "rebuilt" in _title(type("Results", (), dict(experiment=experiment, factors={})))
