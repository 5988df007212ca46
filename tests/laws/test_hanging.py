"""Hanging bodies: they swing like a pendulum, react to robots and balls, and sleep when nothing moves them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from simcore.errors import ConfigError
from simcore.match.game import FieldDefinition, Game, PieceSupply
from simcore.match.match import Match
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.pool import PieceStatus
from simcore.robot.climber import Rung
from simcore.robot.robot_config import RobotConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.units import GRAVITY
from simcore.world.contact_law import WALL
from simcore.world.field import FieldElement
from simcore.world.hanging import HangingBody, HangingConfig
from simcore.world.rotation import from_rpy, rotate
from simcore.world.shapes import Box, Sphere
from simcore.world.world import PhysicsWorld

MASS, DROP, EDGE, TALL = 7.0, 1.1, 0.2, 0.6
HEAVY = HangingConfig(
    name="weight", shape=Box((EDGE, EDGE, TALL)), mass=MASS, pivot=(4.0, 4.0, 1.5), drop=DROP, damping=0.0
)
INERTIA = MASS * (DROP**2 + (EDGE**2 + TALL**2) / 12.0)
BALL = GamePieceConfig(name="Ball", shape=Sphere(0.2), mass=0.5, friction=0.6, restitution=0.6, rolling=0.01)


def swing(seconds, angle, config=HEAVY, h=0.005):
    """Return the times of zero crossings, the energies above rest [J] and the largest error of the pivot [m]."""
    passes, energies, gap, before, time = [], [], 0.0, 1.0, 0.0
    with PhysicsWorld() as world:
        body = HangingBody(world, config)
        x, y, z = config.pivot
        there = (x + DROP * math.sin(angle), y, z - DROP * math.cos(angle))
        world.set_pose(body.row, there, from_rpy(0.0, -angle, 0.0))
        while time < seconds:
            world.step(h)
            time += h
            energies.append(MASS * GRAVITY * (body.pos[2] - z + DROP) + 0.5 * INERTIA * body.rate[1] ** 2)
            gap = max(gap, math.dist(np.add(body.pos, rotate(body.quat, (0.0, 0.0, DROP))), config.pivot))
            now = body.pos[0] - x
            if now * before < 0.0:
                passes.append(time - h * abs(now) / (abs(now) + abs(before)))
            before = now
    return np.array(passes), np.array(energies), gap


def geometric_mean(a, b):
    """Return the arithmetic-geometric mean of two numbers."""
    for _ in range(6):
        a, b = 0.5 * (a + b), math.sqrt(a * b)
    return a


@pytest.mark.parametrize("angle", [0.05, 0.3, 1.5])
def test_a_hanging_body_swings_with_the_period_of_a_pendulum_and_gains_no_energy(angle):
    """T = 2 pi sqrt(I / (m g d)) / agm(1, cos(a / 2)) at an amplitude a; a step of h = 1 ms errs by (h w)^2 / 24.

    Within a swing, the energy of semi-implicit Euler steps errs by up to h w / 2, with w = 2.95 rad/s.
    """
    passes, energies, gap = swing(5.0, angle)
    period = 2.0 * math.pi * math.sqrt(INERTIA / (MASS * GRAVITY * DROP)) / geometric_mean(1.0, math.cos(0.5 * angle))
    assert 2.0 * np.diff(passes).mean() == pytest.approx(period, rel=1e-4)
    start = MASS * GRAVITY * DROP * (1.0 - math.cos(angle))
    assert energies.max() < (1.0 + 0.5e-3 * 2.95 * 1.1) * start
    assert energies[-430:].max() < energies[:430].max() + 1e-4 * start
    assert gap < 1e-9


def test_damping_decays_a_swing_at_the_configured_rate():
    """The amplitude decays with exp(-c t / 2), so the energy decays with exp(-c t)."""
    _, energies, _ = swing(3.0, 0.2, replace(HEAVY, damping=0.4))
    assert energies[-1] / energies[0] == pytest.approx(math.exp(-0.4 * 3.0), rel=0.1)


def field_with(rungs=(), **changes):
    config = SwerveConfig.square(0.53, SwerveModuleConfig(x=0.0, y=0.0))
    game = Game.bare(robot=lambda: RobotConfig(drivetrain=config), pieces=(PieceSupply(BALL, 2),))
    hanging = (replace(HEAVY, **{"damping": 1.5} | changes),)
    return replace(game, field=replace(game.field, hanging=hanging, rungs=rungs), starts=((2.0, 4.0, 0.0),))


def test_a_pushed_body_comes_to_rest_and_falls_asleep():
    digests = []
    for seconds in (4.0, 0.0):
        with Match(field_with(damping=4.0)) as match:
            body, robot = match.hanging[0], match.robots[0]
            match.play(0.5)
            assert not body.is_awake
            robot.drive.set_chassis_speeds(2.0, 0.0, 0.0)
            reached = 0.0
            for _ in range(50):
                match.tick()
                reached = max(reached, body.pos[0] - 4.0)
            assert body.is_awake and reached > 0.2, "the bumper swings it aside"
            assert not match.world.has_engine
            assert np.linalg.norm(match.snapshot().pose_arrays["Sim/Hanging"][0, :3] - body.pos) < 1e-5
            robot.drive.set_chassis_speeds(-2.0, 0.0, 0.0)
            match.play(1.0)
            robot.drive.set_chassis_speeds(0.0, 0.0, 0.0)
            digests.append(match.digest.hexdigest())
            match.play(seconds)
            if not seconds:
                break
            assert not body.is_awake
            assert math.dist(body.pos, (4.0, 4.0, 1.5 - DROP)) < 0.003
            assert body.quat[3] == pytest.approx(1.0, abs=1e-5)
    assert digests[0] == digests[1]


def test_a_thrown_ball_transfers_its_momentum_to_a_hanging_body():
    """About the pivot: I w equals the loss of the ball, m (v - v') d."""
    with Match(field_with()) as match:
        slot = match.pieces.spawn("Ball", np.array([[3.0, 4.0, 1.5 - DROP + 0.1]]))
        match.pieces.push(slot, np.array([[6.0, 0.0, 0.5]]), flying=True)
        body, fastest, after = match.hanging[0], 0.0, 6.0
        for _ in range(20):
            match.tick()
            fastest = max(fastest, -body.rate[1])
            after = min(after, match.pieces.state.vel[slot[0], 0])
        assert after < 0.0, "it bounces off"
        assert fastest * INERTIA == pytest.approx(BALL.mass * (6.0 - after) * (DROP - 0.1), rel=0.15)
        assert match.count.is_conserved


def test_a_rung_on_an_unknown_hanging_body_is_refused():
    rung = Rung(name="bar", start=(4.0, 3.9, 0.7), end=(4.0, 4.1, 0.7), mount="wait")
    with pytest.raises(ConfigError, match=r"mount on \['wait'\].*no hanging body"):
        field_with((rung,))
    with pytest.raises(ConfigError, match="drop"):
        replace(HEAVY, drop=0.0)
    assert isinstance(field_with((replace(rung, mount="weight"),)).field, FieldDefinition)


def test_a_swinging_body_wakes_only_the_pieces_that_it_hits(engine_name):
    """A ball above the body stays asleep; the ball next to it is hit and moves."""
    game = field_with(damping=0.3)
    shelf = FieldElement(name="shelf", shape=Box((1.0, 1.0, 0.1)), position=np.array([4.0, 4.0, 1.6]), surface=WALL)
    game = replace(game, field=replace(game.field, elements=(*game.field.elements, shelf)))
    with Match(game, engine=engine_name) as match:
        body = match.hanging[0]
        above, beside = match.pieces.spawn("Ball", np.array([[4.0, 4.0, 1.86], [4.36, 4.0, 0.2]]))
        body.pull((4.0, 4.0, 0.4), (800.0, 0.0, 0.0))  # during one step of 5 ms
        match.play(0.5)
        assert match.pieces.state.pos[beside, 0] > 4.37, "it was pushed away"
        match.play(2.0)
        assert body.is_awake and body.speed > 0.02
        assert match.pieces.state.status[above] == PieceStatus.ASLEEP
