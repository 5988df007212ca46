"""Game of a robot project under `robotpy sim --nogui`. Arguments: the project's folder, then flags."""

from __future__ import annotations

import json
import os
import shutil
import sys
from pathlib import Path

from phoenix6 import unmanaged
from robotpy.main import main as robotpy_main

from simcore.robotcode.sim.robot_physics import RobotPhysics


def answer(physics: RobotPhysics) -> None:
    said = {"lateness_ms": 0.0, "game": physics.match.game.name, "ticks": physics.match.ticks}
    print(json.dumps(said), flush=True)
    os._exit(0)


def main() -> None:
    folder = Path.cwd() / "project"
    shutil.copytree(sys.argv[1], folder, ignore=shutil.ignore_patterns("ctre_sim", "__pycache__", "networktables*"))
    shutil.copy(Path(__file__).parents[1] / "robots" / "shared" / "measures.py", folder)
    os.chdir(folder)
    unmanaged.set_phoenix_diagnostics_start_time(-1)
    RobotPhysics.after_tick = answer
    sys.argv = ["robotpy", "sim", "--nogui", *sys.argv[2:]]
    robotpy_main()


if __name__ == "__main__":
    main()
