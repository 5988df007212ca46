"""A robot of op modes runs in the fixture `sim`: autonomous, teleop and utility, with one digest in two processes."""

from __future__ import annotations

from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

DRIVES = """
import os


def test_op_modes(sim):
    sim.autonomous("Ahead", seconds=2.0)
    begin = sim.pose.x
    assert 0.6 < begin - 2.0 < 1.05
    pad = sim.xbox(0)
    sim.teleop()
    pad.left_y = 0.3
    sim.run(1.0)
    assert 0.5 < begin - sim.pose.x < 1.35
    pad.left_y = 0.0
    sim.utility(seconds=1.5)
    assert 35.0 < sim.pose.rotation().degrees() < 90.0
    with open(os.environ["DIGESTS"], "a") as file:
        file.write(sim.digest + "\\n")
"""


def test_each_op_mode_drives_identically_in_two_runs(project_of, tmp_path):
    if not hasattr(pytest.importorskip("wpilib"), "OpModeRobot"):
        pytest.skip("WPILib of 2026 has no op modes")
    run = project_of(Path(__file__).parent / "robots" / "op_modes")
    digests = tmp_path / "digests"
    for _ in range(2):
        code, said = run(DRIVES, DIGESTS=str(digests))
        assert code == 0, said
    first, second = digests.read_text().split()
    assert first == second
