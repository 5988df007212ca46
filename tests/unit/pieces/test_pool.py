"""The pool: bodies made once, parked apart, and shown to the engine only when asked."""

from __future__ import annotations

import numpy as np
import pytest

from simcore.errors import CapacityError, NonFiniteError
from simcore.physics.shapes import Box, Sphere
from simcore.physics.world import PhysicsWorld
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.pool import PiecePool, PieceStatus

FUEL = GamePieceConfig(name="Fuel", shape=Sphere(0.075), mass=0.2)
CRATE = GamePieceConfig(name="Crate", shape=Box((0.3, 0.3, 0.3)), mass=1.0)


class RecordingEngine:
    """Remembers per row what it was told last."""

    gravity = 9.80665

    def __init__(self):
        self.poses, self.masks, self.asleep = [], [], []

    def add_body(self, definition):
        self.poses.append(tuple(definition.pos))
        self.masks.append(definition.mask)
        self.asleep.append(False)
        return len(self.poses) - 1

    def set_pose(self, row, pos, quat):
        self.poses[row] = tuple(pos)

    def set_collision(self, row, group, mask):
        self.masks[row] = mask

    def sleep(self, row):
        self.asleep[row] = True

    fix = sleep

    def wake(self, row):
        self.asleep[row] = False


@pytest.fixture
def engine():
    return RecordingEngine()


@pytest.fixture
def pool(engine):
    return PiecePool(PhysicsWorld(engine=engine, floor=None), [(FUEL, 40), (CRATE, 3)])


def test_a_fresh_pool_has_bodies_of_those_that_are_no_balls_parked_apart(engine, pool):
    assert pool.rows == [-1] * 40 + [0, 1, 2]
    assert all(engine.asleep) and not any(engine.masks)
    places = np.array(engine.poses)
    apart = np.linalg.norm(places[:, None] - places[None], axis=2) + 9.0 * np.eye(3)
    assert apart.min() >= 1.0, "parked on one spot, a step takes seconds"
    assert places[:, 2].min() > 10.0
    assert (pool.state.status == PieceStatus.FREE).all() and pool.balls.is_ball.tolist() == [1] * 40 + [0] * 3


def test_slots_of_one_kind_are_together(pool):
    assert pool.state.kind.tolist() == [0] * 40 + [1] * 3
    assert pool.radius[0] == pytest.approx(0.075)
    assert pool.radius[42] == pytest.approx(CRATE.bounding_radius)
    assert pool.take(1, 3).tolist() == [40, 41, 42]


def test_taking_more_than_there_is_says_how_many_are_free(pool):
    pool.state.status[40] = PieceStatus.HELD
    with pytest.raises(CapacityError, match="Crate: 3 more wanted, but 1 of 3 are in play"):
        pool.take(1, 3)


def test_place_and_park(engine, pool):
    for slot in (5, 41):
        pool.place(slot, (1.0, 2.0, 3.0))
        assert pool.state.pos[slot].tolist() == pool.state.before[slot].tolist() == [1.0, 2.0, 3.0]
    row = pool.rows[41]
    assert engine.poses[row] == (1.0, 2.0, 3.0) and engine.masks[row] and not engine.asleep[row]
    for slot in (5, 41):
        pool.park(slot)
        assert pool.state.pos[slot].tolist() == [1.0, 2.0, 3.0], "where it was last seen"
    assert engine.masks[row] == 0 and engine.asleep[row] and engine.poses[row][2] > 10.0


@pytest.mark.parametrize("slot", [5, 41])
def test_a_place_that_is_no_number_moves_nothing(engine, pool, slot):
    before = list(engine.poses)
    with pytest.raises(NonFiniteError, match="position and attitude must be finite"):
        pool.place(slot, (1.0, float("nan"), 3.0))
    assert engine.poses == before and not any(engine.masks)
    assert pool.state.pos[slot].tolist() == [0.0, 0.0, 0.0]
