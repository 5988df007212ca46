"""How many files somebody has to read to follow one tick."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

MOST = 59
"""Files of simcore and games that a tick enters, seven of them the rules of the game that is played. Lower it when it
falls; 35 is where it should end."""

_TICK = """
import sys
from pathlib import Path
sys.path.insert(0, "scripts")
import bench
with bench._match(bench.TimedEngine(), script=bench._lanes) as match:
    match.play(0.5)
    found = set()
    def note(frame, event, arg):
        if event == "call":
            found.add(frame.f_code.co_filename)
    sys.setprofile(note)
    match.tick()
    sys.setprofile(None)
root = Path.cwd()
for name in sorted(found):
    path = Path(name)
    if path.is_relative_to(root) and path.relative_to(root).parts[0] in ("simcore", "games"):
        print(path.relative_to(root).as_posix())
"""


def entered() -> list[str]:
    """Files whose code runs in a tick of a robot that drives through pieces, without robot code and telemetry."""
    command = [sys.executable, "-c", _TICK]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return done.stdout.split()


def test_a_tick_enters_few_files():
    files = entered()
    assert "simcore/match/match.py" in files and "simcore/match/motion.py" in files
    assert len(files) <= MOST, "\n".join(files)
