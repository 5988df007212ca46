"""Factors: their text on the command line, and the settings that they vary."""

import json
from dataclasses import asdict, replace

import pytest
from each_case import each

from games.rebuilt import REBUILT
from simcore.errors import ConfigError
from simcore.match.scatter import Scatter
from simcore.sweep.factors import Distribution, Factor, RunSetup, parse_factor, vary


@each(
    ("text", "values"),
    [
        ("robot.mass=45:60:5", (45.0, 50.0, 55.0, 60.0)),
        ("robot.mass=60:45:-5", (60.0, 55.0, 50.0, 45.0)),
        ("a=0.1:0.3:0.1", (0.1, 0.2, 0.3)),
        ("a=1:2:0.4", (1.0, 1.4, 1.8)),
        ("battery.charge = 0.3, 1", (0.3, 1.0)),
        ("auto=left,two pieces", ("left", "two pieces")),
        ("red=collector:3,collector:2+idle", ("collector:3", "collector:2+idle")),
    ],
)
def test_lists_and_ranges_include_their_last_value(text, values):
    assert parse_factor(text).values == values


def test_the_method_at_returns_the_quantile_of_a_distribution():
    uniform, normal = parse_factor("e=uniform(0.4,0.5)"), parse_factor("m=normal(55,2)")
    assert uniform.at(0.5) == pytest.approx(0.45) and normal.at(0.5) == pytest.approx(55.0)
    assert normal.at(0.8413447) == pytest.approx(57.0, abs=1e-4)  # one standard deviation above the mean


@each("text", ["robot.mass", "=3", "a=", "a=1:2", "a=1:2:0", "a=2:1:1", "a=1,,2", "a=1,1",
                                  "a=uniform(2,1)", "a=normal(1)", "a=normal(1,0)", "a=gauss(1,2)", "a..b=1",
                                  "a=0:1e9:0.001", "a=1e300,2"])  # fmt: skip
def test_an_unreadable_factor_is_refused(text):
    with pytest.raises(ConfigError):
        parse_factor(text)


def test_a_factor_read_back_from_json_is_equal():
    for factor in (parse_factor("a=1,b"), Factor("m", distribution=Distribution("normal", 55.0, 2.0))):
        assert Factor.from_json(json.loads(json.dumps(asdict(factor)))) == factor


# --- fields that the names of factors reach, and messages about names without a field -------------------------------


SETUP = RunSetup(game=REBUILT, auto=REBUILT.auto("depot"), robot=REBUILT.robot())


def test_factor_names_select_the_fields_of_the_robot():
    robot = vary(
        SETUP,
        {
            "robot.bumper.0": 0.82,
            "robot.battery.initial_charge": 0.3,
            "robot.shooters.*.exit_efficiency": 0.45,
            "robot.mechanisms.shooter.inertia": 0.01,
            "robot.mechanisms.hood.gearbox.gearing": 80.0,
            "robot.drivetrain.modules.*.wheel_cof": 1.1,  # of all modules
            "robot.drivetrain.modules.2.drive_kp": 2.0,  # of one
            "robot.storage.capacity": 30.0,
            "robot.battery.brownout_enabled": "false",
        },
    ).robot
    assert robot.bumper == (0.82, 0.8)
    assert robot.battery.initial_charge == 0.3 and robot.battery.brownout_enabled is False
    assert robot.shooters[0].exit_efficiency == 0.45
    assert robot.mechanisms["shooter"].inertia == 0.01
    assert robot.mechanisms["hood"].gearbox.gearing == 80.0
    assert [module.wheel_cof for module in robot.drivetrain.modules] == [1.1] * 4
    assert [module.drive_kp for module in robot.drivetrain.modules] == [1.0, 1.0, 2.0, 1.0]
    assert robot.storage.capacity == 30 and isinstance(robot.storage.capacity, int)
    assert robot.components == SETUP.robot.components


