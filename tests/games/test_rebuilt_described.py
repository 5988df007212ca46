"""A team's robot, as its simcore.toml describes it, on the field of REBUILT."""

from __future__ import annotations

import math

import pytest
from games.rebuilt.practice import PracticeRobot, practice

from simcore.errors import ConfigError
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import ArmConfig, FlywheelConfig, RollerConfig
from simcore.robot.shaft import ShaftSim
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot_file.reader import gearbox_motor
from simcore.robot_file.robot_settings import IntakeSettings, MechanismSettings, RobotSettings, ShooterSettings

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


def play(sim, seconds: float) -> None:
    for _ in range(round(seconds / 0.02)):
        sim.tick()


def test_nothing_described_nothing_moves():
    sim, robot = practice(RobotSettings(bumper=(0.8, 0.8)), DRIVE)
    with sim:
        play(sim, 0.1)
        assert robot.mechanisms == ()
        assert not robot.intake_active and not robot.gate_open
        assert robot.chassis.pose[:2] == pytest.approx((2.0, 1.2), abs=1e-3)


@pytest.mark.parametrize(("out_at", "start_is_out"), [("lower", False), ("upper", True)])
def test_the_intake_works_while_it_is_out_and_its_roller_turns(out_at, start_is_out):
    intake = IntakeSettings(x=(0.35, 0.6), y=(-0.3, 0.3), z_max=0.2, roller="roller", deploy="pivot", out_at=out_at)
    sim, robot = practice(settings(intake=intake), DRIVE)
    with sim:
        assert not robot.intake_active
        for _ in range(20):
            robot.named["roller"].set_volts(8.0)
            sim.tick()
        assert robot.intake_active == start_is_out
        for _ in range(50):
            robot.named["roller"].set_volts(8.0)
            robot.named["pivot"].set_volts(-3.0)
            sim.tick()
        assert robot.named["pivot"].position == 0.0
        assert robot.intake_active != start_is_out


def test_it_takes_in_what_lies_in_its_zone():
    """It starts before the fuel of its alliance's depot and drives into it, the intake ahead."""
    intake = IntakeSettings(x=(0.3, 0.6), y=(-0.4, 0.4), z_max=0.2, roller="roller")
    sim, robot = practice(settings(intake=intake, start=(1.6, 5.96, math.pi), capacity=7), DRIVE)
    with sim:
        for _ in range(60):
            robot.named["roller"].set_volts(8.0)
            robot.drive.set_chassis_speeds(1.5, 0.0, 0.0)
            sim.tick()
        assert sim.fuel.held == 7


def shooter(**more) -> ShooterSettings:
    numbers = dict(
        wheel_radius=0.05, exit_efficiency=0.5, height=0.5, forward=0.2, yaw=math.pi, barrels=(0.0,), rate=8.0,
        elevation=1.2, elevation_per_hood=-1.0,
    )  # fmt: skip
    return ShooterSettings(wheels="wheels", **{**numbers, **more})


def test_shots_leave_when_fed_where_the_shooter_looks():
    """Rim speed times efficiency, to the robot's back, at the hood's elevation; the preload, no more."""
    sim, robot = practice(settings(shooter=shooter(feeder="roller", hood="hood"), preload=3), DRIVE)
    with sim:
        for _ in range(60):
            robot.named["wheels"].set_volts(6.0)
            sim.tick()
        assert sim.shots == []
        speed = robot.named["wheels"].velocity * 0.05 * 0.5
        assert robot.exit_speed == pytest.approx(speed)
        robot.named["hood"].reset(0.4)
        assert robot.elevation == pytest.approx(0.8)
        for _ in range(40):
            robot.named["wheels"].set_volts(6.0)
            robot.named["roller"].set_volts(6.0)
            sim.tick()
        assert len(sim.shots) == 3 and sim.fuel.held == 0
        first, second = sim.shots[0].points[1], sim.shots[0].points[3]
        assert second[0] < first[0]  # it flies to the back
        assert abs(second[1] - first[1]) < 0.01


def test_mechanisms_of_the_file_load_the_battery_and_guesses_do_not():
    sim, robot = practice(settings(), DRIVE)
    with sim:
        guess = ShaftSim(gearbox(1.0), 0.01)
        robot.add_mechanism(guess)
        guess.set_volts(12.0)
        robot.named["wheels"].set_volts(6.0)
        sim.tick()
        assert guess.velocity > 0.0
        assert robot.mechanism_current == pytest.approx(robot.named["wheels"].supply_current)
        robot.remove_mechanism(guess)
        speed = guess.velocity
        sim.tick()
        assert guess.velocity == speed


def test_a_preload_beyond_the_rules_and_a_start_in_a_wall_are_refused():
    with pytest.raises(ConfigError, match=r"preload must be 0\.\.8"):
        practice(settings(preload=9), DRIVE)
    with pytest.raises(ConfigError, match="starts inside of a field element"):
        practice(settings(start=(4.6, 4.03, 0.0)), DRIVE)


def test_the_match_clock_follows_the_driver_station():
    """Practice for a while, then a match: game data comes with teleop, of the auto fuel of this match alone."""
    sim, robot = practice(settings(), DRIVE)
    with sim:
        assert isinstance(robot, PracticeRobot)
        play(sim, 0.5)
        assert sim.game_message == ""
        sim.start_period("auto")
        assert sim.match_time == 0.0 and sim.game_message == ""
        zone = next(z for z in sim.tracker.zones if z.alliance == "red")
        sim._worth(zone, sim.time)
        play(sim, 0.1)
        assert sim.match_time == pytest.approx(0.1)
        sim.start_period("teleop")
        assert sim.match_time == pytest.approx(23.0)
        assert sim.game_message == "R"  # red scored more, so its hub is off first
        sim.start_period("auto")
        assert sim.game_message == ""
