"""Constants of CTRE's generated swerve code make a model."""

from types import SimpleNamespace

import pytest

from simcore.errors import ConfigError
from simcore.robot.dc_motor import motor


def test_swerve_constants_are_read_by_attribute_name(bench):
    from simcore.robotcode.makers.phoenix6.swerve import swerve_config

    limits = SimpleNamespace(
        stator_current_limit=120.0,
        stator_current_limit_enable=True,
        supply_current_limit=70.0,
        supply_current_limit_enable=True,
    )
    constants = SimpleNamespace(
        location_x=0.25,
        location_y=-0.25,
        drive_motor_gear_ratio=6.746,
        steer_motor_gear_ratio=21.43,
        coupling_gear_ratio=3.57,
        wheel_radius=0.0508,
        slip_current=90.0,
        drive_motor_initial_configs=SimpleNamespace(current_limits=limits),
        steer_motor_initial_configs=None,
        steer_inertia=0.01,
    )
    config = swerve_config(None, modules=[constants] * 4, mass=50.0)
    m = config.modules[0]
    assert (m.x, m.y, m.drive_gearing, m.coupling_ratio) == (0.25, -0.25, 6.746, 3.57)
    assert (m.drive_stator_limit, m.drive_supply_limit, m.steer_stator_limit) == (90.0, 70.0, None)
    assert m.drive_motor is motor("Kraken X60 FOC")
    assert m.steer_inertia == 0.004
    del constants.wheel_radius
    with pytest.raises(ConfigError, match=r"module 0.*wheel_radius"):
        swerve_config(None, modules=[constants])
