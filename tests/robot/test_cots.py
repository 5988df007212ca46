"""Commercial swerve modules and treads."""

import pytest

from simcore.errors import ConfigError, UnknownNameError
from simcore.robot.cots import MODULES, TREADS, swerve_module, tread


def test_every_module_of_the_catalogue_can_be_built():
    for name, product in MODULES.items():
        for gearing in product.drive_gearings:
            assert swerve_module(name, gearing=gearing).drive_gearing == gearing
    assert len(MODULES) >= 11
    assert tread("VEX Grip V2") == TREADS["VEX Grip V2"] == 1.916
    with pytest.raises(ConfigError, match="not sold with"):
        swerve_module("SDS MK4i", gearing=9.0)
    with pytest.raises(UnknownNameError, match="MK4i"):
        swerve_module("SDS MK4j", gearing=6.75)
