"""Fixtures that play each auto once and share the run between tests."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parent))  # for game_table.py and crates.py, which the tests here share

from game_table import AUTOS, GAMES, LONG, Played, play

from simcore.match.game import Game


@pytest.fixture(autouse=True)
def _engine(engine_name):
    """Build the worlds of each test on the selected engine."""


@pytest.fixture(params=GAMES)
def game(request) -> Game:
    """Return each game in turn."""
    return GAMES[request.param]


class Runs(dict):
    """Runs of an auto by alliance, each played when first used."""

    def __init__(self, name: str, auto: str) -> None:
        super().__init__()
        self.name, self.auto = name, auto

    def __missing__(self, alliance: str) -> Played:
        self[alliance] = play(self.name, self.auto, alliance)
        return self[alliance]


@pytest.fixture(scope="session", params=AUTOS, ids="-".join)
def runs(request, engine_name) -> Iterator[Runs]:
    """Yield the runs of one auto after the other; tests are sorted by auto, so each auto is played only once."""
    if request.param in LONG and not request.config.getoption("--whole"):
        pytest.skip("sampled: --whole plays it")
    made = Runs(*request.param)
    yield made
    made.clear()


@pytest.fixture
def run(runs) -> Played:
    """Return the blue run of an auto."""
    return runs["blue"]
