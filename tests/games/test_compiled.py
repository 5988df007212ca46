"""Compiled and in plain Python a game is the same to the last bit, in processes of their own."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
pytestmark = [pytest.mark.slow, pytest.mark.compiled]

GAME = """
import json, sys
from importlib.machinery import ExtensionFileLoader
from games.rebuilt import REBUILT
from simcore.match.runner import play_auto

run = play_auto(REBUILT, sys.argv[1], seconds=float(sys.argv[2]), alliance=sys.argv[3], seed=7, engine=sys.argv[4])
run.match.close()
native = [name for name, module in list(sys.modules.items())
          if name.startswith("simcore.") and isinstance(getattr(module, "__loader__", None), ExtensionFileLoader)]
print(json.dumps({"digest": run.report.digest, "native": len(native), "substeps": str(run.report.substeps)}))
"""


SAMPLE = (
    *("tests/unit/pieces", "tests/unit/geometry", "tests/games/test_shooter_tables.py"),
    *("tests/games/test_shot_preview.py", "tests/games/test_rising_shots.py"),
)


def play(package: Path, folder: Path, *arguments: str) -> dict:
    """What a fresh process says of a game with the simcore of a folder."""
    done = subprocess.run(
        [sys.executable, "-c", GAME, *arguments],
        env={**os.environ, "PYTHONPATH": str(package)},
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return json.loads(done.stdout.splitlines()[-1])


@pytest.mark.parametrize("engine", ["bullet", "mujoco"])
@pytest.mark.parametrize("arguments", [("depot", "4", "blue"), ("neutral", "6", "red")], ids=["depot", "neutral"])
def test_an_auto_is_the_same_to_the_last_bit(compiled, tmp_path, arguments, engine):
    pytest.importorskip({"bullet": "pybullet", "mujoco": "mujoco"}[engine])
    arguments = (*arguments, engine)
    plain, native = play(ROOT, tmp_path, *arguments), play(compiled, tmp_path, *arguments)
    assert plain.pop("native") == 0 and native.pop("native") > 20
    assert native == plain


NEEDS = {".phoenix6": "phoenix6", ".phoenix5": "phoenix5", ".revlib": "rev", ".robotpy": "pyfrc"}
"""What the modules of a package import, by a part of their names."""


def test_every_library_of_the_wheel_loads_in_place_of_its_source(compiled, tmp_path):
    """Imported one by one, in a fresh process; the sources are there, for tracebacks."""
    names = [
        path.relative_to(compiled).as_posix().partition(".")[0].replace("/", ".")
        for path in sorted((compiled / "simcore").rglob("*"))
        if path.suffix in (".so", ".pyd") and "__mypyc" not in path.name
    ]
    assert len(names) > 70 and all((compiled / f"{name.replace('.', '/')}.py").is_file() for name in names)
    code = (
        "import importlib\n"
        "from importlib.machinery import ExtensionFileLoader\n"
        "from importlib.util import find_spec\n"
        f"for name in {names!r}:\n"
        f"    needs = [package for part, package in {NEEDS!r}.items() if part in name]\n"
        "    if not all(map(find_spec, needs)):\n"
        "        continue\n"
        "    module = importlib.import_module(name)\n"
        "    assert isinstance(module.__loader__, ExtensionFileLoader), name\n"
        "print('all')"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(compiled)},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.stdout.strip() == "all", done.stderr[-2000:]


def test_pieces_and_shot_tables_pass_their_tests_compiled(compiled, tmp_path):
    """A compiled function refuses what its annotations do not name, where plain Python takes it."""
    shutil.copytree(ROOT / "tests", tmp_path / "tests", ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("conftest.py", "pyproject.toml", "docs", "scripts"):
        (tmp_path / name).symlink_to(ROOT / name)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-n", "0", *SAMPLE],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(compiled)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-3000:]
    assert " passed" in done.stdout
