"""A robot project may have a package named `games`: both packages can be imported."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CODE = """
from importlib.metadata import EntryPoint
import games{inside}
from simcore.match import registry

registry.entry_points = lambda group: [EntryPoint("rebuilt", "games.rebuilt:REBUILT", group)]
print(games{inside}.MINE, registry.find_game("rebuilt").name)
from games.rebuilt import REBUILT
"""


@pytest.mark.parametrize(
    ("file", "inside"),
    [("games.py", ""), ("games/chess.py", ".chess"), ("games/__init__.py", "")],
    ids=["module", "folder", "package"],
)
def test_a_project_with_a_package_named_games_can_import_both_packages(tmp_path, file, inside):
    (tmp_path / file).parent.mkdir(exist_ok=True)
    (tmp_path / file).write_text("MINE = 7\n")
    done = subprocess.run(
        [sys.executable, "-c", CODE.format(inside=inside)],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.stdout.split() == ["7", "rebuilt"], done.stderr[-2000:]
