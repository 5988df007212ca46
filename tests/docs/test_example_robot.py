"""The page that walks through a whole robot shows what is in its files, word for word."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "example_robot.md"
PROJECT = ROOT / "examples" / "reefscape_robot"


@pytest.mark.parametrize(("language", "at_least"), [("toml", 3), ("py", 2)])
def test_every_block_of_the_page_is_in_a_file_of_the_project(language, at_least):
    blocks = re.findall(rf"^```{language}\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    files = [path.read_text(encoding="utf-8") for path in PROJECT.rglob(f"*.{language}")]
    assert len(blocks) >= at_least
    for block in blocks:
        assert any(block in text for text in files), block
