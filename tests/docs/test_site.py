"""The site works offline, its search finds what students type, and messages quoted on the pages exist."""

from __future__ import annotations

import importlib.util
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
TROUBLES = (ROOT / "docs" / "troubleshooting.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def said() -> str:
    """Return the text of all sources with adjacent string literals joined."""
    text = "\n".join(
        path.read_text("utf-8") for folder in ("simcore", "games") for path in (ROOT / folder).rglob("*.py")
    )
    return re.sub(r"\s+", " ", re.sub(r'"\s+f?"', "", text))


def test_messages_quoted_in_troubleshooting_are_in_the_code(said):
    quotes = re.findall(r"^### .*?`(?:\w+Error: )?([^`]+)`", TROUBLES, re.MULTILINE)
    others = (
        *("GLFW Error", "address already in use", "TypeError", "isBrownedOut", "robotInit", "--no-isolation"),
        *("simcore init", "robotpy test", "CapacityError"),  # commands and names
        "CAN message is stale",  # of CTRE's library
        "mass must be a number",  # put together from the name of a field and what its quantity may be
        "cannot write the log",  # put together from "cannot write the" and what it is
    )
    assert [quote for quote in quotes if not quote.startswith(others) and not is_said(quote, said)] == []
    assert len(quotes) > 12


@pytest.mark.parametrize("page", ["connect.md", "testing.md"])
def test_messages_quoted_in_tables_of_problems_are_in_the_code(page, said):
    table = (ROOT / "docs" / page).read_text(encoding="utf-8").partition("## When it does not work")[2]
    rows = re.findall(r"^\| (`[^|]+) \|", table, re.MULTILINE)
    others = ("fixture 'sim'", "subprocess exited")  # from pytest and pyfrc
    quotes = [quote for row in rows for quote in re.findall(r"`([^`]+)`", row) if " " in quote]
    assert [quote for quote in quotes if not quote.startswith(others) and not is_said(quote, said)] == []
    assert len(quotes) > 6


def is_said(quote: str, said: str) -> bool:
    """Return whether three successive words of a quote (or all of fewer words) are in the sources."""
    words = quote.replace("...", " ").split()
    runs = [" ".join(words[i : i + 3]) for i in range(max(1, len(words) - 2))]
    return any(run in said for run in runs)


def test_every_problem_from_the_java_documents_has_an_answer():
    rows = TROUBLES.partition("## Coming from the Java simulator")[2].partition("\n## ")[0]
    for words in ("does not move", "through the floor", "tunnel", "ClassNotFoundException", "slow", "Encoder", "LFS"):
        assert re.search(rf"^\| [^|]*{words}[^|]*\| \[[^\]]+\]\(#[\w-]+\)", rows, re.MULTILINE), words


TYPED = (
    *("brownout", "brown-out", "odometry drift", "wheel slip", "navx", "pigeon", "cancoder", "sysid", "feedforward"),
    *("pathplanner", "choreo", "starting pose", "trajectory", "limelight", "photonvision", "questnav", "apriltag"),
    *("spark max", "maxswerve", "tank drive", "mecanum", "turret", "beam break", "pneumatics", "current limit"),
    *(
        "elastic",
        "glass",
        "shuffleboard",
        "gamepad",
        "keyboard",
        "defense",
        "opponent",
        "upgrade",
        "install",
        "windows",
    ),
)
"""Words that students type into the search."""


def not_found(index: dict) -> list[str]:
    """Return typed words that no section contains in full."""
    sections = [f"{entry['title']} {entry['text']}".lower() for entry in index["docs"]]
    return [typed for typed in TYPED if not any(all(w in text for w in typed.split()) for text in sections)]


@pytest.mark.skipif(importlib.util.find_spec("material") is None, reason='needs the extra: pip install -e ".[docs]"')
def test_the_site_builds_without_a_warning_and_loads_nothing_from_other_hosts(tmp_path):
    build = subprocess.run(  # never with --quiet, which also suppresses counting
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(tmp_path / "site")],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert build.returncode == 0, build.stdout + build.stderr
    loads = re.compile(
        r"""<(?:script|img|iframe|source)\b[^>]*\bsrc=["']?(?:https?:)?//"""
        r"""|<link\b(?=[^>]*rel=["']?(?:stylesheet|preconnect|preload|icon))[^>]*href=["']?(?:https?:)?//"""
        r"""|@import\s+(?:url\()?["']?(?:https?:)?//|url\(["']?(?:https?:)?//""",
        re.IGNORECASE,
    )
    pages = list((tmp_path / "site").rglob("*.html"))
    assert len(pages) > 8
    wrong = [
        f"{file.name}: {match.group()}"
        for file in [*pages, *(tmp_path / "site").rglob("*.css")]
        for match in loads.finditer(file.read_text(encoding="utf-8"))
    ]
    assert wrong == []
    assert not_found(json.loads((tmp_path / "site" / "search" / "search_index.json").read_text(encoding="utf-8"))) == []
    assert loads.search('<link rel="stylesheet" href="https://fonts.example/x.css">'), (
        "the search finds what it looks for"
    )
