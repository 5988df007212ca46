"""Pieces that leave the field, or lie where a robot is placed, return to free carpet."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simcore.match.game import PieceSupply
from simcore.match.match import Match
from simcore.match.motion import Motion
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.piece_manager import Footprint, GamePieceManager
from simcore.pieces.pool import PieceStatus
from simcore.world.contact_law import WALL
from simcore.world.shapes import Box, Sphere
from simcore.world.world import PhysicsWorld

pytestmark = pytest.mark.engines("bullet")

DT = 0.02
RADIUS = 0.075
FUEL = GamePieceConfig(name="Fuel", shape=Sphere(RADIUS), mass=0.215, friction=0.8, restitution=0.55)


def play(world, pieces, seconds):
    motion = Motion(world, pieces=pieces)
    for _ in range(round(seconds / DT)):
        motion.tick()


def least_distance(pos: np.ndarray) -> float:
    return float((np.linalg.norm(pos[:, None] - pos[None], axis=2) + np.eye(len(pos))).min())


def test_thirty_shots_out_of_the_field_return_without_overlap():
    with PhysicsWorld() as world:
        pieces = GamePieceManager(world, [(FUEL, 30)], field_size=(16.0, 8.0))
        slots = pieces.stage("Fuel", 30)
        pieces.hold(slots, 0)
        for _ in range(30):
            pieces.launch(0, (8.0, 7.0, 0.5), (0.0, 6.0, 5.0))
            play(world, pieces, 0.1)
        play(world, pieces, 3.0)
        pos = pieces.state.pos[slots]
        assert pieces.recovered == 30
        assert (pieces.state.status[slots] == PieceStatus.ASLEEP).all()
        assert (pos[:, 1] < 8.0 - RADIUS).all() and pos[:, 2] == pytest.approx(RADIUS, abs=0.002)
        assert least_distance(pos) > 2 * RADIUS
        assert np.abs(pos[:, 0] - 8.0).max() < 1.0, "near where they left"


@pytest.mark.parametrize("place", [(8.0, 8.4, 0.1), (8.0, 8.15, 0.6)], ids=["behind the wall", "on the wall"])
def test_a_piece_at_rest_behind_or_on_a_wall_returns_to_the_field(place):
    with PhysicsWorld() as world:
        world.add_static("wall", Box((16.0, 0.3, 0.5)), (8.0, 8.15, 0.25), surface=WALL)
        pieces = GamePieceManager(world, [(FUEL, 1)], field_size=(16.0, 8.0))
        slot = pieces.spawn("Fuel", np.array([place]))[0]
        play(world, pieces, 4.0)
        assert pieces.recovered == 1
        assert pieces.state.pos[slot, 1] < 8.0 - RADIUS and pieces.state.pos[slot, 2] == pytest.approx(
            RADIUS, abs=0.002
        )


def test_a_piece_never_returns_into_a_robot_or_a_post():
    with PhysicsWorld() as world:
        world.add_static("post", Box((0.2, 0.2, 1.0)), (8.5, 7.7, 0.5), surface=WALL)
        pieces = GamePieceManager(world, [(FUEL, 2)], field_size=(16.0, 8.0))
        robot = Footprint(8.0, 7.6, 0.0, 0.4, 0.4, 0.0)
        slots = pieces.spawn("Fuel", np.array([[8.0, 9.0, 1.0], [8.5, 9.0, 1.0]]))
        Motion(world, pieces=pieces).tick(others=[robot])
        pos = pieces.state.pos[slots]
        assert pieces.recovered == 2
        assert (robot.gap(pos) > RADIUS).all()
        assert (np.maximum(np.abs(pos[:, 0] - 8.5), np.abs(pos[:, 1] - 7.7)) > 0.1 + RADIUS).all()


def test_a_robot_is_never_placed_on_fuel():
    """The robot is placed at the start of a match and again when it changes alliance."""
    supply = PieceSupply(FUEL, 60)
    with Match.bare(pieces=[supply], start=(3.0, 3.0, 0.3)) as match:
        grid = np.array([[12.6 + 0.16 * i, 4.6 + 0.16 * j, RADIUS] for i in range(7) for j in range(7)])
        slots = match.pieces.spawn("Fuel", grid)
        match.set_alliance(0, "red")
        robot = match.robots[0].chassis
        box = Footprint(*robot.footprint)
        pos = match.pieces.state.pos[slots]
        assert math.hypot(robot.pos[0] - 13.0, robot.pos[1] - 5.0) < 0.1, "it stands where fuel lay"
        assert (box.gap(pos) > RADIUS - 1e-9).all()
        assert least_distance(pos) > 2 * RADIUS
        match.play(2.0)
        assert (Footprint(*robot.footprint).gap(match.pieces.state.pos[slots]) > 0.0).all()
        assert abs(robot.pos[2]) < 0.005, "and it stands on the carpet"
