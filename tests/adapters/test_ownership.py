"""Each device has one master: what physics owns nobody else writes, and what somebody writes physics leaves alone."""

from __future__ import annotations

import pytest


@pytest.fixture(scope="module")
def said(scenario):
    return scenario("ownership")


def test_a_claimed_device_keeps_the_physics_value(said):
    assert said["ours"]
    assert said["theirs"] and said["foreign"] == "TalonFX 2"
    assert said["output"].count("TalonFX 1 belongs to simcore's drivetrain") == 1


def test_followers_are_claimed_with_their_leader(said):
    assert said["groups"] == ["TalonFX 10 + 11", "TalonFX 12"]
    assert said["opposed"] == [0]


def test_a_guess_spins_up_by_its_gains_with_kS_as_friction(said):
    """A velocity loop's kA over kV is the time constant of what it was tuned on."""
    assert said["time_constant"] == pytest.approx(0.2)
    still, turning = said["friction"]
    assert still == 0.0 and turning > 0.0


def test_undriven_motors_are_claimed_and_released_when_a_program_drives_them(said):
    assert said["taken"] == ["add", "add"]
    drivetrain, foreign, guessed = said["owners"]
    assert drivetrain == "TalonFX 1" and foreign == "TalonFX 2"
    assert dict(guessed)["TalonFX 10 + 11"].startswith("2 x Kraken X60 FOC, 4:1")
    assert said["given_back"] == ["remove"]
    assert "TalonFX 10 + 11" not in dict(said["guessed_after"])
