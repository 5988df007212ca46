"""The fleet view contains the values that each robot reports."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simcore.match.game import Game, RobotEntry
from simcore.match.match import Match
from simcore.robot.chassis import ground_clearance
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.fleet_view import FleetView
from simcore.robot.robot_config import RobotConfig
from simcore.robot.swerve_drive import SwerveDrive


def settled(speed: float, angle: float) -> list[float]:
    """Return a module state rounded to 1 mm/s and 1 mrad, with the angle within half a turn."""
    return [round(speed, 3), round(math.remainder(angle, math.tau), 3)]


def test_each_row_of_the_fleet_view_has_the_values_reported_by_its_robot() -> None:
    tank = RobotConfig(drivetrain=TankConfig())
    robots = [RobotEntry(start=(2.0, 2.0, 0.3)), RobotEntry(start=(2.0, 5.0, 0.0), config=tank)]
    robots.append(RobotEntry(start=(8.0, 4.0, 2.0)))
    with Match(Game.bare(size=(16.0, 8.0)), robots=robots) as match:
        view, (one, _, other) = FleetView(match.robots), match.robots
        assert isinstance(one.drive, SwerveDrive) and isinstance(other.drive, SwerveDrive)
        other.drive.set_volts([3.0] * 4, [2.0] * 4)
        for tick in range(40):
            one.drive.set_chassis_speeds(1.5, -0.2 * tick, 3.0)
            match.tick()
            view.look(match.world.robots.fleet, match.world.bodies.records)
            for number, robot in enumerate(match.robots):
                (x, y, z, w), (bx, by, yaw) = robot.chassis.quat, robot.believed_pose
                assert view.places[number].tolist() == [*robot.chassis.pos, w, x, y, z]
                assert view.heights[number] == pytest.approx(
                    ground_clearance(*robot.chassis.wheel_ground()).height, abs=1e-12
                )
                assert view.slips[number] == robot.drive.wheel_slip
                half = 0.5 * round(yaw, 3)
                expected = [round(bx, 3), round(by, 3), 0.0, math.cos(half), 0.0, 0.0, math.sin(half)]
                assert view.believed[number] == pytest.approx(expected, abs=1e-15)
        for number, robot in ((0, one), (2, other)):
            speeds, angles = robot.drive.wheel_speeds(), robot.drive.wheel_angles()
            states = [settled(speed, angle) for speed, angle in zip(speeds, angles, strict=True)]
            assert view.module_states[number].tolist() == states
        request = one.drive.shafts["request"]["value"].reshape(2, 4)
        assert view.module_setpoints[0].tolist() == [settled(*row) for row in request.T.tolist()]
        assert view.module_states[1] is view.module_setpoints[1] is None, "a tank has no modules"
        assert view.module_setpoints[2].shape == (0, 2), "its motors are told volts"
        other.module_setpoints = np.array([(1.23456, 7.0), (-0.00001, 0.0)])
        view.look(match.world.robots.fleet, match.world.bodies.records)
        assert view.module_setpoints[2].tolist() == [settled(1.23456, 7.0), [0.0, 0.0]], "as robot code wants them"
        assert not np.signbit(view.module_setpoints[2][1, 0])
