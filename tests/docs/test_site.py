"""The pages together: all in the navigation, no name in them that does not exist, and a site that needs no network."""

from __future__ import annotations

import argparse
import ast
import builtins
import importlib.util
import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from simcore import cli
from simcore.show import play_command

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.glob("*.md"))]
TEXT = {page.name: page.read_text(encoding="utf-8") for page in PAGES}


def test_every_page_is_in_the_navigation():
    """A new page: take the # away before its line in mkdocs.yml."""
    nav = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    listed = set(re.findall(r"^ +- [^#\n]*: (\w+\.md)$", nav, re.MULTILINE))
    assert listed == {page.name for page in DOCS.glob("*.md")}


# --- what is named exists -------------------------------------------------------------------------------------------


def commands(pattern: str) -> list[tuple[str, list[str]]]:
    """Page and words of each command line, in code blocks and in the text."""
    found = []
    for name, text in TEXT.items():
        for match in re.finditer(rf"(?:^    |`)({pattern}[^`\n#|]*)", text, re.MULTILINE):
            found.append((name, shlex.split(match.group(1))))
    return found


def test_commands_that_play_are_understood():
    parser = argparse.ArgumentParser()
    play_command.add_arguments(parser)
    seen = [
        (page, words[words.index("games.rebuilt") + 1 :])
        for page, words in commands(r"(?:python -m pip install [^&\n]*&& )?python -m games\.rebuilt")
    ]
    seen += [(page, words[2:]) for page, words in commands("simcore play")]
    assert len(seen) > 8
    for page, options in seen:
        try:
            parser.parse_args([word for word in options if word not in ("&&", "...")])
        except SystemExit:
            pytest.fail(f"{page}: {' '.join(options)}")


@pytest.mark.parametrize(
    "page", ["README.md", "first_hour.md", "first_robot.md", "testing.md", "rev.md", "autos.md", "upgrading.md"]
)
def test_command_lines_can_be_pasted_on_windows(page):
    """There `#` is no comment (cmd) and `&&` joins nothing (PowerShell 5)."""
    lines = re.findall(r"^    ((?:python|simcore|git|cd|mkdir) .*)$", TEXT[page], re.MULTILINE)
    assert lines and [line for line in lines if " #" in line or "&&" in line] == []


def test_subcommands_and_modules_exist():
    for page, words in commands("simcore [a-z]"):
        assert words[1] in cli.COMMANDS, f"{page}: {' '.join(words)}"
    for page, words in commands("python -m "):
        if words[2] == "robotpy":  # the extra
            continue
        assert importlib.util.find_spec(words[2]), f"{page}: {' '.join(words)}"


def test_scripts_exist():
    for page, words in commands("python scripts/"):
        assert (ROOT / words[1]).is_file(), f"{page}: {' '.join(words)}"


def test_errors_on_every_page_exist():
    sources = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "simcore").rglob("*.py"))
    ours = set(re.findall(r"^class (\w+Error)\(", sources, re.MULTILINE))
    assert len(ours) > 6
    wrong = [
        f"{name}: {error}"
        for name, text in TEXT.items()
        for error in re.findall(r"`(\w+Error)[`:]", text)
        if error not in ours and not hasattr(builtins, error)
    ]
    assert wrong == []


def said_by_the_code() -> str:
    """All text in the sources, pieces of one message joined, a blank where a value goes."""
    said = []
    for folder in ("simcore", "games"):
        for path in (ROOT / folder).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.JoinedStr):
                    parts = [str(p.value) if isinstance(p, ast.Constant) else " " for p in node.values]
                    said.append("".join(parts))
                elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                    said.append(re.sub(r"%[.\d]*[a-z]", " ", node.value))
    return re.sub(r"\s+", " ", "\n".join(said))


def test_messages_that_troubleshooting_quotes_are_said_by_the_code():
    quotes = re.findall(r"^### .*?`(?:\w+Error: )?([^`]+)`", TEXT["troubleshooting.md"], re.MULTILINE)
    others = (
        "GLFW Error",
        "address already in use",
        "TypeError",
        "isBrownedOut",
        "robotInit",
        "--no-isolation",
        "CapacityError",
        "mass must be a number",  # put together from the name of a field and what its quantity may be
        "cannot write the log",  # put together from "cannot write the" and what it is
    )
    said = said_by_the_code()
    missing = []
    for quote in quotes:
        pieces = [piece.strip(" '") for piece in re.split(r"\.\.\.|\d[\d.:]*", quote)]
        longest = max(pieces, key=len)
        if not quote.startswith(others) and longest not in said:
            missing.append(quote)
    assert missing == []
    assert len(quotes) > 12


def test_every_row_of_the_java_documents_has_its_answer():
    rows = TEXT["troubleshooting.md"].partition("## Coming from the Java simulator")[2].partition("\n## ")[0]
    for words in ("does not move", "through the floor", "tunnel", "ClassNotFoundException", "slow", "Encoder", "LFS"):
        assert re.search(rf"^\| [^|]*{words}[^|]*\| \[[^\]]+\]\(#[\w-]+\)", rows, re.MULTILINE), words


def test_keys_of_the_driving_page_are_those_of_the_example():
    keyboard = json.loads((ROOT / "examples/rebuilt_robot/simgui-ds.json").read_text())["keyboardJoysticks"][0]
    names = {44: "comma", 46: "period", 47: "slash"}
    axes = [axis[key] for axis in keyboard["axisConfig"] for key in ("decKey", "incKey") if key in axis]
    codes = [*axes, *keyboard["buttonKeys"]]
    table = re.findall(r"^\| ([^|]*) \|", TEXT["view.md"], re.MULTILINE)
    described = {word.strip(",") for cell in table for word in cell.split()}
    assert {names.get(code, chr(code)) for code in codes if code > 0} - described == set()


# --- the site -------------------------------------------------------------------------------------------------------


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
"""What students type into the search."""


def not_found(index: dict) -> list[str]:
    """Those of which no section has all words."""
    sections = [f"{entry['title']} {entry['text']}".lower() for entry in index["docs"]]
    return [typed for typed in TYPED if not any(all(w in text for w in typed.split()) for text in sections)]


@pytest.mark.skipif(importlib.util.find_spec("material") is None, reason='needs the extra: pip install -e ".[docs]"')
def test_the_site_builds_without_a_warning_and_loads_nothing_from_elsewhere(tmp_path):
    build = subprocess.run(  # never with --quiet: what is not said is not counted either
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
