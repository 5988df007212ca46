"""Each auto is played once and looked at from many sides."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parent))  # for game_table.py and crates.py, which the tests here share

from game_table import GAMES, LONG, Played, play

from simcore.match.game import Game


@pytest.fixture(autouse=True)
def _engine(engine_name):
    """Worlds of this test are of this engine."""


@pytest.fixture(params=GAMES)
def game(request) -> Game:
    """Every game in turn."""
    return GAMES[request.param]


@pytest.fixture(scope="session")
def played(engine_name, pytestconfig) -> Iterator[dict[tuple[str, str, str], Played]]:
    """Runs by game, auto and alliance, made when first asked for."""

    class Runs(dict):
        def __missing__(self, key: tuple[str, str, str]) -> Played:
            if key[:2] in LONG and not pytestconfig.getoption("--whole"):
                pytest.skip("sampled: --whole plays it")
            self[key] = play(*key)
            return self[key]

    runs = Runs()
    yield runs
    for one in runs.values():
        one.run.match.close()
