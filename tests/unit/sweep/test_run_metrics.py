"""Where shots come down, by the record of a run: what the map of landings is drawn from."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from simcore.match.run_record import RunRecord
from simcore.pieces.pool import PieceStatus
from simcore.sweep.run_metrics import METRICS, _landings


def played(heights, *, touched, scored):
    """Return the run of a shot that is at x = 0, 1, 2 ... m and at a height in each tick.

    Args:
        heights: In ticks, the first as it leaves [m].
        touched: The tick in which it first touches something.
        scored: The tick in which it scores; None: it does not.
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
            record.note_scored(0)
        record.after_tick(0.02 * tick)
    return SimpleNamespace(match=SimpleNamespace(record=record))


def landing(heights, *, touched, scored):
    """Return how far it came down, from the row of the metric."""
    ((x, _, z, hit),) = _landings(played(heights, touched=touched, scored=scored))
    assert z == pytest.approx(heights[int(x)]) and hit == (scored is not None)
    return x


BOUNCES = [1.0, 1.2, 1.0, 0.4, 0.4, 0.8, 0.6, 0.1, 0.5, 0.2]


def test_a_miss_came_down_where_it_fell_no_further():
    assert landing(BOUNCES, touched=4, scored=None) == 3, "of two equal heights the first"


def test_a_shot_in_the_air_at_the_end_is_neither_hit_nor_miss():
    run = played(BOUNCES[:4], touched=4, scored=None)
    assert _landings(run) == [] and METRICS["flying"](run) == 1 and math.isnan(METRICS["hit_share"](run))
    run = played(BOUNCES, touched=4, scored=None)
    assert len(_landings(run)) == 1 and METRICS["flying"](run) == 0 and METRICS["hit_share"](run) == 0.0


@pytest.mark.parametrize("tick", [2, 8, 180])
def test_a_hit_came_down_where_it_scored_however_often_it_bounced_and_however_late(tick):
    """Also after the 2 s of its way that are kept."""
    assert landing(BOUNCES * 20, touched=4, scored=tick) == tick