def test_the_moment_of_inertia_of_a_robot_scales_with_its_mass():
    before, after = SETUP.robot, vary(SETUP, {"robot.mass": 66.0}).robot
    assert after.drivetrain.mass == after.body.mass == 66.0
    assert after.drivetrain.yaw_inertia / before.drivetrain.yaw_inertia == pytest.approx(66.0 / 55.0)
    assert vary(replace(SETUP, robot=after), {"robot.mass": 66.0}).robot == after  # a second time changes nothing
    told = replace(SETUP, robot=replace(before, chassis=replace(before.body, yaw_inertia=4.0)))
    assert vary(told, {"robot.mass": 66.0}).robot.body.yaw_inertia == pytest.approx(4.0 * 66.0 / 55.0)


def test_factor_names_select_the_settings_of_a_run():
    varied = vary(
        SETUP,
        {"start.y": 6.1, "auto": "neutral", "preload": 4.0, "seconds": 5.0, "alliance": "red", "scatter": 0.5,
         "scatter.spin": 0.2, "pieces.Fuel.mass": 0.22, "pieces.*.restitution": 0.4},
    )  # fmt: skip
    neutral = REBUILT.auto("neutral")
    assert varied.auto == replace(neutral, start=(neutral.start[0], 6.1, neutral.start[2]), preload=4)
    assert (varied.seconds, varied.alliance) == (5.0, "red")
    assert varied.scatter == replace(Scatter().scaled(0.5), spin=0.2)
    assert (varied.game.pieces[0].kind.mass, varied.game.pieces[0].kind.restitution) == (0.22, 0.4)
    assert vary(SETUP, {"scatter.spin": 0.2}).scatter == replace(Scatter.none(), spin=0.2)


@each(
    ("values", "said"),
    [
        ({"robot.mas": 3.0}, "Did you mean 'mass'"),
        ({"robt.mass": 3.0}, "Did you mean 'robot'"),
        ({"battery.initial_charge": 1.0}, "Did you mean 'robot.battery'"),
        ({"robot.battery.initial_chage": 1.0}, "Did you mean 'initial_charge'"),
        ({"robot.shooters.0.exit_eficiency": 0.4}, "Did you mean 'exit_efficiency'"),
        ({"robot.mechanisms.hoood.mass": 1.0}, "Did you mean 'hood'"),
        ({"auto": "dpot"}, "Did you mean 'depot'"),
        ({"scatter.exit": 0.1}, "Did you mean 'exit_speed'"),
        ({"pieces.Fuel.mas": 0.2}, "Did you mean 'mass'"),
        ({"pieces.fuel.mass": 0.2}, "Did you mean 'Fuel'"),
        ({"start.z": 0.2}, "Known: ['alliance'"),
        ({"robot.drivetrain.modules.7.x": 0.2}, "Known: ['0', '1'"),
        ({"robot.mass": -3.0}, "above 0 and up to 1000 kg, got -3.0"),
        ({"robot.mass": "heavy"}, "got 'heavy'"),
        ({"robot.battery.initial_charge": 1.5}, "from 0 to 1, got 1.5"),
        ({"robot.storage.capacity": 3.5}, "whole number"),
        ({"robot.battery.brownout_enabled": 2.0}, "true or false"),
        ({"alliance": "green"}, "'blue' or 'red', got 'green'"),
        ({"robot.gyro": 3.0}, "name a number in it, as robot.gyro.{"),
        ({"robot.bumper": 3.0}, "robot.bumper.{0,1}"),
        ({"robot.mass.x": 3.0}, "no part of robot named 'mass'"),
        ({"robot.storage.capacity.x": 3.0}, "to vary"),
    ],
)
def test_the_error_for_an_invalid_factor_names_the_factor_and_the_mistake(values, said):
    (name,) = values
    with pytest.raises(ConfigError) as caught:
        vary(SETUP, values)
    assert said in str(caught.value) and name in str(caught.value)
