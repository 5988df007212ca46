"""Metrics of shots, from the record of a run."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from each_case import each

from simcore.match.run_record import RunRecord
from simcore.match.scoring import ScoreEvent
from simcore.pieces.pool import PieceStatus
from simcore.sweep.run_metrics import METRICS


def played(heights, *, touched, scored):
    """Return the match of a shot that is at x = 0, 1, 2 ... m and at a height in each tick.

    Args:
        heights: Height in each tick, the first as the shot leaves [m].
        touched: Tick in which the shot first touches something.
        scored: Tick in which the shot scores; None if it does not.
    """
    state = SimpleNamespace(pos=np.zeros((1, 3)), status=np.array([PieceStatus.IN_FLIGHT]), kind=np.array([0]))
    pieces = SimpleNamespace(state=state, types=[SimpleNamespace(rest_height=0.075)], is_untouched=np.array([True]))
    record = RunRecord(pieces, [], 0.02)
    record.robots = [SimpleNamespace(after_tick=lambda time: None, shortfalls=SimpleNamespace(note_shot=lambda: None))]
    for tick, height in enumerate(heights):
        state.pos[0] = tick, 0.0, height
        pieces.is_untouched[0] = tick < touched
        if tick == 0:
            record.note_shot(0, 0, tuple(state.pos[0].tolist()))
        elif tick == scored:
            record.note_scored(ScoreEvent(0.02 * tick, "zone", "blue", 1, 0))
        record.after_tick(0.02 * tick)
    return SimpleNamespace(record=record)


@each(("ticks", "scored", "flying", "share"), [(4, None, 1, math.nan), (9, None, 0, 0.0), (9, 8, 0, 1.0)])
def test_a_shot_still_in_the_air_is_neither_hit_nor_miss(ticks, scored, flying, share):
    match = played([1.0, 1.2, 1.0, 0.4, 0.4, 0.8, 0.6, 0.1, 0.5][:ticks], touched=4, scored=scored)
    assert METRICS["flying"](match) == flying and METRICS["hit_share"](match) == pytest.approx(share, nan_ok=True)
