"""Robot tests in simulated time, compiled and in plain Python: the same to the last bit."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

pytestmark = [pytest.mark.slow, pytest.mark.compiled]

ROOT = Path(__file__).resolve().parents[2]
AUTO = """
import sys
from importlib.machinery import ExtensionFileLoader

def test_auto(sim):
    sim.autonomous("depot", seconds=6)
    loaded = [n for n, m in list(sys.modules.items())
              if n.startswith("simcore.") and isinstance(getattr(m, "__loader__", None), ExtensionFileLoader)]
    print("DIGEST", sim.digest, "COMPILED", len(loaded), "EMULATOR", sum("emulator" in n for n in loaded))
"""


def test_a_robot_test_is_the_same_to_the_last_bit(project, distribution, compiled):
    told = []
    for package in (ROOT, compiled):
        code, output = project(AUTO, "-rP", PYTHONPATH=os.pathsep.join(map(str, (distribution, package))))
        assert code == 0, output[-3000:]
        told.append(re.search(r"DIGEST (\w+) COMPILED (\d+) EMULATOR (\d+)", output).groups())
    (plain, none, _), (native, many, devices) = told
    assert int(none) == 0 and int(many) > 50 and int(devices) > 20
    assert native == plain
