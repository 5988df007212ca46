"""Each device has one owner: other code cannot write what physics owns, and physics does not write the rest."""

from __future__ import annotations

import pytest


@pytest.fixture(scope="module")
def said(scenario):
    return scenario("ownership")


def test_a_claimed_device_keeps_the_value_from_physics(said):
    assert said["ours"]
    assert said["theirs"] and said["foreign"] == "TalonFX 2"
    assert said["output"].count("TalonFX 1 belongs to simcore's drivetrain") == 1


def test_followers_are_claimed_with_their_leader(said):
    assert said["groups"] == ["TalonFX 10 + 11", "TalonFX 12"]
    assert said["opposed"] == [0]


def test_a_guessed_flywheel_spins_up_by_its_gains_with_ks_as_friction(said):
    """kA over kV of a velocity loop is the time constant of the mechanism for which it was tuned."""
    assert said["time_constant"] == pytest.approx(0.2)
    still, turning = said["friction"]
    assert still == 0.0 and turning > 0.0


def test_unsimulated_motors_are_claimed_until_the_program_simulates_them(said):
    assert said["taken"] == ["add", "add"]
    drivetrain, foreign, guessed = said["owners"]
    assert drivetrain == "TalonFX 1" and foreign == "TalonFX 2"
    assert dict(guessed)["TalonFX 10 + 11"].startswith("2 x Kraken X60 FOC, 4:1")
    assert said["given_back"] == ["remove"]
    assert "TalonFX 10 + 11" not in dict(said["guessed_after"])
