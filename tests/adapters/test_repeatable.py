"""Two runs of a restless robot, one of them on a computer with four busy processes more, agree to the last bit."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

RESTLESS = Path(__file__).parent / "robots" / "restless"
TEST = """
import os

def test_it(sim):
    sim.autonomous(seconds=0.4)
    order = sim.robot.order
    assert len(order) > 100 and order == [0, 1, 2, 3] * (len(order) // 4)  # meeting at every instant, always so
    assert sim.robot.begin == 1_700_000_000.0  # its clocks are the robot's
    with open(os.environ["DIGESTS"], "a") as file:
        file.write(f"{sim.digest} {sim.battery.min_voltage!r}\\n")
"""


def test_a_busy_computer_changes_no_bit(project_of, tmp_path):
    run, digests = project_of(RESTLESS), tmp_path / "digests"
    code, said = run(TEST, DIGESTS=str(digests))
    assert code == 0, said
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(4)]
    try:
        code, said = run(TEST, command=("-m", "robotpy", "test"), DIGESTS=str(digests))
    finally:
        for process in busy:
            process.kill()
            process.wait()
    assert code == 0, said
    quiet, loaded = digests.read_text().splitlines()
    assert quiet == loaded
