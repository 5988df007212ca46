"""Invalid requests for pieces and invalid worlds are refused and change nothing."""

import math

import numpy as np
import pytest

from games.rebuilt.fuel import FUEL
from simcore.errors import CapacityError, ConfigError, NonFiniteError, UnknownNameError
from simcore.match.motion import Motion
from simcore.pieces.piece_manager import GamePieceManager
from simcore.pieces.pool import PieceStatus
from simcore.world.world import PhysicsWorld

pytestmark = pytest.mark.engines("bullet")


def test_an_invalid_request_for_pieces_changes_nothing():
    with PhysicsWorld() as world:
        pieces = GamePieceManager(world, [(FUEL, 4)], field_size=(16.0, 8.0))
        slots = pieces.spawn("Fuel", np.array([[2.0, 2.0, 0.075], [3.0, 2.0, 0.075]]))
        free = np.array([3])
        for request in (
            lambda: pieces.score(free),
            lambda: pieces.hold(free, 0),
            lambda: pieces.push(free, np.ones((1, 3))),
            lambda: pieces.release(free, np.ones((1, 3))),
        ):
            with pytest.raises(ConfigError, match="piece 3 is FREE"):
                request()
        bad = np.array([[1.0, 1.0, 1.0], [math.nan, 1.0, 1.0]])
        for request in (lambda: pieces.release(slots, bad), lambda: pieces.push(slots, bad)):
            with pytest.raises(NonFiniteError, match="finite numbers"):
                request()
        pieces.hold(slots[1:], 0)
        fast = (0.0, 800.0, 800.0)  # the number of steps in a tick grows with the speed of a piece
        for request in (
            lambda: pieces.push(slots[:1], np.array([fast])),
            lambda: pieces.launch(0, (1.0, 1.0, 1.0), fast),
        ):
            with pytest.raises(ConfigError, match="speed must be a number from 0 to 1000 m/s, got 1131"):
                request()
        for request, error, said in (
            (lambda: pieces.launch(1, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)), CapacityError, "robot 1 has no piece"),
            (lambda: pieces.launch(0, (math.nan, 1.0, 1.0), (0.0, 0.0, 0.0)), NonFiniteError, "3 rows of 3 finite"),
            (lambda: pieces.stage("Fuel", 3), CapacityError, "Fuel: 3 more wanted, but 2 of 4 are in play"),
            (lambda: pieces.stage("Fuel", -1), ConfigError, "count must be a whole number from 0"),
            (lambda: pieces.spawn("Feul", np.ones((1, 3))), UnknownNameError, "Did you mean 'Fuel'"),
        ):
            with pytest.raises(error, match=said):
                request()
        assert pieces.count(PieceStatus.ASLEEP) == 1 and len(pieces.held(0)) == 1


def test_a_pushed_piece_flies_equally_in_whole_ticks_and_in_parts_of_ticks():
    """The ball is pushed at 5 m/s from a height of 1.5 m and flies for half a second."""
    ends = []
    for parts in (1, 2, 4):
        with PhysicsWorld() as world:
            pieces = GamePieceManager(world, [(FUEL, 1)], field_size=(16.0, 8.0))
            slots = pieces.spawn("Fuel", np.array([[2.0, 4.0, 1.5]]))
            pieces.push(slots, np.array([[5.0, 0.0, 0.0]]), flying=True)
            motion = Motion(world, pieces=pieces)
            for _ in range(25):
                motion.begin_tick()
                for _ in range(parts):
                    motion.advance(0.02 / parts)
                motion.end_tick()
            ends.append(pieces.state.pos[0].copy())
    assert ends[0][0] > 4.0
    assert np.ptp(np.array(ends), axis=0).max() < 0.003


def test_a_world_uses_the_gravity_of_its_engine():
    with PhysicsWorld(gravity=1.6) as world:
        assert world.gravity == PhysicsWorld(engine=world.engine).gravity == 1.6
        with pytest.raises(ConfigError, match="gravity"):
            PhysicsWorld(engine=world.engine, gravity=9.8)
