"""Statements of the pages hold: Python code runs as printed, TOML tables are read, links work."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from simcore.robot_file.reader import read_settings

ROOT = Path(__file__).resolve().parents[2]
ROOTS = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")]
PAGES = [*ROOTS, *sorted((ROOT / "examples").glob("*/README.md")), *sorted((ROOT / "docs").glob("*.md"))]
TEXT = {page: page.read_text(encoding="utf-8") for page in PAGES}

TOML = re.compile(r"^```toml\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FENCE = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\[[^\]]+\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ (.+)$", re.MULTILINE)


def blocks():
    for page, text in TEXT.items():
        for match in FENCE.finditer(text):
            line = text.count("\n", 0, match.start(1))
            yield pytest.param(page, line, match.group(1), id=f"{page.name}:{line + 1}")


def anchor(heading: str) -> str:
    """Return a heading's anchor as GitHub makes it: lower case, no punctuation, dashes for spaces."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


@pytest.mark.parametrize(("page", "line", "source"), list(blocks()))
def test_python_code_on_a_page_runs_as_printed(page, line, source, tmp_path, monkeypatch):
    """The code runs in an empty folder because some of it writes files; a failure shows the line of the page."""
    monkeypatch.chdir(tmp_path)
    code = compile("\n" * line + source, str(page), "exec")
    exec(code, {"__name__": "docs"})


def test_toml_code_on_a_page_is_read_without_an_error(tmp_path):
    """Except for a pyproject.toml, each block is a whole simcore.toml or some tables of one."""
    file = tmp_path / "simcore.toml"
    count = 0
    for text in (block for page in TEXT.values() for block in TOML.findall(page) if "[project" not in block):
        file.write_text(text, encoding="utf-8")
        read_settings(file)  # raises an error that quotes the table
        count += 1
    assert count >= 4


def test_all_links_have_a_target():
    anchors = {page.resolve(): {anchor(heading) for heading in HEADING.findall(text)} for page, text in TEXT.items()}
    broken = []
    for page, text in TEXT.items():
        for target in LINK.findall(text):
            if target.startswith(("http://", "https://")):
                continue
            name, _, section = target.partition("#")
            file = (page.parent / name).resolve() if name else page.resolve()
            if not file.exists() or (section and section not in anchors[file]):
                broken.append(f"{page.name}: {target}")
    assert broken == []


def test_pages_named_in_the_code_exist():
    """Pages are named in messages, docstrings and comments."""
    missing = set()
    for folder in ("simcore", "games", "scripts", "examples", "tests"):
        for file in (ROOT / folder).rglob("*.*"):
            if file.suffix in (".py", ".md", ".toml"):
                named = re.findall(r"\bdocs/(\w+\.md)", file.read_text(encoding="utf-8"))
                missing |= {f"{file.name}: {name}" for name in named if not (ROOT / "docs" / name).exists()}
    assert missing == set()


def test_ci_names_existing_files_and_runs_the_commands_of_the_readme():
    """A stage that names a missing file would fail before its first test."""
    stages, readme = ((ROOT / name).read_text(encoding="utf-8") for name in (".ci/run", "README.md"))
    folders = "|".join(path.name for path in ROOT.iterdir() if path.is_dir())
    named = re.findall(rf"(?<![\w./$-])((?:{folders})/[\w./-]*\w)", stages)
    assert len(named) > 10 and [name for name in named if not (ROOT / name).exists()] == []
    for command in ("-m pip install ", '-e ".[test]"', "-m pytest ", "-m games.rebuilt"):
        assert command in stages and readme.count(command) >= 2, f"{command}: in .ci/run, and for two kinds of shells"


def test_pre_commit_runs_the_same_lint_as_ci():
    lint = (ROOT / ".ci/run").read_text(encoding="utf-8").partition('stage "lint and types"')[2].partition("stage")[0]
    hooks = (ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8")
    commands = [line for line in lint.splitlines() if line.startswith("python -m ") and "pip" not in line]
    assert len(commands) == 3 and re.findall(r"entry: (.+)", hooks) == commands


def test_every_page_is_in_the_navigation_and_linked_from_the_index():
    pages = {page.name for page in PAGES if page.parent == ROOT / "docs"} - {"index.md"}
    nav = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    assert set(re.findall(r"^ +- [^#\n]*: (\w+\.md)$", nav, re.MULTILINE)) - {"index.md"} == pages
    linked = {target.partition("#")[0] for target in LINK.findall(TEXT[ROOT / "docs" / "index.md"])}
    assert pages - linked <= {"clusters.md", "tuning.md", "pictures.md"}
