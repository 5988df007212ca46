"""Contacts of swinging bodies: with robots, stops and pieces, momentum is kept and energy does not rise."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from simcore.match.game import Game, PieceSupply, RobotEntry
from simcore.match.match import Match
from simcore.pieces.kinds import GamePieceConfig
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.chassis_config import ChassisConfig
from simcore.robot.robot_config import RobotConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.units import GRAVITY
from simcore.world.contact_law import WALL
from simcore.world.hanging import HangingBody, HangingConfig
from simcore.world.rotation import from_rpy, matrix, rotate
from simcore.world.shapes import Box, Cylinder
from simcore.world.world import PhysicsWorld

PIVOT = (4.0, 4.0, 1.6)
CAGE = HangingConfig(name="cage", shape=Box((0.2, 0.2, 0.6)), mass=7.0, pivot=PIVOT, drop=1.2, damping=0.0)
PLATE = HangingConfig(
    name="plate", shape=Box((1.9, 2.4, 0.04)), mass=60.0, pivot=(6.0, 4.0, 0.16), drop=-0.03, hinge="y", damping=0.0,
    drivable=True,
)  # fmt: skip


def motion(world, row, pivot):
    """Return the kinetic energy [J] and the angular momentum about a point [N m s] of a robot or swinging body."""
    body = world.bodies.of(row)[0]
    model, axes = body["model"], matrix(tuple(body["quat"].tolist()))
    inertia = np.where(np.isinf(model["inertia"]), 0.0, model["inertia"])
    spin = axes.T @ body["rate"]
    momentum = np.cross(body["com"] - pivot, model["mass"] * body["vel"]) + axes @ (inertia * spin)
    return 0.5 * float(model["mass"] * body["vel"] @ body["vel"] + inertia @ spin**2), momentum


@pytest.mark.parametrize("mass", [1.0, 7.0, 60.0])
@pytest.mark.parametrize("speed", [0.5, 4.0])
def test_a_robot_that_hits_a_cage_loses_the_angular_momentum_that_the_cage_gains(mass, speed):
    """Without gravity; the hit is central, so that the chain's torque about the line to the pivot is zero."""
    config = replace(CAGE, mass=mass)
    with PhysicsWorld(floor=None, gravity=1e-9) as world:
        body, robot = HangingBody(world, config), ChassisSimulation(world, ChassisConfig(), pose=(0.0, 0.0, 0.0))
        world.set_pose(robot.row, (3.4, 4.0, 0.3))
        world.set_velocity(robot.row, (speed, 0.0, 0.0))
        before, total = motion(world, robot.row, PIVOT)
        for _ in range(round(0.4 / speed / 0.005)):
            world.step(0.005)
            energy = motion(world, robot.row, PIVOT)[0] + motion(world, body.row, PIVOT)[0]
            assert energy < before * (1.0 + 1e-6)
        gained, lost = motion(world, body.row, PIVOT)[1], total - motion(world, robot.row, PIVOT)[1]
        assert gained[1] < -0.5 * mass * speed and gained[1] == pytest.approx(lost[1], rel=1e-3)


def thrown(seed):
    """Throw a robot at a cage or plate in any direction, and return the relative rise of the energy [-]."""
    rng = np.random.default_rng(seed)
    mass = float(rng.choice([1.0, 7.0, 60.0]))
    if seed % 2:
        shape, drop, hinge = Box(tuple(rng.uniform(0.08, 0.6, 3).tolist())), float(rng.uniform(0.3, 1.4)), None
    else:
        size = (*rng.uniform(0.5, 2.0, 2).tolist(), 0.04)
        shape, drop, hinge = Box(size), float(rng.uniform(-0.05, 0.05)), "y"
    config = replace(CAGE, shape=shape, mass=mass, drop=drop, hinge=hinge, drivable=hinge is not None)
    with PhysicsWorld(floor=None, gravity=1e-9) as world:
        body, robot = HangingBody(world, config), ChassisSimulation(world, ChassisConfig(), pose=(0.0, 0.0, 0.0))
        way = rng.normal(size=3) * (1.0, 1.0, 0.3)
        aim = np.array(body.pos) + 0.2 * rng.normal(size=3) - (0.0, 0.0, 0.15)
        start = np.array(body.pos) + 2.2 * way / np.linalg.norm(way)
        turn = rng.uniform(-3.0, 3.0, 3) if seed % 3 == 0 else (0.0, 0.0, float(rng.uniform(-3.0, 3.0)))
        world.set_pose(robot.row, start.tolist(), from_rpy(*map(float, turn)))
        speed = float(rng.uniform(0.3, 5.0))
        world.set_velocity(
            robot.row, (speed * (aim - start) / np.linalg.norm(aim - start)).tolist(), rng.normal(size=3)
        )
        before, most = motion(world, robot.row, PIVOT)[0], 0.0
        for _ in range(round(3.5 / speed / 0.005)):
            world.step(0.005)
            most = max(most, motion(world, robot.row, PIVOT)[0] + motion(world, body.row, PIVOT)[0])
    return most / before - 1.0


