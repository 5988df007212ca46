"""What the pages say works: Python blocks run as printed, links lead somewhere."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from simcore.robot_file.reader import read_settings

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]

TOML = re.compile(r"^```toml\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FENCE = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\[[^\]]+\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ (.+)$", re.MULTILINE)


def blocks():
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for match in FENCE.finditer(text):
            line = text.count("\n", 0, match.start(1))
            yield pytest.param(page, line, match.group(1), id=f"{page.name}:{line + 1}")


def anchor(heading: str) -> str:
    """As GitHub makes it: lower case, punctuation dropped, blanks to dashes."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


@pytest.mark.parametrize(("page", "line", "source"), list(blocks()))
def test_a_python_block_runs_as_printed(page, line, source, tmp_path, monkeypatch):
    """In an empty folder, because some write files; failures show the line of the page.

    Recipes with somebody else's library are skipped where it is not installed.
    """
    monkeypatch.chdir(tmp_path)
    code = compile("\n" * line + source, str(page), "exec")
    try:
        exec(code, {"__name__": "docs"})
    except ModuleNotFoundError as error:
        if error.name not in ("SALib", "optuna", "pandas"):
            raise
        pytest.skip(f"{error.name} is not installed")


def test_every_toml_block_is_understood(tmp_path):
    """But for a pyproject.toml, each is a whole simcore.toml, or tables that one may have."""
    file = tmp_path / "simcore.toml"
    count = 0
    for page in PAGES:
        for text in TOML.findall(page.read_text(encoding="utf-8")):
            if "[project" in text:
                continue  # a pyproject.toml
            file.write_text(text, encoding="utf-8")
            read_settings(file)  # raises a sentence that quotes the table
            count += 1
    assert count >= 4


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    broken = []
    for target in LINK.findall(page.read_text(encoding="utf-8")):
        if target.startswith(("http://", "https://")):
            continue
        name, _, section = target.partition("#")
        file = (page.parent / name).resolve() if name else page
        if not file.exists():
            broken.append(target)
        elif section and section not in map(anchor, HEADING.findall(file.read_text(encoding="utf-8"))):
            broken.append(target)
    assert broken == []


def test_every_page_is_reached_from_the_index():
    index = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    missing = [page.name for page in PAGES if page.parent == ROOT / "docs" and page.name not in index]
    assert missing == ["index.md"]
