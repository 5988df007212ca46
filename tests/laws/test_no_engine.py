"""A game of balls and robots needs no engine: it imports none, and the run is identical with either engine."""

from __future__ import annotations

import subprocess
import sys

PROGRAM = """
import sys
for name in sys.argv[2:]:
    sys.modules[name] = None  # as if the engine were not installed
from games.rebuilt import REBUILT
from simcore.match.runner import play_auto
run = play_auto(REBUILT, "depot", seconds=1.0, engine=sys.argv[1] or None)
with run.match as match:
    print(match.digest.hexdigest(), match.world.engine_name)
    print([name for name in ("pybullet", "mujoco") if sys.modules.get(name)])
"""


def play(engine: str = "", *missing: str) -> list[str]:
    done = subprocess.run([sys.executable, "-c", PROGRAM, engine, *missing], capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


def test_a_rebuilt_auto_is_identical_with_either_engine_and_without_an_engine():
    runs = [play(), play("bullet"), play("mujoco"), play("", "pybullet", "mujoco")]
    assert runs[0][0].endswith(" none") and runs[0][1] == "[]"
    assert all(run == runs[0] for run in runs[1:])
