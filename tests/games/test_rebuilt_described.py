"""A team's robot, as its simcore.toml describes it, on the field of REBUILT."""

from __future__ import annotations

import math

import pytest

from games.rebuilt import REBUILT
from simcore.errors import ConfigError
from simcore.match.match import Match
from simcore.pieces.intake import IntakeConfig, IntakeZone
from simcore.pieces.launch import LaunchParameters
from simcore.pieces.shooter import ShooterConfig
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import ArmConfig, FlywheelConfig, RollerConfig
from simcore.robot.shaft import ShaftSim
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot_file.reader import gearbox_motor
from simcore.robot_file.robot_settings import MechanismSettings, RobotSettings, practice_match

DRIVE = SwerveConfig.square(0.5, SwerveModuleConfig(x=0, y=0), mass=48.0)


def gearbox(ratio: float) -> GearboxConfig:
    return GearboxConfig(motor=gearbox_motor("Kraken X60"), gearing=ratio)


def mechanism(name: str, leader: int, config) -> MechanismSettings:
    return MechanismSettings(name=name, config=config, motor="Kraken X60", controller="TalonFX", leader=leader)


ROLLER = mechanism("roller", 1, RollerConfig(gearbox=gearbox(3.0), inertia=0.001, radius=0.02))
PIVOT = mechanism(
    "pivot", 2, ArmConfig(gearbox=gearbox(50.0), inertia=0.2, min_angle=0.0, max_angle=1.5, start_angle=1.5)
)
WHEELS = mechanism("wheels", 3, FlywheelConfig(gearbox=gearbox(0.8), inertia=0.004))
HOOD = mechanism("hood", 4, ArmConfig(gearbox=gearbox(90.0), inertia=0.05, min_angle=0.0, max_angle=0.7))


def settings(**more) -> RobotSettings:
    return RobotSettings(mass=48.0, bumper=(0.8, 0.8), mechanisms=(ROLLER, PIVOT, WHEELS, HOOD), **more)


def practice(described: RobotSettings) -> Match:
    return practice_match(REBUILT, described, DRIVE)


def intake(x: tuple[float, float], y: tuple[float, float], **more) -> IntakeConfig:
    zone = IntakeZone(x_min=x[0], x_max=x[1], y_min=y[0], y_max=y[1], z_max=0.2)
    return IntakeConfig(zone=zone, roller="roller", **more)


def test_nothing_described_nothing_moves():
    with practice(RobotSettings(mass=48.0, bumper=(0.8, 0.8))) as match:
        match.play(0.1)
        (robot,) = match.robots
        assert robot.mechanisms == {} and robot.intakes == [] and robot.shooters == []
        assert robot.chassis.pose[:2] == pytest.approx((2.0, 1.2), abs=1e-3)
        assert match.practice and robot.storage.room == REBUILT.robot().storage.capacity


@pytest.mark.parametrize(("deployed_at", "start_is_out"), [("lower", False), ("upper", True)])
def test_the_intake_works_while_it_is_out_and_its_roller_turns(deployed_at, start_is_out):
    one = intake((0.35, 0.6), (-0.3, 0.3), deploy="pivot", deployed_at=deployed_at)
    with practice(settings(intakes=(one,))) as match:
        (robot,) = match.robots
        assert not robot.intakes[0].is_active
        for _ in range(20):
            robot.mechanisms["roller"].set_volts(8.0)
            match.tick()
        assert robot.intakes[0].is_active == start_is_out
        for _ in range(50):
            robot.mechanisms["roller"].set_volts(8.0)
            robot.mechanisms["pivot"].set_volts(-3.0)
            match.tick()
        assert robot.mechanisms["pivot"].position == 0.0
        assert robot.intakes[0].is_active != start_is_out


def test_it_takes_in_what_lies_in_its_zone():
    """It starts before the fuel of its alliance's depot and drives into it, the intake ahead."""
    one = intake((0.3, 0.6), (-0.4, 0.4))
    with practice(settings(intakes=(one,), start=(1.6, 5.96, math.pi), capacity=7)) as match:
        (robot,) = match.robots
        for _ in range(60):
            robot.mechanisms["roller"].set_volts(8.0)
            robot.drive.set_chassis_speeds(1.5, 0.0, 0.0)
            match.tick()
        assert match.count.held == 7


def test_shots_leave_when_fed_where_the_shooter_looks():
    """Rim speed times efficiency, to the robot's back, at the hood's elevation; the preload, no more."""
    one = ShooterConfig(
        wheels=("wheels",),
        wheel_radius=0.05,
        exit_efficiency=0.5,
        launch=LaunchParameters(height=0.5, forward=0.2, heading=math.pi),
        elevation=1.2,
        hood="hood",
        gate=("roller",),
    )
    with practice(settings(shooters=(one,), preload=3)) as match:
        (robot,) = match.robots
        (shooter,) = robot.shooters
        for _ in range(60):
            robot.mechanisms["wheels"].set_volts(6.0)
            match.tick()
        assert match.flow.shots == []
        speed = robot.mechanisms["wheels"].velocity * 0.05 * 0.5
        assert shooter.exit_speed == pytest.approx(speed)
        robot.mechanisms["hood"].reset(0.4)
        assert shooter.elevation == pytest.approx(0.8)
        for _ in range(40):
            robot.mechanisms["wheels"].set_volts(6.0)
            robot.mechanisms["roller"].set_volts(6.0)
            match.tick()
        assert len(match.flow.shots) == 3 and match.count.held == 0
        first, second = match.flow.shots[0].points[1], match.flow.shots[0].points[3]
        assert second[0] < first[0]  # it flies to the back
        assert abs(second[1] - first[1]) < 0.01


def test_mechanisms_of_the_file_load_the_battery_and_guesses_do_not():
    with practice(settings()) as match:
        (robot,) = match.robots
        guess = ShaftSim(gearbox(1.0), 0.01)
        robot.add_estimated_mechanism(guess)
        guess.set_volts(12.0)
        robot.mechanisms["wheels"].set_volts(6.0)
        match.tick()
        assert guess.velocity > 0.0
        assert robot.mechanism_current == pytest.approx(robot.mechanisms["wheels"].supply_current)
        robot.remove_estimated_mechanism(guess)
        speed = guess.velocity
        match.tick()
        assert guess.velocity == speed


def test_a_preload_beyond_the_rules_and_a_start_in_a_wall_are_refused():
    with pytest.raises(ConfigError, match=r"simcore.toml \[start\]: preload must be at most 8 in rebuilt, got 9"):
        practice(settings(preload=9))
    with pytest.raises(ConfigError, match="starts inside of a field element"):
        practice(settings(start=(4.6, 4.03, 0.0)))


def test_the_match_clock_follows_the_driver_station():
    """Practice for a while, then a match: game data comes with teleop, of the auto fuel of this match alone."""
    with practice(settings()) as match:
        match.timer.follow_driver_station()
        match.play(0.5)
        assert match.timer.time == 0.0 and match.rules.game_data() == ""
        match.timer.set_enabled(True)
        match.start_mode("auto")
        assert match.timer.time == 0.0 and match.rules.game_data() == ""
        match.rules.worth(next(zone for zone in REBUILT.zones if zone.alliance == "red"))
        match.play(0.1)
        assert match.timer.time == pytest.approx(0.1)
        match.start_mode("teleop")
        assert match.timer.time == pytest.approx(23.0)
        assert match.rules.game_data() == "R"  # red scored more, so its hub is off first
        match.start_mode("auto")
        assert match.rules.game_data() == ""
