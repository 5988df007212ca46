"""The kS of a program's drive motors is their friction."""

from types import SimpleNamespace

import pytest

pytest.importorskip("phoenix6")

from simcore.robot.dc_motor import motor
from simcore.robot.swerve_config import SwerveModuleConfig
from simcore.robotcode.makers.phoenix6.swerve import _friction

KRAKEN = motor("Kraken X60 FOC")


def constants(ks, output="VOLTAGE"):
    return SimpleNamespace(
        drive_motor_gains=SimpleNamespace(k_s=ks), drive_motor_closed_loop_output=SimpleNamespace(name=output)
    )


def test_a_ks_in_amperes_becomes_a_voltage_across_the_winding():
    """U = R I, as a slowly turning motor has hardly any back-EMF."""
    assert _friction(constants(0.31), KRAKEN) == 0.31
    amps = _friction(constants(8.0, "TORQUE_CURRENT_FOC"), KRAKEN)
    assert amps == pytest.approx(8.0 * KRAKEN.winding_resistance)


def test_a_program_without_a_ks_keeps_the_default_friction():
    usual = SwerveModuleConfig(x=0.0, y=0.0).drive_friction_volts
    assert _friction(constants(0.0), KRAKEN) == _friction(SimpleNamespace(), KRAKEN) == usual == 0.22
    assert _friction(constants(30.0), KRAKEN) == usual  # probably another unit
