"""Drivetrain fits recover known values from generated logs and describe two real robots."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from made_logs import TESTS, asked, csv_text, driven

from simcore.calibrate.assembling import assembled
from simcore.calibrate.drive_fit import fit_battery, fit_drive
from simcore.calibrate.drive_model import drive, varied
from simcore.calibrate.logs import open_log
from simcore.calibrate.runs import Run
from simcore.cli import main
from simcore.robot.cots import swerve_module
from simcore.robot.dc_motor import motor
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.swerve_config import SwerveConfig

LOGS = Path(__file__).with_name("real_logs")
TANK, KIT = TankConfig(), LOGS / "miami_kit_tank.csv"
TEAM_114 = LOGS / "team114_swerve_2022-12-06.csv"
SWERVE = """[drivetrain]
kind = "swerve"
drive_motor = "Falcon 500"
drive_gearing = 6.12
wheel_diameter = 0.1
"""


def swerve() -> SwerveConfig:
    module = replace(swerve_module("SDS MK4i", gearing=6.12, drive_motor=motor("Falcon 500")), wheel_radius=0.05)
    return SwerveConfig.square(0.57, module)


def real_runs(path: Path, config: TankConfig | SwerveConfig) -> list[Run]:
    one = config.modules[0] if isinstance(config, SwerveConfig) else None
    gearing, kind = (config.gearing, config.motor) if one is None else (one.drive_gearing, one.drive_motor)
    needs = {"sided": one is None, "radius": config.wheel_radius, "gearing": gearing}
    return assembled(open_log(path), volts_per_speed=gearing / kind.kv / config.wheel_radius, **needs)[0]


def test_a_steady_drive_has_the_speed_of_its_voltage():
    """v = (V - kS) share kv r / G without acceleration."""
    run = asked("fast-forward", seconds=6.0)
    way = drive(TANK, run).way[:, 0]
    speed = (way[-1] - way[-26]) / (run.times[-1] - run.times[-26])
    want = (5.0 - TANK.friction_volts) * TANK.speed_share * TANK.motor.kv / TANK.gearing * TANK.wheel_radius
    assert speed == pytest.approx(want, rel=0.002)


@pytest.mark.parametrize("seed", range(2))
def test_intervals_contain_the_known_values(seed):
    """Intervals have a confidence of at least 95 %; `scripts/calibrate_coverage.py` counts how often they hold."""
    rng = np.random.default_rng(seed)
    ks, mass = rng.uniform(0.2, 1.0), rng.uniform(30.0, 65.0)
    found = fit_drive(TANK, driven(varied(TANK, ks=ks, mass=mass), noise=0.002, seed=seed))
    assert found.estimates["ks"].low <= ks <= found.estimates["ks"].high
    assert found.estimates["mass"].low <= mass <= found.estimates["mass"].high
    assert found.estimates["ks"].share < 0.1 and found.estimates["mass"].share < 0.1
    assert all(abs(one.error) < 0.01 for one in found.predictions)


def test_a_slower_motor_is_distinguished_from_friction():
    found = fit_drive(TANK, driven(replace(varied(TANK, ks=0.4, mass=45.0), free_speed_share=0.75)))
    assert found.estimates["free_speed_share"].value == pytest.approx(0.75, rel=0.01)
    assert found.estimates["ks"].value == pytest.approx(0.4, abs=0.02)


def test_the_wheel_radius_follows_from_a_distance_over_ground():
    """The log assumes wheels of 0.0762 m; the robot rolls on 0.073 m."""
    built = replace(varied(TANK, ks=0.5, mass=50.0), wheel_radius=0.073)
    runs = []
    for run in map(asked, TESTS):
        done = drive(built, run, radius=TANK.wheel_radius)
        runs.append(replace(run, way=done.way - done.way[0], ground=np.abs(done.ground)))
    found = fit_drive(TANK, runs)
    assert found.estimates["wheel_radius"].value == pytest.approx(0.073, rel=0.005)
    assert not any("wheel radius" in line for line in found.unknown)


def test_ramps_alone_leave_the_mass_unknown():
    found = fit_drive(TANK, driven(TANK, tests=TESTS[:2]))
    assert "mass" not in found.estimates and any(
        line.startswith("mass: the voltage only ramp") for line in found.unknown
    )
    assert found.estimates["ks"].value == pytest.approx(TANK.friction_volts, abs=0.01)


def test_the_last_third_of_a_single_run_is_predicted():
    (prediction,) = fit_drive(TANK, driven(TANK, tests=TESTS[2:3])).predictions
    assert prediction.first > 0 and abs(prediction.error) < 0.01


def test_battery_resistance_is_the_slope_of_voltage_over_current():
    (run,) = driven(TANK, tests=TESTS[2:3], noise=1e-4)
    rng = np.random.default_rng(3)
    with_battery = replace(run, bus=12.6 - 0.024 * run.amps + rng.normal(0.0, 0.02, len(run.amps)))
    found = fit_battery([with_battery])
    assert found.low <= 0.024 <= found.high and found.share < 0.3
    assert fit_battery([run]) is None


def test_the_command_fits_the_friction_of_a_kit_chassis_but_not_its_mass(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["calibrate", str(KIT)]) == 0
    said = capsys.readouterr().out
    ks = float(said.split("drive_friction_volts = ")[1].split()[0])
    assert ks == pytest.approx(0.78, abs=0.05)
    errors = [float(line.split("prediction off by ")[1].split()[0]) for line in said.splitlines() if "held out" in line]
    assert len(errors) == 2 and max(map(abs, errors)) < 4.0
    assert "the data cannot tell mass: the voltage only ramp" in said
    page = (tmp_path / "out" / "twin.html").read_text()
    assert "Real and simulated" in page


def test_the_command_fits_friction_and_mass_of_team_114s_robot(tmp_path, capsys):
    (tmp_path / "simcore.toml").write_text(SWERVE)
    out = tmp_path / "page.html"
    assert main(["calibrate", str(TEAM_114), "--project", str(tmp_path), "--out", str(out)]) == 0
    said = capsys.readouterr().out
    low, high = (said.split("drive_friction_volts = ")[1].split()[k] for k in (2, 4))
    assert float(low) < 0.22 < float(high)
    low, high = (said.split("\nmass = ")[1].split()[k] for k in (2, 4))
    assert float(low) < 48.3 < float(high)
    errors = [float(line.split("prediction off by ")[1].split()[0]) for line in said.splitlines() if "held out" in line]
    assert len(errors) == 4 and max(map(abs, errors)) < 2.0


@pytest.mark.parametrize(
    ("path", "config", "most"), [(KIT, TANK, 0.06), (TEAM_114, swerve(), 0.04)], ids=["kit", "114"]
)
def test_default_values_predict_the_travel_of_both_real_robots_within_6_percent(path, config, most):
    for run in real_runs(path, config):
        ours, real = drive(config, run).way.mean(axis=1)[-1], run.way.mean(axis=1)[-1]
        assert ours == pytest.approx(real, rel=most), run.name


def test_a_log_of_another_robot_is_refused(tmp_path, capsys):
    """A gearing of 20 instead of 8.45 makes the robot 2.4 times slower."""
    (tmp_path / "simcore.toml").write_text('[drivetrain]\nkind = "tank"\ndrive_gearing = 20.0\n')
    path = tmp_path / "log.csv"
    path.write_text(csv_text(driven(TANK, tests=TESTS[2:])))
    assert main(["calibrate", str(path), "--project", str(tmp_path), "--out", str(tmp_path / "p.html")]) == 1
    assert "times as fast as its motors can turn it" in capsys.readouterr().err
