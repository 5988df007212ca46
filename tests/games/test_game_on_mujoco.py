"""Every game on MuJoCo: an auto obeys the laws of a match and repeats to the last bit."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from game_table import GAMES, play

from simcore.match.runner import play_auto

pytestmark = pytest.mark.engines("mujoco")

HERE = Path(__file__).resolve().parent
SECONDS = 3.0
CODE = """
import sys
from game_table import GAMES
from simcore.match.runner import play_auto
print(play_auto(GAMES[sys.argv[1]], seconds=float(sys.argv[2]), seed=3).report.digest)
"""


def test_an_auto_on_mujoco_obeys_the_laws_of_a_match(game):
    """No piece is lost, sinks, leaves the field or lies off its reported place; the robot drives and scores."""
    auto = next(iter(game.autos))
    seen = play(game.name, auto)
    match = seen.run.match
    assert match.world.engine.name == "mujoco"
    assert seen.lost == []
    assert match.pieces.recovered == 0
    assert seen.sunk > -0.5 * min(kind.rest_height for kind in match.pieces.types)
    assert seen.ghosts < 0.010
    assert seen.run.report.score.blue > 0 and seen.run.report.score.red == 0
    assert math.degrees(np.abs(np.array(seen.roll_pitch)).max()) < 30.0
    assert np.array(seen.poses)[:, 2].min() > -0.01


def test_the_same_seed_gives_the_same_match_on_mujoco_in_another_process(game, whole):
    if game.name not in ("rebuilt", "crates") and not whole:
        pytest.skip("sampled: --whole plays all games")
    run = play_auto(GAMES[game.name], seconds=SECONDS, seed=3)
    run.match.close()
    path = os.pathsep.join((str(HERE.parents[1]), str(HERE)))
    other = subprocess.run(
        [sys.executable, "-c", CODE, game.name, str(SECONDS)],
        env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert other.returncode == 0, other.stderr
    assert other.stdout.strip() == run.report.digest
