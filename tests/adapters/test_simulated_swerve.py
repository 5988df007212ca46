"""CTRE's swerve drivetrain in simulated time, against recorded answers of the real library and against the library.

Responses of motors to requests are compared in `emulator/test_recorded.py`.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

REFERENCE = Path(__file__).parent / "swerve_reference.json"
"""Answers of Phoenix 6 26.3.0 on the wall clock: `scenarios/swerve_requests.py real`."""

TOLERANCE = {"1 m/s ahead, open loop": 0.011, "0.5 rad to steer, open loop": 0.011}
"""Tolerance by name. Voltages have steps of 10 mV, feedforwards of 20 mV or 0.2 A; all else 1 mm, 1 mrad, 1 mm/s."""
FAMILIES = {"facing": 0.011, "SysId": 0.011, "forces fed forward, V": 0.021, "forces fed forward, A": 0.21}
"""Tolerance by the beginning of a name."""


@pytest.fixture(scope="module")
def reference():
    return json.loads(REFERENCE.read_text())


@pytest.fixture(scope="module")
def simulated(scenario):
    return scenario("swerve_requests", "simulated")["cases"]


def differences(found, wanted):
    wrong = {}
    for name, numbers in wanted.items():
        family = next((limit for first, limit in FAMILIES.items() if name.startswith(first)), 0.002)
        limit = TOLERANCE.get(name, family)
        gap = max(abs(a - b) for a, b in zip(found[name], numbers, strict=True))
        if gap > limit:
            wrong[name] = (gap, found[name], numbers)
    return wrong


def test_every_request_and_estimate_matches_the_real_library(simulated, reference):
    """Some sixty recorded cases: module targets, motor requests, pose estimates and resets."""
    assert len(reference["cases"]) > 60
    assert differences(simulated, reference["cases"]) == {}


@pytest.mark.realtime
def test_the_recorded_answers_still_match_the_real_library(scenario, reference):
    """If another phoenix6 version drives differently, record again and check the emulator."""
    assert differences(scenario("swerve_requests", "real")["cases"], reference["cases"]) == {}
