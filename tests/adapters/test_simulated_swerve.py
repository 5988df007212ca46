"""CTRE's swerve drivetrain in simulated time, against what the real one answered and against the real one itself."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

REFERENCE = Path(__file__).parent / "swerve_reference.json"
"""What Phoenix 6 26.3.0 answered on the wall clock: `scenarios/swerve_requests.py real`, `swerve_path.py real`."""

TOLERANCE = {"1 m/s ahead, open loop": 0.011, "0.5 rad to steer, open loop": 0.011}
"""A voltage is told in steps of 10 mV, a feed-forward in steps of 20 mV or 0.2 A; everything else is known to 1 mm,
1 mrad, 1 mm/s."""
FAMILIES = {"facing": 0.011, "SysId": 0.011, "forces fed forward, V": 0.021, "forces fed forward, A": 0.21}
"""The same by the beginning of a name."""


@pytest.fixture(scope="module")
def reference():
    return json.loads(REFERENCE.read_text())


@pytest.fixture(scope="module")
def simulated(scenario):
    return scenario("swerve_requests", "simulated")["cases"]


@pytest.fixture(scope="module")
def path(scenario):
    return scenario("swerve_path", "simulated")


def differences(found, wanted):
    wrong = {}
    for name, numbers in wanted.items():
        family = next((limit for first, limit in FAMILIES.items() if name.startswith(first)), 0.002)
        limit = TOLERANCE.get(name, family)
        gap = max(abs(a - b) for a, b in zip(found[name], numbers, strict=True))
        if gap > limit:
            wrong[name] = (gap, found[name], numbers)
    return wrong


def test_every_request_and_belief_is_the_real_one(simulated, reference):
    """Module targets, motor requests, estimator, resets: some sixty cases, recorded from the real library."""
    assert len(reference["cases"]) > 60
    assert differences(simulated, reference["cases"]) == {}


def test_an_s_of_four_meters_ends_where_the_real_one_did(path, reference):
    """At every instant no further from the mean of the real clock's paths than those end from one another.

    CTRE's simulation holds volts between two steps of physics and learns a rotor's speed late: a steer motor that spins
    up gets 39 A of its limit of 60 A. The model keeps the limit itself, so wheels turn faster into the curve.
    """
    gaps = [math.dist(a[:2], b[:2]) for a, b in zip(path["path"], reference["path"], strict=True)]
    assert sum(math.dist(a[:2], b[:2]) for a, b in zip(path["path"], path["path"][1:], strict=False)) > 3.8
    assert max(gaps) < 0.240


def test_responses_are_those_of_the_real_clock(path, reference):
    """Time to 90 %, overshoot and end of a step of every request that drives.

    Where wheels must turn, chance decides how a request meets the encoders' frames: the mean over real runs beside the
    mean over delays of the request. The real runs drove the drivetrain before its steps became of second order, which
    starts up to 40 ms earlier where wheels turn first: until they are recorded anew, 45 ms instead of 20. All four
    wheels turn by 45 degrees first only before a rotation by volts: there the steer motors' limit decides, see above.
    """
    assert len(reference["responses"]) == len(path["responses"]) > 10
    for name, (rise, peak, end) in reference["responses"].items():
        found = path["responses"][name]
        turns_first = name.startswith("SysIdSwerveRotation")
        assert found[0] == pytest.approx(rise, abs=0.090 if turns_first else 0.045), name
        assert found[1] == pytest.approx(peak, abs=0.03), name
        assert found[2] == pytest.approx(end, rel=0.015 if turns_first else 0.005), name


def test_two_processes_agree_to_the_last_bit(path, scenario):
    again = scenario("swerve_path", "simulated")
    assert again["path"] == path["path"]
    assert again["responses"] == path["responses"]


@pytest.mark.realtime
def test_the_reference_is_still_what_the_real_one_answers(scenario, reference):
    """Fails when another version of phoenix6 drives differently: then record anew and look at the emulator."""
    assert differences(scenario("swerve_requests", "real")["cases"], reference["cases"]) == {}
