"""Every kind of port over the wire: outputs move mechanisms, and sensors read their motion."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

import simcore

FOLDER = Path(__file__).parent
pytestmark = pytest.mark.skipif(find_spec("wpilib") is None, reason="needs wpilib: pip install .[robotpy]")
TICK = 0.02


@pytest.mark.parametrize("gyro", ["ADIS16448_IMU", "AnalogGyro"])
def test_a_program_writes_and_reads_every_kind_of_port(gyro, tmp_path):
    file = tmp_path / "simcore.toml"
    file.write_text((FOLDER / "programs" / "ports.toml").read_text().replace("ADIS16448_IMU", gyro))
    done = subprocess.run(
        [sys.executable, "play_ports.py", str(file), sys.executable, "programs/ports.py"],
        cwd=FOLDER, capture_output=True, text=True, timeout=300, check=False,
        env={**os.environ, "PYTHONPATH": str(Path(simcore.__file__).parents[1])},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    lines = (done.stdout + done.stderr).splitlines()
    truth, reads = (
        json.loads(next(line for line in lines if line.startswith(word)).partition(" ")[2])
        for word in ("TRUTH", "READS")
    )
    # outputs
    assert truth["latch"] == pytest.approx(0.75 * math.pi)
    assert truth["deploy"] == pytest.approx(0.2)
    assert truth["kicks"] > 50.0 and truth["lamp"] is True
    # sensors of the hood at its upper stop, within its motion in a tick
    assert truth["hood"] == pytest.approx(0.5 * math.pi)
    assert reads["absolute"] == pytest.approx(0.25 + 0.25, abs=1e-3)
    assert reads["pulse"] == pytest.approx(2.0 * 0.25, abs=1e-3)
    assert reads["analog"] == pytest.approx(0.25, abs=1e-3)
    assert reads["volts"] == pytest.approx(4.5, abs=0.01)
    assert reads["switch"] is True
    # the gyro, read up to a tick before the end; AnalogGyro was reset halfway and counts clockwise
    heading = math.degrees(truth["heading"])
    if gyro == "AnalogGyro":
        assert 0.5 * heading < -reads["gyro"] < 0.8 * heading
    else:
        assert reads["adis"] == pytest.approx(heading, abs=math.degrees(4.0 * TICK))
    # driver station
    assert (reads["data"], reads["alliance"]) == ("LRL", "Alliance.kRed")
    assert reads["battery"] == pytest.approx(truth["battery"], abs=0.05)
    assert truth["warnings"] == ["the program reports: fifty loops"]
