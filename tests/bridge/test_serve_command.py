"""`simcore serve`: a whole auto of a C++ robot, its files, expectations and refusals."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

import simcore
from simcore.errors import ConfigError
from simcore.robot_file.reader import read_settings

PROGRAMS = Path(__file__).parent / "programs"
pytestmark = pytest.mark.skipif(find_spec("wpilib") is None, reason="needs wpilib: pip install .[robotpy]")
TANK_FOLDER = Path(__file__).parents[2] / "examples" / "cpp_tank"
PACKAGES = str(Path(simcore.__file__).resolve().parents[1])
TANK = [sys.executable, str(PROGRAMS / "tank.py")]


@pytest.mark.slow
def test_a_cpp_robot_takes_fuel_in_shoots_and_scores(compiled, serve, tmp_path):
    """The auto is chosen on the program's dashboard; a fuel scores one point while the hub is active."""
    status, out, err = serve(
        "shooter.toml", "--auto", "depot", "--seconds", "20", "--json", "--expect", "score.blue >= 8 and taken_in > 5",
        command=[str(compiled("shooter"))],
    )  # fmt: skip
    assert status == 0, err
    report, verdict = out.splitlines()
    found = json.loads(report)
    assert found["taken_in"] > 5 and found["hits"] >= 8 and found["score"]["blue"] >= found["hits"]
    assert found["pieces"]["staged"] == 504
    assert verdict.startswith("as expected: score.blue >= 8")
    assert (tmp_path / "out" / "depot.html").stat().st_size > 100_000
    assert (tmp_path / "out" / "depot.wpilog").read_bytes().startswith(b"WPILOG")
    assert "Robot program starting" in (tmp_path / "out" / "depot.txt").read_text()


def test_a_failed_expectation_gives_status_1(serve):
    status, out, err = serve("tank.toml", "--seconds", "1", "--expect", "distance_m > 50", command=TANK)
    assert status == 1, err
    assert "not as expected: distance_m > 50 (distance_m is " in out


def test_the_error_names_an_unknown_auto(compiled, serve):
    status, _, err = serve("shooter.toml", "--auto", "depott", command=[str(compiled("shooter"))])
    assert status == 1
    assert "no auto named 'depott'. Did you mean 'depot'?" in err


def test_a_program_that_fails_still_leaves_a_page_and_a_log(serve, tmp_path):
    command = [sys.executable, str(PROGRAMS / "mishaps.py"), "divides by zero"]
    status, _, err = serve("tank.toml", "--seconds", "5", command=command)
    assert status == 1
    assert "simcore serve: the robot program has ended at " in err
    assert (tmp_path / "out" / "auto.html").is_file()
    assert b"the robot program has ended at" in (tmp_path / "out" / "auto.wpilog").read_bytes()


def test_the_error_names_the_port_that_a_program_does_not_build(serve):
    command = [sys.executable, str(PROGRAMS / "mishaps.py"), "opens nothing"]
    status, _, err = serve("tank.toml", "--seconds", "1", command=command)
    assert status == 1
    assert "the robot program builds no PWM 0; it builds PWM []" in err


REFUSED = {
    'kind = "tank"\ncontroller = "TalonFX"\nleft = [1]\nright = [2]': "TalonFX .CTRE. runs on the wall clock",
    'kind = "tank"\ncontroller = "SPARK MAX"\nleft = [1]\nright = [2]': "SPARK MAX .REV. computes .* SparkSim.iterate",
    'kind = "tank"\ncontroller = "PWM"\nleft = [1]\nright = [2]\ngyro = "Pigeon2 9"': "Pigeon2 9 .CTRE.",
}


@pytest.mark.parametrize("table", REFUSED)
def test_the_error_names_devices_that_cannot_be_stepped(table, tmp_path):
    """The error comes before the program starts and lists the devices that work."""
    from simcore.bridge.served_robot import require_ports

    file = tmp_path / "robot.toml"
    file.write_text(f"[drivetrain]\n{table}\n")
    with pytest.raises(ConfigError, match=REFUSED[table]) as refused:
        require_ports(read_settings(file))
    assert "what works over the bridge: controllers PWM, Relay" in str(refused.value)


def test_the_command_prints_the_path_of_the_extension(serve):
    status, out, _ = serve("tank.toml", "--extension")
    assert status == 0 and Path(out.strip()).is_file()


@pytest.mark.slow
def test_a_sweep_runs_a_program_once_per_seed(compiled, tmp_path):
    """Scatter makes runs of different seeds differ; a repeated seed gives a bit-identical run."""
    (tmp_path / "simcore.toml").write_text((TANK_FOLDER / "simcore.toml").read_text())
    words = ["--serve", "--seconds", "2", "--seeds", "2", "--csv", "-j", "1", "--", str(compiled("tank"))]
    rows = []
    for out in ("first", "second"):
        done = subprocess.run(
            [sys.executable, "-m", "simcore", "sweep", "--out", out, *words], cwd=tmp_path, capture_output=True,
            text=True, timeout=600, check=False, env={**os.environ, "PYTHONPATH": PACKAGES},
        )  # fmt: skip
        assert done.returncode == 0, done.stdout + done.stderr
        with next((tmp_path / out).glob("*.csv")).open() as file:
            rows.append([row["digest"] for row in csv.DictReader(file)])
    assert rows[0] == rows[1] and len({*rows[0]}) == 2
