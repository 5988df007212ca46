"""REVLib of 2027, which has turns and rpm alone: mechanisms on closed forms, drivetrains over the course."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import simcore

ROBOTS = Path(__file__).parent / "robots"


@pytest.fixture(scope="module")
def library():
    rev = pytest.importorskip("rev")
    if hasattr(rev.SparkMax, "getDeviceId"):
        pytest.skip("this is REVLib of 2026")
    return rev


def test_mechanisms_move_as_closed_forms_say_and_read_in_turns(library, scenario):
    row = scenario("rev_2027")
    assert row["speed"] == pytest.approx(row["expected"], rel=1e-9)
    assert row["rpm"] == pytest.approx(row["speed"] * 2.0 * 60.0 / 6.283185307, rel=1e-6)  # rotor, gear of 2
    assert row["turns"] == pytest.approx(row["shaft"] * 2.0 / 6.283185307, rel=1e-6)
    assert row["azimuth"] == pytest.approx([380.0, 20.0], abs=0.5)  # the short way from 350 degrees
    assert row["centered"] == pytest.approx(-30.0, abs=1e-4)
    assert row["profile"] == pytest.approx([1.25, 10.0, 18.75, 20.0], abs=1e-6)
    assert row["arrived"] == [pytest.approx(20.0, abs=0.05), True]
    assert row["group"] == [1, [0]]
    assert row["followed"][0] > 500.0 and row["followed"][1] == pytest.approx(-row["followed"][0], rel=1e-6)
    assert row["two buses"][0] > 4.0 and row["two buses"][1] == pytest.approx(-0.5 * row["two buses"][0], rel=1e-6)
    assert row["devices"] == ["SPARK MAX can_s1:60", "SPARK MAX 60"]  # port S2 is the bus that needs no name
    # a SPARK follows an id on its own bus
    assert row["groups"] == ["SPARK MAX can_s1:60 + can_s1:59", "SPARK MAX 60 + 59"]


@pytest.mark.slow
@pytest.mark.parametrize("drive", ["tank", "swerve"])
def test_it_finds_its_way_the_same_in_two_processes(drive, library, tmp_path, distribution):
    folder = tmp_path / "robot"
    shutil.copytree(ROBOTS / f"own_{drive}_rev_2027", folder, ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "tests").mkdir()
    shutil.copy(ROBOTS / "shared" / "own_course.py", folder / "tests" / "course_test.py")
    path = os.pathsep.join(map(str, (distribution, Path(simcore.__file__).resolve().parents[1])))
    runs = []
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/course_test.py"],
            cwd=folder, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, timeout=300,
            check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stdout + done.stderr
        runs.append(json.loads((folder / "facts.json").read_text()))
    facts = runs[0]
    assert facts == runs[1]
    assert facts["true"][0] > 5.0 and facts["told"][0] == pytest.approx(facts["true"][0], rel=0.05)
    if drive == "swerve":
        assert facts["told_left"][1] == pytest.approx(facts["true_left"][1], rel=0.05) and facts["true_left"][1] > 1.5
    assert facts["pushed"] > 50 and abs(facts["at_wall"]) < 0.06 and abs(facts["speed_at_wall"]) < 0.01
