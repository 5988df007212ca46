"""`robotpy sim --simcore` of projects that cannot start: one sentence, last on the screen, and a status not zero."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
GENERATED = Path(__file__).parent / "robots" / "team_generated"

HIDDEN = """
import sys


class Hidden:
    def find_spec(self, name, path=None, target=None):
        if name == "phoenix6":
            raise ModuleNotFoundError("No module named 'phoenix6'", name=name)


sys.meta_path.insert(0, Hidden())
"""
HOLLOW = """
from dataclasses import replace

from games.rebuilt import REBUILT

GAME = replace(REBUILT, name="hollow", field=replace(REBUILT.field, mesh="nowhere.obj"))
"""
MECHANISM = (
    '[[mechanism]]\nname = "hood"\nkind = "arm"\nleader = 30\ngearing = 50\ninertia = 0.1\nmin_deg = 0\nmax_deg = 40\n'
)
TEAM = """
class PhysicsEngine:
    def __init__(self, physics_controller, robot):
        {}

    def update_sim(self, now, tm_diff):
        pass
"""


@dataclass(frozen=True, kw_only=True)
class Start:
    """A project that cannot start, and what its last line says."""

    says: Sequence[str]
    files: dict[str, str] = field(default_factory=dict)
    flags: Sequence[str] = ()
    library: dict[str, str] = field(default_factory=dict)
    """Modules that are installed beside."""


def toml(text: str) -> dict[str, str]:
    return {"simcore.toml": text}


STARTS = {
    "unknown key": Start(files=toml("[robot]\nmasss = 50\n"), says=("[robot]: no key 'masss'. Did you mean 'mass'?",)),
    "no TOML": Start(files=toml("[robot\n"), says=("simcore.toml", "line 1")),
    "not a number": Start(
        files=toml("[robot]\nmass = nan\n"), says=("[robot]: mass must be a number above 0 kg, got nan",)
    ),
    "pounds": Start(files=toml("[robot]\nmass = 125\n"), says=("mass must be in kg", "As pounds that is 56.7 kg")),
    "inches": Start(
        files=toml("[robot]\nbumper_length = 34\nbumper_width = 34\n"),
        says=("bumper_length must be in meters, from 0.4 to 1.2, got 34. As inches that is 0.864 m",),
    ),
    "outside": Start(
        files=toml("[start]\nx = 100.0\n"), says=("simcore.toml [start]: the robot starts outside of the field",)
    ),
    "in a hub": Start(
        files=toml("[start]\nx = 4.6\ny = 4.03\n"),
        says=("simcore.toml [start]: the robot starts inside of a field element, at (4.60, 4.03) m; (", ") m is free"),
    ),
    "no such game": Start(flags=("--game", "rebuild"), says=("no game named 'rebuild'. Did you mean 'rebuilt'?",)),
    "no such engine": Start(flags=("--engine", "havok"), says=("no physics engine named 'havok'",)),
    "no such motor": Start(
        files=toml(MECHANISM),
        says=("[[mechanism]] 'hood': the robot program builds no TalonFX 30; it builds TalonFX [1,",),
    ),
    "no such port": Start(
        files=toml('[[sensor]]\nname = "beam"\nkind = "beam break"\ndio = 5\n'),
        says=("[[sensor]] 'beam': the robot program builds nothing on DIO 5",),
    ),
    "no Phoenix": Start(
        library={"sitecustomize.py": HIDDEN},
        says=("--simcore cannot load what it needs (No module named 'phoenix6'); `python -m pip install", "brings it"),
    ),
    "no mesh": Start(
        library={"hollow_game.py": HOLLOW},
        flags=("--game", "hollow"),
        says=("cannot read the field mesh", "nowhere.obj"),
    ),
    "physics.py that is no Python": Start(
        files={"physics.py": "def update(:\n"}, says=("SyntaxError: ", "(physics.py, line 1)")
    ),
    "physics.py without an engine": Start(files={"physics.py": ""}, says=("physics.py has no class PhysicsEngine",)),
    "physics.py that fails": Start(
        files={"physics.py": TEAM.format("robot.wheels = 1 / 0")}, says=("physics.py, line 4: ZeroDivisionError",)
    ),
}
FAILING_CODE = ("physics.py that is no Python", "physics.py that fails")
IN_CI = ("no Phoenix", "in a hub", "physics.py that fails")


@pytest.mark.parametrize("name", STARTS)
def test_the_sentence_comes_last_and_the_program_leaves(name, project_of, distribution, install, tmp_path, whole):
    if not whole and name not in IN_CI:
        pytest.skip("sampled; --whole starts all of them")
    pytest.importorskip("pathplannerlib", reason="needs PathPlanner: pip install robotpy-pathplannerlib")
    start, project = STARTS[name], project_of(GENERATED).folder
    for file, text in start.files.items():
        (project / file).write_text(text)
    library = tmp_path / "library"
    library.mkdir()
    for file, text in start.library.items():
        (library / file).write_text(text)
    install(library, "hollow-game", {"simcore.games": "hollow = hollow_game:GAME"} if "no mesh" == name else {})
    code, said, seconds = run_sim(project, (library, distribution, ROOT), start.flags)
    before, _, last = f"\n{said}".rstrip("\n").rpartition("\n\n")
    assert "\n" not in last and last.startswith("robotpy sim: "), said
    for words in start.says:
        assert words in last, said
    assert last.removeprefix("robotpy sim: ") not in before, said
    assert code == 1 and seconds < 2.0, said
    assert said.count("Traceback") == (name in FAILING_CODE) and "simcore/robotpy" not in said, said


def run_sim(folder: Path, path: Sequence[Path], flags: Sequence[str]) -> tuple[int, str, float]:
    """Status, everything on the screen, and how long the program lived on after its last line [s]."""
    process = subprocess.Popen(
        [sys.executable, "-m", "robotpy", "sim", "--simcore", "--nogui", *flags],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(map(str, path))},
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    try:
        lines, last = [], time.monotonic()
        for line in process.stdout:
            lines.append(line)
            last = time.monotonic()
        code = process.wait(timeout=30)
        return code, "".join(lines), time.monotonic() - last
    finally:
        process.kill()
