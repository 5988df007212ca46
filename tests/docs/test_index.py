"""Drawings on the first page agree with the code: packages by imports, files on the path of a command and a ball."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")


def drawn() -> dict[str, set[str]]:
    """Return the packages of the drawing, each with the packages that it uses."""
    found: dict[str, set[str]] = {}
    for line in PAGE.partition("```text\n")[2].partition("```")[0].splitlines():
        name, _, used = line.partition("<-")
        depth, name = re.match(r"(\W*)(\w+)", name).groups()
        inside = "robotcode." if len(depth) == 12 else ""
        if name != "robotcode":
            found[inside + name] = {one.strip() for one in used.split(",") if used}
    parts = {name.partition(".")[2]: name for name in found if "." in name}
    return {name: {parts.get(one, one) for one in used} for name, used in found.items()}


def test_the_tree_of_packages_agrees_with_the_imports(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "tests" / "architecture")
    from test_imports import ALLOWED, BASE

    sys.modules.pop("test_imports")
    tree = drawn()
    assert set(tree) == set(ALLOWED) - BASE - {"cli", "__main__"}
    reached: dict[str, set[str]] = {}
    for name, used in tree.items():
        order = [*tree].index(name)
        assert all([*tree].index(one) < order or name == "show" for one in used), f"{name} uses what is below it"
    for name in tree:
        queue = [*tree[name]]
        reached[name] = set()
        while queue:
            one = queue.pop()
            if one not in reached[name]:
                reached[name].add(one)
                queue += tree[one]
        assert tree[name] <= ALLOWED[name], f"{name}: an arrow too many"
        assert ALLOWED[name] - BASE - {name} <= reached[name], f"{name}: an arrow is missing"


@pytest.mark.parametrize("way", ["a command", "a ball"])
def test_the_functions_on_each_path_are_in_their_files(way):
    section = PAGE.partition(f"### The way of {way}\n")[2].partition("\n#")[0]
    rows = re.findall(r"^\| `([\w/]+\.py)` \| (.+?) \| ", section, re.MULTILINE)
    assert 20 <= len(rows) <= 25
    for file, functions in rows:
        path = ROOT / file if file.startswith("games/") else ROOT / "simcore" / file
        source = path.read_text(encoding="utf-8")
        for name in re.findall(r"`(\w+)`", functions):
            assert re.search(rf"def {name}\(", source), f"{file}: {name}"


def test_the_files_listed_under_where_to_look_exist():
    section = PAGE.partition("### Where to look\n")[2].partition("\n#")[0]
    files = re.findall(r"`([\w/]+\.py)`", section)
    assert len(files) > 10
    for file in files:
        assert any((ROOT / folder / file).is_file() for folder in ("", "simcore")), file
