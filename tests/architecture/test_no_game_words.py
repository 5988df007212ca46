"""simcore works with any game: it has no word and no number of one year's game."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from each_case import each

ROOT = Path(__file__).resolve().parents[2]
OWN = (path for kind in ("py", "js", "css", "html") for path in (ROOT / "simcore").rglob(f"*.{kind}"))
SOURCES = sorted(path for path in OWN if path.parent.name != "vendor")

WORDS = re.compile(
    r"\w*fuel\w*|rebuilt\w*|\bhubs?\b|\w+_hub\b|(?:red|blue)_?hub\w*|reefscape|\bcorals?\b|\balgae\b"
    r"|\b16\.54\d*\b|\b8\.07\b|\b8\.069\d*\b",
    re.IGNORECASE,
)
YEAR = "2026"
"""Year that comments and docstrings may give as part of a source or version, but values and names may not."""

TABLE = "simcore/vision/tag_layout.py"
"""Table of tag layouts, which WPILib names after their games."""

WINDOWS = ("simcore/show/scope_layout.py", '"hubs"')
"""AdvantageScope's word for its windows."""

STILL_ALLOWED = {
    "simcore/robotcode/makers/phoenix6/__init__.py",
    "simcore/robot/chassis.py",
    "simcore/robot/chassis_config.py",
}
"""Files that may still contain game words; the set should become empty."""


def values_and_names(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Yield line and text of every name and every constant that is not a docstring."""
    docs = {
        id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and id(node) not in docs:
            yield node.lineno, str(node.value)
        elif isinstance(node, ast.Name):
            yield node.lineno, node.id
        elif isinstance(node, ast.Attribute):
            yield node.lineno, node.attr
        elif isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            yield node.lineno, node.name


def found_in(path: Path) -> list[str]:
    name = path.relative_to(ROOT).as_posix()
    if name == TABLE:
        return []
    text = path.read_text(encoding="utf-8")
    found = [
        f"{name}:{number}: {match[0]}"
        for number, line in enumerate(text.split("\n"), 1)
        for match in WORDS.finditer(line)
        if "github" not in match[0].lower() and (name, line[match.start() - 1 : match.end() + 1]) != WINDOWS
    ]
    if path.suffix == ".py":
        found += [f"{name}:{line}: {part}" for line, part in values_and_names(ast.parse(text)) if YEAR in part]
    return found


@each("package", sorted({path.relative_to(ROOT).parts[1] for path in SOURCES}))
def test_simcore_contains_no_word_of_a_specific_game(package: str) -> None:
    found = [
        line
        for path in SOURCES
        if path.relative_to(ROOT).parts[1] == package and path.relative_to(ROOT).as_posix() not in STILL_ALLOWED
        for line in found_in(path)
    ]
    assert found == []


def test_the_search_finds_game_words_but_ignores_urls_and_other_numbers() -> None:
    for bad in (
        "fuel_start",
        "# Rebuilt",
        "blue_hub",
        "RedHubActive",
        "(16.541, 8.069)",
        "x = 16.54",
        "a hub",
        "coral",
    ):
        assert WORDS.search(bad), bad
    for good in ("# from https://github.com/x", "GitHub", "thub", "116.54", "8.0712"):
        assert all("github" in match[0].lower() for match in WORDS.finditer(good)), good
    year = [part for _, part in values_and_names(ast.parse('"""Of 2026."""\nyear = 2026  # 2026\n')) if YEAR in part]
    assert year == ["2026"]
