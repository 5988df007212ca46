from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from simcore.telemetry.sinks import Cadence


@given(period=st.integers(1, 50), ticks=st.integers(1, 2000))
def test_every_slot_is_taken_once(period: int, ticks: int) -> None:
    """A period of k ticks gives one snapshot per k ticks, plus the one of the slot that was begun."""
    cadence = Cadence(period * 0.02)
    taken = sum(cadence.take(0.02 * tick) for tick in range(ticks))
    assert taken == (ticks - 1) // period + 1


def test_restart_is_due_again() -> None:
    cadence = Cadence(0.02)
    cadence.take(5.0)
    assert not cadence.due(5.0)
    assert cadence.due(0.02)
