"""Another team's robot on the field of REBUILT: intake on an arm, shooter to the back, no components."""

from __future__ import annotations

import math

import pytest

from games.rebuilt import REBUILT
from simcore.match.game import RobotEntry
from simcore.match.match import Match
from simcore.pieces.intake import IntakeConfig, IntakeZone
from simcore.pieces.launch import LaunchParameters
from simcore.pieces.shooter import ShooterConfig
from simcore.pieces.storage import StorageConfig
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import ArmConfig, FlywheelConfig, RollerConfig
from simcore.robot.robot_config import RobotConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig


def gearbox(ratio: float) -> GearboxConfig:
    return GearboxConfig(motor=motor("Kraken X60"), gearing=ratio)


MECHANISMS = {
    "roller": RollerConfig(gearbox=gearbox(3.0), inertia=0.001, radius=0.02),
    "pivot": ArmConfig(gearbox=gearbox(50.0), inertia=0.2, min_angle=0.0, max_angle=1.5, start_angle=1.5),
    "wheels": FlywheelConfig(gearbox=gearbox(0.8), inertia=0.004),
    "hood": ArmConfig(gearbox=gearbox(90.0), inertia=0.05, min_angle=0.0, max_angle=0.7),
}
ZONE = IntakeZone(x_min=0.3, x_max=0.6, y_min=-0.4, y_max=0.4, z_max=0.2)
SHOOTER = ShooterConfig(
    wheels=("wheels",), hood="hood", gate=("roller",), wheel_radius=0.05, exit_efficiency=0.5, elevation=1.2,
    launch=LaunchParameters(height=0.5, forward=0.2, heading=math.pi), shot_rate=8.0,
)  # fmt: skip


def played(*, start=None, preload=0, **parts) -> Match:
    drivetrain = SwerveConfig.square(0.5, SwerveModuleConfig(x=0, y=0), mass=48.0)
    config = RobotConfig(drivetrain=drivetrain, mechanisms=MECHANISMS, storage=StorageConfig(capacity=7), **parts)
    return Match(REBUILT, robots=(RobotEntry(start=start, preload=preload, config=config),))


@pytest.mark.parametrize(("out_at", "start_is_out"), [("lower", False), ("upper", True)])
def test_the_intake_works_while_it_is_out_and_its_roller_turns(out_at, start_is_out):
    intake = IntakeConfig(zone=ZONE, roller="roller", deploy="pivot", deployed_at=out_at)
    with played(intakes=(intake,)) as match:
        robot = match.robots[0]
        assert not robot.intakes[0].is_active
        robot.mechanisms["roller"].set_volts(8.0)
        match.play(0.4)
        assert robot.intakes[0].is_active == start_is_out
        robot.mechanisms["pivot"].set_volts(-3.0)
        match.play(1.0)
        assert robot.mechanisms["pivot"].position == 0.0
        assert robot.intakes[0].is_active != start_is_out
        assert match.snapshot().booleans["Sim/Debug/IntakeZoneActive"] != start_is_out


def test_it_takes_in_what_lies_in_its_zone_and_no_more_than_it_holds():
    """It starts before the fuel of its alliance's depot and drives into it, the intake ahead."""
    with played(intakes=(IntakeConfig(zone=ZONE, roller="roller"),), start=(1.6, 5.96, math.pi)) as match:
        robot = match.robots[0]
        for _ in range(60):
            robot.mechanisms["roller"].set_volts(8.0)
            robot.drive.set_chassis_speeds(1.5, 0.0, 0.0)
            match.tick()
        assert match.count.held == 7
        assert match.snapshot().integers["Sim/Intake/HeldCount"] == 7


def test_shots_leave_when_fed_where_the_shooter_looks():
    """Rim speed times efficiency, to the robot's back, at the hood's elevation; the preload, no more."""
    with played(shooters=(SHOOTER,), preload=3) as match:
        robot = match.robots[0]
        robot.mechanisms["wheels"].set_volts(6.0)
        match.play(1.2)
        assert match.record.shots == []
        assert robot.shooters[0].aim.speed == pytest.approx(robot.mechanisms["wheels"].velocity * 0.05 * 0.5)
        robot.mechanisms["hood"].reset(0.4)
        assert robot.shooters[0].aim.elevation == pytest.approx(0.8)
        robot.mechanisms["roller"].set_volts(6.0)
        match.play(0.8)
        assert len(match.record.shots) == 3 and match.count.held == 0
        first, second = match.record.shots[0].points[1], match.record.shots[0].points[3]
        assert second[0] < first[0], "it flies to the back"
        assert abs(second[1] - first[1]) < 0.01
