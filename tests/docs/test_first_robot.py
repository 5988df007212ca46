"""The page that a newcomer follows, and the robot that comes of it, are one: examples/first_robot."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "first_robot.md"
PROJECT = ROOT / "examples" / "first_robot"

FILE = re.compile(r"^`([\w/.-]+\.\w+)`")
OPEN, CLOSE = re.compile(r"^```(py|json)$"), "```"


def files_of(page: Path) -> Iterator[tuple[str, str]]:
    """Each block with the file that was last named at the beginning of a line."""
    name, block = "", None
    for line in page.read_text(encoding="utf-8").splitlines(keepends=True):
        if block is not None:
            if line.rstrip() == CLOSE:
                yield name, block
                block = None
            else:
                block += line
        elif found := FILE.match(line):
            name = found[1]
        elif OPEN.match(line):
            block = ""


def test_the_example_is_what_the_page_prints():
    printed = dict(files_of(PAGE))
    assert sorted(printed) == ["physics.py", "robot.py", "simgui-ds.json", "tests/drive_test.py"]
    for name, block in printed.items():
        assert (PROJECT / name).read_text(encoding="utf-8") == block, f"{name} of the page and of {PROJECT} differ"


def test_the_example_has_nothing_that_the_page_does_not_tell_of():
    left_by_runs = (
        "ctre_sim",
        "__pycache__",
        ".pytest_cache",
        "simgui.json",
        "simgui-window.json",
        "networktables.json",
    )
    ours = {path.relative_to(PROJECT) for path in PROJECT.rglob("*") if path.is_file()}
    ours = {path.as_posix() for path in ours if not set(path.parts) & set(left_by_runs)}
    assert ours == {*dict(files_of(PAGE)), "pyproject.toml"}
    requires = 'requires = ["phoenix6>=26.1,<27"]'
    assert requires in PAGE.read_text(encoding="utf-8") and requires in (PROJECT / "pyproject.toml").read_text()
