"""REVLib 2027, which uses only turns and RPM: mechanisms against closed forms, drivetrains over their legs."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

ROBOTS = Path(__file__).parent / "robots"


@pytest.fixture(scope="module")
def library():
    rev = pytest.importorskip("rev")
    if hasattr(rev.SparkMax, "getDeviceId"):
        pytest.skip("this is REVLib of 2026")
    return rev


def test_mechanisms_follow_closed_forms_and_are_measured_in_turns(library, scenario):
    row = scenario("rev_2027")
    assert row["speed"] == pytest.approx(row["expected"], rel=1e-9)
    assert row["rpm"] == pytest.approx(row["speed"] * 2.0 * 60.0 / 6.283185307, rel=1e-6)  # rotor, with a gearing of 2
    assert row["turns"] == pytest.approx(row["shaft"] * 2.0 / 6.283185307, rel=1e-6)
    assert row["azimuth"] == pytest.approx([380.0, 20.0], abs=0.5)  # the short way from 350 degrees
    assert row["centered"] == pytest.approx(-30.0, abs=1e-4)
    assert row["profile"] == pytest.approx([1.25, 10.0, 18.75, 20.0], abs=1e-6)
    assert row["arrived"] == [pytest.approx(20.0, abs=0.05), True]
    assert row["group"] == [1, [0]]
    assert row["followed"][0] > 500.0 and row["followed"][1] == pytest.approx(-row["followed"][0], rel=1e-6)
    assert row["two buses"][0] > 4.0 and row["two buses"][1] == pytest.approx(-0.5 * row["two buses"][0], rel=1e-6)
    assert row["devices"] == ["SPARK MAX can_s1:60", "SPARK MAX 60"]  # port S2 is the default bus, which has no name
    # a SPARK follows an id on its own bus
    assert row["groups"] == ["SPARK MAX can_s1:60 + can_s1:59", "SPARK MAX 60 + 59"]


@pytest.mark.slow
@pytest.mark.parametrize("drive", ["tank", "swerve"])
def test_odometry_is_accurate_and_equal_in_two_processes(drive, library, project_of):
    run = project_of(ROBOTS / f"own_{drive}_rev_2027")
    legs = {"tank": "TANK", "swerve": "HOLONOMIC"}[drive]
    runs = []
    for _ in range(2):
        code, said = run(f"import legs\n\n\ndef test_course(sim):\n    legs.drive(sim, legs.{legs})\n")
        assert code == 0, said
        runs.append(json.loads((run.folder / "facts.json").read_text()))
    assert runs[0] == runs[1]
    for leg in ("ahead",) if drive == "tank" else ("ahead", "left"):
        true, told, _ = runs[0]["legs"][leg]
        assert true > 0.8 and told == pytest.approx(true, rel=0.05)
    assert runs[0]["legs"]["turn"][2] > 0.5
