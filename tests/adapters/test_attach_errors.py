"""Mistakes under `--simcore` end the start with one sentence that gives the remedy."""

from __future__ import annotations

import pytest


@pytest.fixture(scope="module")
def said(scenario):
    return scenario("attach_errors")


@pytest.mark.parametrize(
    ("mistake", "words"),
    [
        ("no drivetrain", ("no drivetrain found: the program builds none of", "a [drivetrain] table in simcore.toml")),
        ("two drivetrains", ("got 2: ['SwerveDrivetrain', 'SwerveDrivetrain']",)),
        ("two modules", ("has 3 modules or more (most have 4), got 2",)),
        ("no wheel radius", ("module 2: CTRE constants need a finite wheel_radius, got nan",)),
        ("too early", ("`from simcore import swerve_config` at the top of physics.py",)),
        ("fewer modules", ("4 modules in the drivetrain", "3 in the model")),
        ("one motor twice", ("module 3 drive_motor: TalonFX 11 is already module 0 drive_motor",)),
        ("unknown device", ("[[mechanism]] 'roller': the robot program builds no TalonFX 30; it builds TalonFX [1,",)),
        ("PWM", ("[[mechanism]] 'hood': the robot program builds nothing on PWM 7; of PWM it builds: PWM 0 (Spark)",)),
        ("solenoid", ("the robot program builds nothing on REVPH 1 Solenoid 3; of REVPH 1 Solenoid it builds: none",)),
        (
            "DIO",
            ("[[sensor]] 'beam': the robot program builds nothing on DIO 5; of DIO it builds: DIO 4 (DigitalInput)",),
        ),
        ("CANrange", ("[[sensor]] 'beam': the robot program builds no CANrange 5; it builds CANrange []",)),
        ("file", ("simcore.toml [robot]: mass must be a number from 20 to 75 kg, got -1",)),
    ],
)
def test_each_mistake_in_program_or_file_raises_an_error_that_names_the_fault(said, mistake, words):
    for text in words:
        assert text in said[mistake]


def test_two_devices_with_one_id_on_two_buses_are_reported(said):
    assert said["two buses"].startswith(
        "ConfigError: TalonFX 31 and TalonFX canivore:31, on two CAN buses, are one device in CTRE's own simulation"
    )
    assert said["one device"] == [True]


def test_a_phoenix_library_of_another_year_raises_an_error_of_one_sentence(said):
    old, new, missing, good = said["versions"]
    for text, got in ((old, "25.4.0"), (new, "27.0.0")):
        assert text.startswith("VendorError: simcore needs Phoenix 6 of 2026 (26.x, tested with 26.3.0), ")
        assert f"got {got}: pip install" in text
    assert "Phoenix 6, which is not installed: pip install" in missing
    assert good == "no error"


def test_attach_distinguishes_a_port_in_use_from_a_free_port(said):
    assert said["taken"] and not said["free"]
