"""Chassis derived from a drivetrain config."""

import pytest

from simcore.errors import ConfigError
from simcore.robot.chassis_config import ChassisConfig
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.world.shapes import Box


def test_a_swerve_chassis_has_its_wheels_at_the_module_positions():
    module = SwerveModuleConfig(x=0.0, y=0.0, wheel_radius=0.05, wheel_cof=1.4)
    swerve = SwerveConfig.rectangle(0.6, 0.5, module, mass=60.0, height=0.25)

    chassis = ChassisConfig.around(swerve, bumper=(0.9, 0.8))

    assert (chassis.mass, chassis.yaw_inertia) == (60.0, swerve.yaw_inertia)
    assert (chassis.bumper_length, chassis.bumper_width) == (0.9, 0.8)
    assert (chassis.center_of_mass_height, chassis.wheel_radius, chassis.friction) == (0.25, 0.05, 1.4)
    assert chassis.wheel_positions == ((0.3, 0.25), (0.3, -0.25), (-0.3, 0.25), (-0.3, -0.25))


def test_a_tank_chassis_lists_the_wheels_of_the_left_side_first():
    tank = TankConfig(wheel_xs=(0.3, -0.3), trackwidth=0.6, center_of_mass=(0.05, 0.01, 0.15), mass=45.0, wheel_cof=0.9)

    chassis = ChassisConfig.around(tank, bumper=(0.9, 0.8))

    assert (chassis.mass, chassis.yaw_inertia, chassis.friction) == (45.0, tank.yaw_inertia, 0.9)
    assert (chassis.center_of_mass_height, chassis.wheel_radius) == (0.15, tank.wheel_radius)
    assert chassis.wheel_positions == ((0.3, 0.3), (-0.3, 0.3), (0.3, -0.3), (-0.3, -0.3))


def test_a_bay_leaves_a_gap_in_the_bumpers_and_the_frame_at_the_back():
    """The bay, 0.5 m deep and 0.3 m wide in 0.8 x 0.8 m, contains no part; the other parts are unchanged."""
    whole, open_behind = ChassisConfig(), ChassisConfig(bay=(0.5, 0.3))

    def solid(config, x, y):
        boxes = [part for part in config.shape.parts if isinstance(part.shape, Box)]
        return [
            all(abs(p - c) < s / 2 for p, c, s in zip((x, y, z), box.offset, box.shape.size, strict=True))
            for z in (0.15, 0.45)
            for box in boxes
        ].count(True)

    for x, y in ((-0.35, 0.0), (-0.35, 0.14), (0.09, -0.14), (-0.1, 0.0)):
        assert solid(open_behind, x, y) == 0 < solid(whole, x, y)
    for x, y in ((-0.35, 0.16), (-0.35, -0.39), (0.11, 0.0), (0.39, 0.39), (0.3, -0.2)):
        assert solid(open_behind, x, y) == solid(whole, x, y) > 0
    with pytest.raises(ConfigError, match="bay must leave frame"):
        ChassisConfig(bay=(0.75, 0.3))
    with pytest.raises(ConfigError, match="bay must leave frame"):
        ChassisConfig(bay=(0.5, 0.7))


def test_wheels_outside_of_the_bumpers_are_refused():
    with pytest.raises(ConfigError, match="outside of the bumpers"):
        ChassisConfig.around(TankConfig(trackwidth=0.9), bumper=(0.9, 0.8))
