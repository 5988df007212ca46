"""A tick cut into parts, so that motor controllers can listen in between, is still that tick."""

from __future__ import annotations

from dataclasses import replace

import pytest
from games.rebuilt.sim import RebuiltConfig, RebuiltSim

from games.rebuilt.robot import RebuiltRobotConfig
from simcore.errors import ConfigError

STEPS = 50


def drive_ahead(parts: int) -> tuple[tuple[float, float, float], float, int]:
    with RebuiltSim(RebuiltConfig()) as sim:
        robot = sim.robots[0]
        robot.drive.set_volts([3.0] * 4, [0.0] * 4)
        robot.shooter_wheels.set_volts(6.0)
        for _ in range(STEPS):
            sim.begin_tick()
            for _ in range(parts):
                sim.move(0.02 / parts)
            sim.end_tick()
        assert sim.ticks == STEPS and sim.substeps >= parts
        return robot.chassis.pose, robot.shooter_wheels.velocity, sim.ticks


def test_a_tick_in_four_parts_ends_where_a_tick_in_one_does():
    """The plant's own steps are 5 ms at most either way, so only the engine's coarser cut differs."""
    (one, wheel_one, _), (four, wheel_four, _) = drive_ahead(1), drive_ahead(4)
    assert one[0] > 2.6
    assert four == pytest.approx(one, abs=0.02)
    assert wheel_four == pytest.approx(wheel_one, rel=0.002)


def test_a_drivetrain_that_does_not_fit_its_chassis_is_refused():
    config = RebuiltRobotConfig()
    with pytest.raises(ConfigError, match="mass of drivetrain and chassis must agree"):
        RebuiltRobotConfig(drivetrain=replace(config.swerve, mass=40.0))


def test_practice_counts_every_fuel():
    with RebuiltSim(RebuiltConfig(hubs_always_active=True)) as sim:
        assert all(sim.scoring.is_active(alliance, 50.0) for alliance in ("blue", "red"))
    with RebuiltSim(RebuiltConfig()) as sim:
        assert not all(sim.scoring.is_active(alliance, 50.0) for alliance in ("blue", "red"))
