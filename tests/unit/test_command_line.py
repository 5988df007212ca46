"""The command without a subcommand, the version in all its places, and scripts that only ask for help."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import simcore
from simcore.cli import COMMANDS, main

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = sorted((ROOT / "scripts").glob("*.py"))


def test_alone_it_prints_its_help_and_all_is_well(capsys):
    assert main([]) == 0
    said = capsys.readouterr().out
    assert said.startswith("usage: simcore") and all(f"\n    {name}" in said for name in COMMANDS)


def test_the_version_is_the_same_everywhere(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--version"])
    assert ended.value.code == 0 and capsys.readouterr().out == f"simcore {simcore.__version__}\n"
    declared = re.search(r'^version = "(.+)"$', (ROOT / "pyproject.toml").read_text(encoding="utf-8"), re.MULTILINE)
    newest = re.search(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert declared[1] == newest[1] == simcore.__version__


def test_a_list_of_commands_loads_nothing_heavy():
    code = (
        "import sys; from simcore.cli import main; main([]);"
        "assert not {'numpy', 'scipy', 'trimesh', 'rich', 'wpimath', 'matplotlib'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True, capture_output=True, timeout=60)


@pytest.mark.parametrize("name", ["generate_rebuilt_field", "make_layout"])
def test_help_of_a_script_writes_nothing(name):
    models = {path: path.stat().st_mtime_ns for path in (ROOT / "models").rglob("*")}
    words = [sys.executable, str(ROOT / "scripts" / f"{name}.py"), "--help"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0 and done.stdout.startswith("usage: "), done.stderr
    assert {path: path.stat().st_mtime_ns for path in (ROOT / "models").rglob("*")} == models


def test_every_script_has_a_help():
    assert [path.name for path in SCRIPTS if "parse_args(" not in path.read_text(encoding="utf-8")] == []
