"""Compiled and in plain Python a game is the same to the last bit, in processes of their own."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from simcore.compiled import store
from simcore.compiled.modules import MODULES

ROOT = Path(__file__).resolve().parents[2]
pytestmark = [pytest.mark.slow, pytest.mark.compiled]

GAME = """
import json, sys
from importlib.machinery import ExtensionFileLoader
from games.rebuilt import REBUILT
from simcore.compiled import finder
from simcore.match.runner import play_auto

run = play_auto(REBUILT, sys.argv[1], seconds=float(sys.argv[2]), alliance=sys.argv[3], seed=7)
run.match.close()
build = finder.installed()
compiled = [name for name, module in list(sys.modules.items())
            if name.startswith("simcore.") and isinstance(getattr(module, "__loader__", None), ExtensionFileLoader)]
print(json.dumps({"digest": run.report.digest, "compiled": compiled, "folder": build and build.folder,
                  "substeps": str(run.report.substeps)}))
"""


def python(code: str, *arguments: str, where: str, package: Path = ROOT, timeout: float = 120) -> str:
    """What a fresh process prints."""
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        env={**os.environ, store.VARIABLE: where, "PYTHONPATH": str(package)},
        cwd=package,
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout


def play(where: str, *arguments: str, package: Path = ROOT) -> dict:
    return json.loads(python(GAME, *arguments, where=where, package=package).splitlines()[-1])


@pytest.mark.parametrize("arguments", [("depot", "4", "blue"), ("neutral", "4", "red")], ids=["depot", "neutral"])
def test_an_auto_is_the_same_to_the_last_bit(compiled_store, arguments):
    plain, compiled = play("0", *arguments), play(compiled_store, *arguments)
    assert plain["folder"] is None and plain["compiled"] == []
    assert compiled["folder"] is not None and len(compiled["compiled"]) > 20
    assert set(compiled["compiled"]) <= set(MODULES)
    assert compiled["digest"] == plain["digest"] and compiled["substeps"] == plain["substeps"]


def test_a_changed_source_is_plain_python(compiled_store, tmp_path):
    """And the change acts: what was compiled before it is not used."""
    for top in ("simcore", "games", "models"):
        shutil.copytree(ROOT / top, tmp_path / top, ignore=shutil.ignore_patterns("__pycache__", "store"))
    same = play(compiled_store, "depot", "0.1", "blue", package=tmp_path)
    assert len(same["compiled"]) > 20
    with (tmp_path / "simcore" / "robot" / "tire_solver.py").open("a") as source:
        source.write("\n# a comment\n")
    changed = play(compiled_store, "depot", "0.1", "blue", package=tmp_path)
    assert changed["compiled"] == [] and changed["digest"] == same["digest"]


def test_every_module_of_the_list_comes_compiled_where_its_vendor_is_there(compiled_store):
    """Imported one by one, in a fresh process."""
    code = (
        "import importlib, sys\n"
        "from importlib.machinery import ExtensionFileLoader\n"
        "from importlib.util import find_spec\n"
        f"for name in {list(MODULES)!r}:\n"
        "    if '.phoenix6' in name and not find_spec('phoenix6') or '.robotpy' in name and not find_spec('pyfrc'):\n"
        "        continue\n"
        "    module = importlib.import_module(name)\n"
        "    assert isinstance(module.__loader__, ExtensionFileLoader), name\n"
        "print('all')"
    )
    assert python(code, where=compiled_store, timeout=60).strip() == "all"
