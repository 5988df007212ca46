"""Fits of flywheels, arms and elevators recover known values from generated logs."""

import math
from dataclasses import replace

import numpy as np
import pytest
from made_logs import TESTS, asked, sysid_json

from simcore.calibrate.mechanism_fit import fit_mechanism, turned
from simcore.cli import main
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import ArmConfig, ElevatorConfig, FlywheelConfig

WHEEL = FlywheelConfig(gearbox=GearboxConfig(motor=motor("Kraken X60"), gearing=1.0), inertia=0.004)
ARM = ArmConfig(
    gearbox=GearboxConfig(motor=motor("NEO"), gearing=60.0), inertia=1.2, mass=4.0, center_of_mass=0.4, min_angle=-1.5,
    max_angle=3.0,
)  # fmt: skip
LIFT = ElevatorConfig(
    gearbox=GearboxConfig(motor=motor("NEO"), gearing=10.0), carriage_mass=8.0, drum_radius=0.02, max_height=2.8
)


def made(config, truth, *, origin=0.0, volts=(1.0, 0.0), noise=1e-3):
    """Return runs of a mechanism with known values; `volts` scales SysId's voltages and adds the holding voltage."""
    rng, runs = np.random.default_rng(1), []
    for test in TESTS:
        run = asked(test, 1, seconds=4.0 if "slow" in test else 1.0)
        run = replace(run, volts=run.volts * volts[0] + volts[1], origin=origin)
        way = turned(config, run, truth)
        runs.append(replace(run, way=(way + rng.normal(0.0, noise, way.shape))[:, None]))
    return runs


def test_a_flywheel_fit_recovers_friction_and_inertia():
    found = fit_mechanism(WHEEL, made(WHEEL, {"friction_volts": 0.3, "inertia": 0.4}))
    for key, want in (("friction_volts", 0.3), ("inertia", 0.004 * math.exp(0.4))):
        assert found.estimates[key].low <= want <= found.estimates[key].high and found.estimates[key].share < 0.05
    assert all(abs(one.error) < 0.01 for one in found.predictions)


def test_an_arm_fit_recovers_the_mass_from_the_weight_torque():
    truth = {"friction_volts": 0.35, "inertia": -0.3, "weight_torque": 12.0}
    found = fit_mechanism(ARM, made(ARM, truth, origin=0.2, volts=(0.5, 0.8)))
    mass = found.estimates["mass"]
    assert mass.low <= 12.0 / (9.80665 * 0.4) <= mass.high and mass.share < 0.3


def test_an_elevator_fit_recovers_the_lifted_mass():
    found = fit_mechanism(LIFT, made(LIFT, {"friction_volts": 0.4, "inertia": 0.3}, origin=60.0, volts=(0.3, 0.9)))
    mass = found.estimates["mass"]
    assert mass.low <= 8.0 * math.exp(0.3) <= mass.high and mass.share < 0.3


FILE = """
[[mechanism]]
name = "shooter"
kind = "flywheel"
leader = 20
motor = "Kraken X60"
gearing = 1.0
inertia = 0.004
"""


def test_the_command_prints_the_keys_of_a_mechanism(tmp_path, capsys):
    (tmp_path / "simcore.toml").write_text(FILE)
    runs = made(WHEEL, {"friction_volts": 0.3, "inertia": 0.4})
    log = tmp_path / "log.json"
    log.write_text(sysid_json(runs, per_turn=math.tau, units="Rotations", kind="Simple"))
    args = ["calibrate", str(log), "--project", str(tmp_path), "--out", str(tmp_path / "page.html")]
    assert main(args) == 0
    said = capsys.readouterr().out
    assert float(said.split("\ninertia = ")[1].split()[0]) == pytest.approx(0.004 * math.exp(0.4), rel=0.02)
    assert '[[mechanism]]  # the one with name = "shooter"' in said
    assert main([*args, "--mechanism", "arm"]) == 1
    assert "no mechanism with a motor named 'arm'" in capsys.readouterr().err
    (tmp_path / "simcore.toml").write_text("")
    assert main(args) == 1
    assert "is of a mechanism (Simple): give --mechanism NAME" in capsys.readouterr().err
