"""Two installed games under `robotpy sim --simcore`: the flag, the file or the newer year decides, and is logged."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from simcore.cli import main

pytestmark = pytest.mark.slow

TURRETED = Path(__file__).parent / "robots" / "turreted"
LATER = """
from dataclasses import replace

from games.rebuilt import REBUILT

GAME = replace(REBUILT, name="later", year=2999)
"""


@pytest.fixture(scope="module")
def second_game(tmp_path_factory, install):
    """Return a folder with a distribution of a game of a far year, so that it is the newest."""
    folder = tmp_path_factory.mktemp("second")
    (folder / "later_game.py").write_text(LATER)
    install(folder, "later-game", {"simcore.games": "later = later_game:GAME"})
    return folder


@pytest.fixture
def robot(tmp_path):
    """Return a copy of a robot whose file names no game."""
    folder = tmp_path / "turreted"
    shutil.copytree(TURRETED, folder)
    text = (folder / "simcore.toml").read_text()
    (folder / "simcore.toml").write_text(text.replace('game = "rebuilt"\n', ""))
    return folder


def line_of(run) -> str:
    return next(line for line in run["output"].splitlines() if "also installed" in line)


def test_the_newest_game_is_the_default(scenario, robot, second_game):
    run = scenario("which_game", str(robot), "--simcore", path=(second_game,))
    assert run["game"] == "later"
    assert "game later (2999), the newest; also installed: " in line_of(run) and "rebuilt" in line_of(run)


def test_the_game_in_the_file_overrides_the_default(scenario, second_game):
    run = scenario("which_game", str(TURRETED), "--simcore", path=(second_game,))
    assert run["game"] == "rebuilt"
    assert "game rebuilt (2026), as simcore.toml says; also installed: later" in line_of(run)


def test_the_game_flag_overrides_the_file(scenario, second_game):
    run = scenario("which_game", str(TURRETED), "--simcore", "--game", "later", path=(second_game,))
    assert run["game"] == "later"
    assert "game later (2999), as --game says; also installed: " in line_of(run)


def test_play_and_view_print_the_game_that_they_use(second_game, tmp_path, monkeypatch, capsys):
    monkeypatch.syspath_prepend(str(second_game))
    monkeypatch.chdir(tmp_path)

    def said(*words: str) -> str:
        main(list(words))
        run = capsys.readouterr()
        return run.out + run.err

    assert "game later (2999), the newest; also installed: rebuilt" in said("play", "--seconds", "0.2")
    assert "also installed" not in said("play", "rebuilt", "--seconds", "0.2", "--log", "old.wpilog")
    viewed = said("view", "--no-browser", "old.wpilog")
    assert "game       rebuilt" in viewed and "old.html" in viewed, "a log names its game"
    assert "game       later" in said("view", "--no-browser", "old.wpilog", "--game", "later")
    assert "no game named 'latter'. Did you mean 'later'" in said(
        "view", "--no-browser", "old.wpilog", "--game", "latter"
    )


def test_a_robot_stands_on_the_field_of_another_game(scenario, robot, tmp_path_factory, install):
    """The field is the mirrored one of crates and balls, 12 x 6 m, without any part of REBUILT."""
    folder = tmp_path_factory.mktemp("crates")
    shutil.copy(Path(__file__).parents[1] / "games" / "crates.py", folder)
    install(folder, "crates-game", {"simcore.games": "crates = crates:CRATES"})
    text = (robot / "simcore.toml").read_text()
    text = text.replace("x = 1.6\ny = 5.96\npreload = 6", "x = 4.0\ny = 3.0").replace('"Fuel"', '"Ball"')
    (robot / "simcore.toml").write_text(text)
    run = scenario("which_game", str(robot), "--simcore", "--game", "crates", path=(folder,))
    assert run["game"] == "crates"
    assert "game crates (1), as --game says" in line_of(run)


def test_other_games_run_although_one_game_is_broken(tmp_path_factory, install, project_of):
    """Robot tests, play, check, sweep, compare and doctor work; the broken game, if named, reports where it failed."""
    site = tmp_path_factory.mktemp("broken")
    (site / "broken_game.py").write_text("from games.rebuilt import REBUILT\n\nGAME = replace(REBUILT)\n")
    install(site, "broken-game", {"simcore.games": "broken = broken_game:GAME"})
    project = project_of(TURRETED)
    code, said = project("def test_it(sim):\n    sim.teleop(seconds=0.2)\n", path=(site,))
    assert code == 0 and "1 passed" in said, said

    def said_by(*words: str, status: int = 0) -> str:
        code, said = project("", command=("-m", "simcore", *words), path=(site,))
        assert "Traceback" not in said and code == status, said
        return said

    why = "game broken of the package broken-game does not load: broken_game.py, line 3: NameError: name 'replace' is"
    assert "nothing wrong" in said_by("check") and "points" in said_by("play", "rebuilt", "--seconds", "0.2")
    assert f"left out: {why}" in said_by("play", "--seconds", "0.2")
    short = ("--seconds", "0.5", "--workers", "1")
    assert "page.html" in said_by("sweep", "--seeds", "2", *short)
    (project.folder / "robot.py").rename(project.folder / "elsewhere.py")  # else they are folders and commits
    assert "page.html" in said_by("compare", "depot", "tour", "--seeds", "5", *short)
    assert "game broken of the package broken-game does not load" in " ".join(
        said_by("doctor").replace("\u2502", " ").split()
    )
    assert said_by("play", "broken", status=1).strip().startswith(f"simcore play: {why}")
