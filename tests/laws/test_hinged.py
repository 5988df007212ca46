"""Hinged bodies: a seesaw tips under a robot, meets its stops and levels out again."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from simcore.errors import ConfigError
from simcore.match.game import Game
from simcore.match.match import Match
from simcore.robot.robot_config import RobotConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.units import GRAVITY
from simcore.world.hanging import HangingBody, HangingConfig
from simcore.world.rotation import rotate
from simcore.world.shapes import Box
from simcore.world.world import PhysicsWorld

LENGTH, WIDTH, THICK, MASS, HEIGHT = 1.9, 2.4, 0.04, 60.0, 0.16
RISE = 0.03  # height of the center above the hinge
PLATE = HangingConfig(
    name="seesaw",
    shape=Box((LENGTH, WIDTH, THICK)),
    mass=MASS,
    pivot=(6.0, 4.0, HEIGHT),
    drop=-RISE,
    hinge="y",
    spring=800.0,
    damping=0.0,
    drivable=True,
)
INERTIA = MASS * (RISE**2 + (LENGTH**2 + THICK**2) / 12.0)
STOP = math.asin((HEIGHT + RISE - 0.5 * THICK) / (0.5 * LENGTH))  # approximate angle at which an edge meets the carpet


def test_a_seesaw_swings_with_the_period_of_its_spring_minus_its_weight():
    """T = 2 pi sqrt(I / (k - m g r)): the weight above the hinge acts against the spring."""
    passes, before, h, time = [], 1.0, 0.005, 0.0
    with PhysicsWorld() as world:
        body = HangingBody(world, PLATE)
        world.set_velocity(body.row, (0.0, 0.0, 0.0), (0.0, 0.02, 0.0))
        while time < 12.0:
            world.step(h)
            time += h
            if body.angle * before < 0.0:
                passes.append(time - h * abs(body.angle) / (abs(body.angle) + abs(before)))
            before = body.angle
        assert body.quat[0] == body.quat[2] == 0.0, "it turns about its hinge alone"
    period = 2.0 * math.pi * math.sqrt(INERTIA / (PLATE.spring - MASS * GRAVITY * RISE))
    assert 2.0 * np.diff(passes).mean() == pytest.approx(period, rel=1e-3)


def seesaw(**changes):
    config = SwerveConfig.square(0.53, SwerveModuleConfig(x=0.0, y=0.0))
    game = Game.bare(robot=lambda: RobotConfig(drivetrain=config))
    plate = replace(PLATE, damping=4.0, **changes)
    return replace(game, field=replace(game.field, hanging=(plate,)), starts=((3.0, 4.0, 0.0),))


def drive(match, goal, seconds, speed=1.0):
    """Drive along x to a goal [m] and slow down near it; return the plate angles [rad] and the contacts."""
    robot, (plate,) = match.robots[0], match.hanging
    angles, seen = [], set()
    for _ in range(round(seconds / 0.02)):
        vx = max(-speed, min(speed, 4.0 * (goal - robot.chassis.pose[0])))
        robot.drive.set_chassis_speeds(vx, 0.0, 0.0)
        match.tick()
        angles.append(plate.angle)
        seen |= match.contacts.hanging
    return angles, seen


def test_a_driving_robot_tips_a_seesaw_to_its_stops_and_balances_on_it():
    with Match(seesaw()) as match:
        (plate,), robot = match.hanging, match.robots[0]
        robot.carry_to((6.0 - 0.5 * LENGTH + 0.3, 4.0, 0.0))
        angles, seen = drive(match, 6.0 - 0.55, 3.0)
        assert min(angles) == pytest.approx(-STOP, abs=0.03), "its edge is on the carpet"
        assert (0, "seesaw") in seen
        angles, _ = drive(match, 6.0, 5.0)
        assert abs(plate.angle) < math.radians(2.5) and abs(plate.rate[1]) < 0.02, "level, with the robot on it"
        assert robot.chassis.pos[2] == pytest.approx(HEIGHT + RISE + 0.5 * THICK, abs=0.01)
        angles, _ = drive(match, 6.0 + 0.55, 3.0)
        assert max(angles) == pytest.approx(STOP, abs=0.03)
        drive(match, 9.0, 4.0)
        assert robot.chassis.pos[2] == pytest.approx(0.0, abs=0.01) and robot.chassis.pose[0] > 8.5
        assert abs(plate.angle) < 0.01 and not plate.is_awake, "by its spring"


@pytest.mark.parametrize("damping", [3.0, 60.0])
@pytest.mark.parametrize("place", [0.1, -0.2])
def test_a_robot_at_rest_tips_a_seesaw_until_its_spring_balances(place, damping):
    """K a = m g r sin a + M g x at any damping."""
    game = seesaw(spring=2500.0)
    plate = replace(game.field.hanging[0], damping=damping)
    with Match(replace(game, field=replace(game.field, hanging=(plate,)))) as match:
        (body,), chassis = match.hanging, match.robots[0].chassis
        match.robots[0].carry_to((6.0 + place, 4.0, 0.0))
        match.robots[0].drive.set_volts([0.0] * 4, [0.0] * 4)
        match.play(8.0 if damping < 10.0 else 4.0)
        mass, center, _ = chassis.distribution
        aside = chassis.pos[0] + rotate(chassis.quat, center)[0] - 6.0
        moment = MASS * GRAVITY * RISE * math.sin(body.angle) + mass * GRAVITY * aside
        assert 2500.0 * body.angle == pytest.approx(moment, rel=0.01)


def test_a_parked_robot_stays_where_it_is_on_a_tilted_seesaw():
    """At 2.6 degrees, the tires creep at slip_speed tan a / mu = 0.015 mm/s; a seesaw that sank would add to it."""
    game = seesaw(spring=2500.0)
    plate = replace(game.field.hanging[0], damping=60.0)
    with Match(replace(game, field=replace(game.field, hanging=(plate,)))) as match:
        (body,), robot = match.hanging, match.robots[0]
        robot.carry_to((6.0 - 0.2, 4.0, 0.0))
        robot.drive.set_volts([0.0] * 4, [0.0] * 4)
        match.play(4.0)
        before = robot.chassis.pos[0]
        match.play(2.0)
        assert math.degrees(body.angle) == pytest.approx(-2.6, abs=0.2)
        assert abs(robot.chassis.pos[0] - before) < 2 * 3e-5


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (dict(hinge="z"), "hinge must be 'x' or 'y' or None, got 'z'"),
        (dict(hinge=None, drop=0.2), "only a body with a hinge can have a spring or carry robots"),
        (dict(spring=-1.0), r"spring must be a number from 0 to 100000 N m/rad, got -1"),
    ],
)
def test_invalid_hinges_are_refused(change, said):
    with pytest.raises(ConfigError, match=said):
        replace(PLATE, **change)
