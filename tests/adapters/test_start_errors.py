"""`robotpy sim --simcore` of projects that cannot start: the last line is one sentence, and the status is not zero."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

GENERATED = Path(__file__).parent / "robots" / "team_generated"
HOLLOW = """
from dataclasses import replace
from pathlib import Path

from games.rebuilt import REBUILT

GAME = replace(REBUILT, name="hollow", field=replace(REBUILT.field, mesh=Path("nowhere.obj")))
"""
TEAM = """
class PhysicsEngine:
    def __init__(self, physics_controller, robot):
        {}

    def update_sim(self, now, tm_diff):
        pass
"""


@dataclass(frozen=True, kw_only=True)
class Start:
    """A project that cannot start, and parts of the last line."""

    says: Sequence[str]
    files: dict[str, str] = field(default_factory=dict)
    flags: Sequence[str] = ()
    library: dict[str, str] = field(default_factory=dict)
    """Modules installed alongside."""


STARTS = {
    "in a hub": Start(
        files={"simcore.toml": "[start]\nx = 4.6\ny = 4.03\n"},
        says=("simcore.toml [start]: the robot starts inside of a field element, at (4.60, 4.03) m; (", ") m is free"),
    ),
    "no mesh": Start(
        library={"hollow_game.py": HOLLOW},
        flags=("--game", "hollow"),
        says=("cannot read the field mesh", "nowhere.obj"),
    ),
    "physics.py that fails": Start(
        files={"physics.py": TEAM.format("robot.wheels = 1 / 0")}, says=("physics.py, line 4: ZeroDivisionError",)
    ),
}
"""Messages about mistakes in the files themselves are in the tests of the file readers."""


@pytest.mark.parametrize("name", STARTS)
def test_a_failed_start_prints_its_error_and_exits(name, project_of, python, install, tmp_path):
    pytest.importorskip("pathplannerlib", reason="needs PathPlanner: pip install robotpy-pathplannerlib")
    start, project = STARTS[name], project_of(GENERATED).folder
    for file, text in start.files.items():
        (project / file).write_text(text)
    library = tmp_path / "library"
    library.mkdir()
    for file, text in start.library.items():
        (library / file).write_text(text)
    install(library, "hollow-game", {"simcore.games": "hollow = hollow_game:GAME"} if "no mesh" == name else {})
    words = ("-m", "robotpy", "sim", "--simcore", "--nogui", *start.flags)
    code, said = python(project, *words, path=(library,), on_screen=True)
    before, _, last = f"\n{said}".rstrip("\n").rpartition("\n\n")
    assert "\n" not in last and last.startswith("robotpy sim: "), said
    for words in start.says:
        assert words in last, said
    assert last.removeprefix("robotpy sim: ") not in before, said
    assert code == 1, said
    assert said.count("Traceback") == (name == "physics.py that fails") and "simcore/robotcode/sim" not in said, said
