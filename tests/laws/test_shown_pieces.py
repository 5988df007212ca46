"""Published poses of pieces are never stale, and their arrays are reused while nothing moves."""

from __future__ import annotations

import numpy as np

from simcore.match.motion import Motion
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.piece_manager import GamePieceManager
from simcore.world.shapes import Box, Sphere
from simcore.world.world import PhysicsWorld

DT = 0.02
BALL = GamePieceConfig(name="Ball", shape=Sphere(0.1), mass=0.2, friction=0.8, restitution=0.5)
CRATE = GamePieceConfig(name="Crate", shape=Box((0.3, 0.3, 0.3)), mass=1.0, friction=0.8, restitution=0.2)


def seen(pieces: GamePieceManager, name: str) -> tuple[np.ndarray, np.ndarray]:
    slots = pieces.on_field(name)
    return slots, np.hstack((pieces.state.pos[slots], pieces.attitudes(slots)))


def test_exactly_the_pieces_on_the_field_are_published():
    """The test compares every tick of a fall, of a chain of hits, and of pieces that are taken and put back."""
    with PhysicsWorld() as world:
        pieces = GamePieceManager(world, [(BALL, 4), (CRATE, 2)], field_size=(16.0, 8.0))
        balls = pieces.spawn("Ball", np.array([[2.0 + 0.2 * k, 4.0, 0.1] for k in range(3)]))
        pieces.spawn("Crate", np.array([[5.0, 4.0, 0.6]]))
        motion, shown, reused = Motion(world, pieces=pieces), [], 0
        for tick in range(300):
            if tick == 100:
                pieces.push(balls[:1], np.array([[3.0, 0.0, 0.0]]))
            if tick == 200:
                pieces.hold(balls[1:2], 0)
            if tick == 210:
                pieces.release(balls[1:2], np.array([[8.0, 4.0, 0.1]]))
            motion.tick()
            now = [pieces.shown.of(kind) for kind in (0, 1)]
            for (slots, rows), name in zip(now, ("Ball", "Crate"), strict=True):
                there, poses = seen(pieces, name)
                assert np.array_equal(slots, there), tick
                assert np.array_equal(rows, poses), tick
                assert not rows.flags.writeable
            reused += bool(shown) and now[0][1] is shown[0][1]
            shown = now
        assert np.ptp([row[0] for row in shown[0][1]]) > 2.0, "balls have moved"
        assert 20 < reused < 290
