"""Two numbers hold the size of the house: lines of code of the package, and Python calls in a tick of real use."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

MOST_LINES = 47_950
"""Lines of code of `simcore` without docstrings, comments and blanks. Lower it when it falls; 38,500 is the aim."""
MOST_CALLS = 350
"""Calls of functions of simcore and games in a tick of a robot that drives through pieces."""

_TICK = """
import sys
from pathlib import Path
sys.path.insert(0, "scripts")
import bench
root, calls, ticks = Path.cwd(), 0, 50
inside = (str(root / "simcore"), str(root / "games"))
with bench._match(bench.TimedEngine(), script=bench._lanes) as match:
    match.play(2.0)
    def note(frame, event, arg):
        global calls
        calls += event == "call" and frame.f_code.co_filename.startswith(inside)
    sys.setprofile(note)
    match.play(0.02 * ticks)
    sys.setprofile(None)
print(calls / ticks)
"""


def code_lines(path: Path) -> int:
    """Lines of a file that are neither blank nor comment nor docstring."""
    source = path.read_text(encoding="utf-8")
    words: set[int] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            words.update(range(node.lineno, node.end_lineno + 1))
    lines = [line.strip() for line in source.splitlines()]
    return sum(n not in words and bool(line) and not line.startswith("#") for n, line in enumerate(lines, 1))


def test_the_package_has_no_more_lines_of_code():
    lines = sum(code_lines(path) for path in (ROOT / "simcore").rglob("*.py"))
    assert 0.97 * MOST_LINES < lines <= MOST_LINES, f"{lines} lines of code; a limit far above them holds nothing"


def test_a_tick_makes_no_more_calls():
    done = subprocess.run([sys.executable, "-c", _TICK], cwd=ROOT, capture_output=True, text=True, check=True)
    calls = float(done.stdout.split()[-1])
    assert 0.8 * MOST_CALLS < calls <= MOST_CALLS, f"{calls} calls a tick"
