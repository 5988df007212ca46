"""Each device has one master: what physics owns nobody else writes, and what somebody writes physics leaves alone."""

from __future__ import annotations

import pytest


@pytest.fixture(scope="module")
def said(scenario):
    return scenario("ownership")


def test_a_claimed_device_keeps_what_physics_wrote(said):
    assert said["ours"]
    assert said["theirs"] and said["foreign"] == "TalonFX 2"
    assert said["output"].count("TalonFX 1 belongs to simcore's drivetrain") == 1


def test_followers_go_with_their_leader(said):
    assert said["groups"] == ["TalonFX 10 + 11", "TalonFX 12"]
    assert said["opposed"] == [0]


def test_a_guess_spins_up_as_its_gains_say_and_kS_is_its_friction(said):
    """A velocity loop's kA over kV is the time constant of what it was tuned on."""
    assert said["time_constant"] == pytest.approx(0.2)
    still, turning = said["friction"]
    assert still == 0.0 and turning > 0.0


def test_motors_that_nobody_drives_are_taken_and_given_back_when_somebody_does(said):
    assert said["taken"] == ["add", "add"]
    drivetrain, foreign, guessed = said["owners"]
    assert drivetrain == "TalonFX 1" and foreign == "TalonFX 2"
    assert dict(guessed)["TalonFX 10 + 11"].startswith("2 x Kraken X60 FOC, 4:1")
    assert said["given_back"] == ["remove"]
    assert "TalonFX 10 + 11" not in dict(said["guessed_after"])
