"""The page "first hour" agrees with its example: figures, files and keys."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from simcore.cli import main

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "first_hour.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("engine", ["", "mujoco"])
def test_the_first_run_prints_the_text_on_the_page_and_writes_its_files(engine, whole, tmp_path, monkeypatch, capsys):
    """The text agrees to the last digit; with --whole, on both engines."""
    if engine:
        if not whole:
            pytest.skip("the same on the other engine: with --whole")
        pytest.importorskip("mujoco", reason='needs MuJoCo: pip install -e ".[test]"')
    monkeypatch.chdir(tmp_path)
    assert main(["play", *(["--engine", engine] if engine else [])]) == 0
    shown = re.search(r"^    (╭.*\n)    (│.*\n)    (╰.*\n)", PAGE, re.MULTILINE)
    assert "".join(shown.groups()) in capsys.readouterr().out
    files = re.findall(r"^\| `(depot\.\w+)` \|", PAGE, re.MULTILINE)
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == sorted(files)


def test_the_keyboard_keys_on_the_page_match_the_example():
    keyboard = json.loads((ROOT / "examples/rebuilt_robot/simgui-ds.json").read_text())["keyboardJoysticks"][0]
    names = {44: "comma", 46: "period", 47: "slash"}
    axes = [axis[key] for axis in keyboard["axisConfig"] for key in ("decKey", "incKey") if key in axis]
    codes = [*axes, *keyboard["buttonKeys"]]
    table = re.findall(r"^\| ([^|]*) \|", PAGE, re.MULTILINE)
    described = {word.strip(",") for cell in table for word in cell.split()}
    assert {names.get(code, chr(code)) for code in codes if code > 0} - described == set()
