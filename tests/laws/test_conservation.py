"""Every operation on pieces conserves their number, even a refused operation."""

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from simcore.errors import SimcoreError
from simcore.match.motion import Motion
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.piece_manager import Footprint, GamePieceManager
from simcore.pieces.pool import PieceStatus
from simcore.world.shapes import Sphere
from simcore.world.world import PhysicsWorld

pytestmark = pytest.mark.engines("bullet")

FUEL = GamePieceConfig(name="Fuel", shape=Sphere(0.075), mass=0.2)
CAPACITY = 30
DT = 0.02

number = st.integers(0, 8)
place = st.tuples(st.floats(0.5, 15.5), st.floats(0.5, 7.5), st.floats(0.075, 2.0))
velocity = st.tuples(st.floats(-20, 20), st.floats(-20, 20), st.floats(-5, 20))
bad = st.sampled_from([math.nan, math.inf, -math.inf])

step = st.one_of(
    st.tuples(st.just("spawn"), st.lists(place, max_size=5)),
    st.tuples(st.just("spawn bad"), place, bad),
    st.tuples(st.just("stage"), st.integers(-2, 8)),
    st.tuples(st.just("unknown")),
    st.tuples(st.just("hold"), number, st.integers(0, 1)),
    st.tuples(st.just("launch"), st.integers(0, 2), place, velocity),
    st.tuples(st.just("launch bad"), place, bad),
    st.tuples(st.just("score"), number),
    st.tuples(st.just("release"), number, place),
    st.tuples(st.just("push"), number, velocity),
    st.tuples(st.just("push bad"), number, bad),
    st.tuples(st.just("tick"), st.integers(1, 12), st.floats(0.0, 4.0)),
)


def some(pieces: GamePieceManager, status: tuple[PieceStatus, ...], count: int) -> np.ndarray:
    return np.nonzero(np.isin(pieces.state.status, status))[0][:count]


ON_FIELD = (PieceStatus.ASLEEP, PieceStatus.AWAKE, PieceStatus.IN_FLIGHT)
OFF_FIELD = (PieceStatus.STAGED, PieceStatus.SCORED)


def apply(pieces: GamePieceManager, world: PhysicsWorld, what: tuple) -> int:
    """Apply an operation; return the number of pieces that it adds to the match."""
    match what:
        case ("spawn", places):
            return len(pieces.spawn("Fuel", np.array(places).reshape(-1, 3)))
        case ("spawn bad", at, value):
            pieces.spawn("Fuel", np.array([at, (value, at[1], at[2])]))
        case ("stage", count):
            return len(pieces.stage("Fuel", count))
        case ("unknown",):
            pieces.stage("Feul", 1)
        case ("hold", count, robot):
            pieces.hold(some(pieces, (*ON_FIELD, PieceStatus.STAGED), count), robot)
        case ("launch", robot, at, vel):
            pieces.launch(robot, at, vel)
        case ("launch bad", at, value):
            pieces.launch(0, at, (1.0, value, 1.0))
        case ("score", count):
            pieces.score(some(pieces, ON_FIELD, count))
        case ("release", count, at):
            slots = some(pieces, OFF_FIELD, count)
            pieces.release(slots, np.array([at] * len(slots)).reshape(-1, 3) + 0.2 * np.arange(len(slots))[:, None])
        case ("push", count, vel):
            slots = some(pieces, ON_FIELD, count)
            pieces.push(slots, np.array([vel] * len(slots)).reshape(-1, 3))
        case ("push bad", count, value):
            slots = some(pieces, ON_FIELD, count)
            pieces.push(slots, np.full((len(slots), 3), value))
        case ("tick", ticks, speed):
            for _ in range(ticks):
                Motion(world, pieces=pieces).tick(others=[Footprint(8.0, 4.0, 0.3, 0.4, 0.4, speed)])
    return 0


def census(pieces: GamePieceManager) -> dict[PieceStatus, int]:
    return {status: pieces.count(status) for status in PieceStatus}


@settings(max_examples=40, suppress_health_check=list(HealthCheck))
@given(st.lists(step, min_size=5, max_size=40))
def test_any_sequence_of_operations_conserves_the_number_of_pieces(steps):
    with PhysicsWorld() as world:
        pieces = GamePieceManager(world, [(FUEL, CAPACITY)], field_size=(16.0, 8.0))
        total = 0
        for what in steps:
            before = census(pieces)
            try:
                total += apply(pieces, world, what)
            except SimcoreError:
                after = census(pieces)
                assert after[PieceStatus.HELD] == before[PieceStatus.HELD], f"{what} was refused, but changed something"
                assert after[PieceStatus.SCORED] == before[PieceStatus.SCORED]
            counts = census(pieces)
            state = pieces.state
            assert sum(counts.values()) == CAPACITY
            assert counts[PieceStatus.FREE] == CAPACITY - total, what
            assert len(pieces.on_field()) == sum(counts[s] for s in ON_FIELD)
            assert np.isfinite(state.pos).all() and np.isfinite(state.vel).all()
            here = np.isin(state.status, ON_FIELD)
            assert (state.holder[state.status == PieceStatus.HELD] >= 0).all()
            assert (state.holder[here] == -1).all()