def test_hits_of_robots_on_swinging_bodies_raise_no_energy():
    """Robots upright and in any attitude, on bodies from 1 to 60 kg; tolerance: free spin, by explicit Euler steps."""
    assert max(map(thrown, range(60))) < 0.01


@pytest.mark.parametrize(
    ("stop", "angle"),
    [
        (None, math.asin(0.16 / math.hypot(0.95, 0.01)) + math.atan(0.01 / 0.95)),
        (((0.1, 3.0, 0.1), (6.7, 4.0, 0.05)), None),
        (((0.1, 0.5, 0.1), (6.7, 4.0, 0.05)), None),
    ],
    ids=["carpet", "bar", "block"],
)
def test_a_plate_that_falls_stops_on_carpet_bar_or_block_without_a_bounce(stop, angle):
    """The lower edge of the plate, at (0.95, 0.01) from the hinge, is on the carpet, or its underside on the stop."""
    with PhysicsWorld() as world:
        if stop is not None:
            size, place = stop
            world.add_static("stop", Box(size), place, surface=WALL)
            away, below = place[0] + 0.5 * size[0] - 6.0, 0.16 - size[2]
            angle = math.asin(0.01 / math.hypot(away, below)) + math.atan(below / away)
        body = HangingBody(world, PLATE)
        world.set_velocity(body.row, (0.0, 0.0, 0.0), (0.0, 0.5, 0.0))
        rebound, hit, deepest = 0.0, 0.0, 0.0
        for _ in range(600):
            world.step(0.005)
            hit, rebound = max(hit, body.rate[1]), min(rebound, body.rate[1])
            deepest = max(deepest, body.angle)
        assert hit > 0.5 and rebound > -0.15 * hit, "it bounces little"
        assert body.angle == pytest.approx(angle, abs=1e-3) and deepest < angle + 0.005
        assert abs(body.rate[1]) < 1e-6 and not world.has_engine


def on_plate(*places, **changes):
    """Return a match with robots on a plate at some x from the hinge [m]."""
    config = SwerveConfig.square(0.53, SwerveModuleConfig(x=0.0, y=0.0))
    game = Game.bare(robot=lambda: RobotConfig(drivetrain=config))
    plate = replace(PLATE, damping=60.0, spring=6000.0)
    entries = [RobotEntry(start=(2.0, 1.0 + 2.0 * number, 0.0)) for number in range(len(places))]
    match = Match(replace(game, field=replace(game.field, hanging=(plate,))), robots=entries, seed=1, **changes)
    for robot, (x, y) in zip(match.robots, places, strict=True):
        robot.carry_to((6.0 + x, 4.0 + y, 0.0))
        robot.drive.set_volts([0.0] * 4, [0.0] * 4)
    return match


def test_two_robots_tip_a_plate_to_the_sum_of_their_moments_and_stay_where_they_are():
    """K a = m g r sin a + sum of M g x, and each robot creeps by less than 0.1 mm/s."""
    with on_plate((0.3, 0.6), (-0.1, -0.6)) as match:
        (plate,) = match.hanging
        match.play(4.0)
        moment = PLATE.mass * GRAVITY * 0.03 * math.sin(plate.angle)
        for robot in match.robots:
            mass, center, _ = robot.chassis.distribution
            moment += mass * GRAVITY * (robot.chassis.pos[0] + rotate(robot.chassis.quat, center)[0] - 6.0)
        assert plate.angle > 0.01 and 6000.0 * plate.angle == pytest.approx(moment, rel=0.01)
        before = [robot.chassis.pos for robot in match.robots]
        match.play(2.0)
        assert max(math.dist(robot.chassis.pos, pos) for robot, pos in zip(match.robots, before, strict=True)) < 2e-4
        assert abs(plate.rate[1]) < 1e-5 and match.world.engine_name == "none"


def test_a_plate_with_a_robot_is_identical_with_either_engine():
    digests = set()
    for name in ("bullet", "mujoco"):
        with on_plate((0.2, 0.1), engine=name) as match:
            match.robots[0].drive.set_chassis_speeds(0.5, 0.0, 0.0)
            match.play(1.0)
            digests.add(match.digest.hexdigest())
    assert len(digests) == 1


