"""Checks of the configs of swerve drives."""

import logging
import math
from dataclasses import replace

import pytest
from each_case import each

from simcore.errors import ConfigError
from simcore.robot.dc_motor import MotorModel, motor
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.wheel_config import plate_inertia

SQUARE = SwerveConfig.square(0.527, SwerveModuleConfig(x=0, y=0))


def test_unusual_values_give_one_warning_each_and_are_accepted(caplog):
    with caplog.at_level(logging.WARNING):
        SwerveConfig.square(0.5, SwerveModuleConfig(x=0, y=0, wheel_cof=3.5), mass=95.0)
    assert sum("wheel_cof" in r.message for r in caplog.records) == 1
    assert sum("mass" in r.message for r in caplog.records) == 1


@each(
    "wrong",
    [
        {"wheel_radius": 0.0},
        {"drive_gearing": -6.75},
        {"drive_efficiency": 1.2},
        {"wheel_cof": -1.0},
        {"x": math.nan},
        {"steer_inertia": 0.0},
        {"drive_stator_limit": -1.0},
        {"drive_supply_limit": math.nan},
        {"coupling_ratio": 30.0},
    ],
)
def test_the_error_names_the_impossible_value_of_a_module(wrong):
    with pytest.raises(ConfigError, match=next(iter(wrong))):
        SwerveModuleConfig(**{"x": 0.2, "y": 0.2, "name": "front left", **wrong})


@each("wrong", [{"modules": ()}, {"mass": 0.0}, {"yaw_inertia": math.inf}, {"center_of_mass": (0.0, 0.0)}])
def test_invalid_robot_values_are_refused(wrong):
    with pytest.raises(ConfigError, match=next(iter(wrong))):
        replace(SQUARE, **wrong)


def test_a_plate_has_the_inertia_of_a_uniform_rectangle():
    assert plate_inertia(55.0, 0.8, 0.8) == pytest.approx(5.87, abs=0.01)


def test_configs_are_frozen():
    with pytest.raises(AttributeError):
        SQUARE.mass = 3.0  # type: ignore[misc]
    assert isinstance(motor("NEO"), MotorModel)
