"""What is looked at for impacts: the look at many balls at once leaves out none that may have one."""

from __future__ import annotations

import numpy as np
from simcore.pieces.ball_rows import Arc
from simcore.pieces.impact_events import _Body, _near_boxes

from simcore.physics.shapes import Box
from simcore.physics.world import PhysicsWorld
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.chassis_config import ChassisConfig

H = 0.005  # [s]


def arcs(rng: np.random.Generator, count: int) -> list[Arc]:
    """Balls in and around a box of 2 m, at up to 12 m/s, half of them in flight."""
    found = []
    for number in range(count):
        pos = tuple(rng.uniform((-1.5, -1.5, 0.0), (1.5, 1.5, 1.2)).tolist())
        vel = tuple((rng.normal(size=3) * rng.uniform(0.0, 4.0)).tolist())
        arc = Arc(number, number, 0.075, pos, vel, (0.0, 0.0, 0.0))
        if number % 2:
            arc.is_flying, arc.acc = True, (0.0, 0.0, -9.81)
        arc.aim(H)
        found.append(arc)
    return found


def test_balls_that_may_meet_a_robot_are_all_looked_at():
    with PhysicsWorld() as world:
        robot = ChassisSimulation(world, ChassisConfig())
        world.set_velocity(robot.row, (3.0, 1.0, 0.0), (0.0, 0.0, 5.0))
        body, balls = _Body(world, robot.row, H), arcs(np.random.default_rng(1), 3000)
        pos, chord = np.array([arc.pos for arc in balls]), np.array([arc.chord for arc in balls])
        may = np.zeros(len(balls), dtype=bool)
        may[[ball for ball, _ in _near_boxes([body], pos, chord, np.array([arc.radius for arc in balls]), H)]] = True
        near = np.array([body.is_near(arc, H) for arc in balls])
        assert near.sum() > 100 and not (near & ~may).any()
        assert (~may).sum() > 500, "most that are far are left out"


def test_what_is_met_is_what_a_look_at_each_ball_finds():
    """Balls thrown at a wall and a robot: the box around the wall leaves out no touch."""
    with PhysicsWorld() as world:
        world.add_static("wall", Box((0.1, 2.0, 1.0)), (0.8, 0.0, 0.5), surface=world.floor)
        balls = arcs(np.random.default_rng(2), 3000)
        pos = np.array([arc.pos for arc in balls])
        reach = np.array([arc.radius + H * np.linalg.norm(arc.chord) + 0.002 for arc in balls])
        near = world.near_field(pos, reach)
        touches = np.array(
            [world.first_touch(arc.pos, tuple(H * v for v in arc.chord), arc.radius) is not None for arc in balls]
        )
        assert touches.sum() > 20 and not (touches & ~near).any()