@pytest.mark.parametrize("config", [CAGE, replace(CAGE, hinge="y", shape=Box((0.1, 1.0, 0.6)))], ids=["chain", "hinge"])
def test_a_thrown_tube_transfers_its_momentum_to_a_swinging_body(config):
    """About the pivot: I w equals the loss of the tube, m (v - v') d, at the first hit."""
    tube = GamePieceConfig(name="Tube", shape=Cylinder(0.1, 0.3), mass=2.0, friction=0.0, restitution=0.3)
    game = Game.bare(pieces=(PieceSupply(tube, 1),))
    game = replace(game, field=replace(game.field, hanging=(config,)), starts=((2.0, 1.0, 0.0),))
    with Match(game) as match:
        (body,) = match.hanging
        (slot,) = match.pieces.spawn("Tube", np.array([[3.2, 4.0, 0.45]]))
        match.pieces.push(np.array([slot]), np.array([[5.0, 0.0, 0.6]]), flying=True)
        row, inertia = match.pieces.row(slot), float(match.world.bodies.of(body.row)["model"]["inertia"][0, 1])
        for _ in range(12):
            match.tick()
        after = match.world.engine.velocity(row)[0][0]
        assert body.is_awake and after < 4.0
        angle = math.atan2(-(body.pos[0] - PIVOT[0]), PIVOT[2] - body.pos[2])
        swing = 0.5 * inertia * body.rate[1] ** 2 + config.mass * GRAVITY * config.drop * (1.0 - math.cos(angle))
        gained = math.sqrt(2.0 * inertia * swing)
        assert gained == pytest.approx(2.0 * (5.0 - after) * (PIVOT[2] - 0.45), rel=0.1)


def test_a_body_whose_velocity_or_pose_is_set_stays_on_its_pivot():
    with PhysicsWorld() as world:
        cage, plate = HangingBody(world, CAGE), HangingBody(world, PLATE)
        world.set_velocity(cage.row, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
        world.set_velocity(plate.row, (1.0, 0.0, 0.0), (0.3, 0.1, 0.3))
        for _ in range(100):
            world.step(0.005)
        assert math.dist(cage.pos, PIVOT) == pytest.approx(CAGE.drop, abs=1e-9)
        assert plate.rate[0] == plate.rate[2] == 0.0
        world.set_pose(cage.row, (0.0, 0.0, 0.0), from_rpy(0.0, 0.4, 0.0))
        assert cage.pos == pytest.approx((4.0 - 1.2 * math.sin(0.4), 4.0, 1.6 - 1.2 * math.cos(0.4)))


def test_a_body_at_rest_on_its_stop_falls_asleep():
    """Without a spring the plate lies on the carpet at one end, where the stop carries a part of its weight."""
    with PhysicsWorld() as world:
        plate = HangingBody(world, PLATE)
        world.set_velocity(plate.row, (0.0, 0.0, 0.0), (0.0, 0.2, 0.0))
        for _ in range(400):
            world.step(0.02)
            plate.after_tick(0.02)
        angle = plate.angle
        assert abs(angle) > 0.1 and not plate.is_awake
        world.step(0.005)
        assert plate.angle == angle


def test_a_piece_released_inside_a_robot_on_a_plate_lies_on_the_plate():
    """The piece ignores the robot alone until the piece is outside the robot."""
    tube = GamePieceConfig(name="Tube", shape=Cylinder(0.057, 0.3), mass=0.65)
    drive = SwerveConfig.square(0.53, SwerveModuleConfig(x=0.0, y=0.0))
    game = Game.bare(robot=lambda: RobotConfig(drivetrain=drive), pieces=(PieceSupply(tube, 2),))
    field = replace(game.field, hanging=(replace(PLATE, spring=5000.0, damping=4.0),))
    with Match(replace(game, field=field), robots=[RobotEntry(start=(2.0, 4.0, 0.0))]) as match:
        (robot,) = match.robots
        robot.carry_to((6.0, 4.0, 0.0))
        match.play(1.0)
        top = robot.chassis.pos[2]
        slot = int(match.pieces.spawn("Tube", np.array([(6.0, 4.0, top + 0.3)]))[0])
        match.play(1.5)
        assert top - 0.02 < match.pieces.state.pos[slot, 2] < top + 0.2
        assert math.dist(robot.chassis.pos, (6.0, 4.0, top)) < 0.01
