"""Sinks: their rate in memory, and a guard against full disks."""

import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from simcore.errors import ConfigError
from simcore.telemetry.sinks import Cadence, GuardedSink
from simcore.telemetry.snapshot import Snapshot
from simcore.telemetry.wpilog import WpilogSink


@given(period=st.integers(1, 50), ticks=st.integers(1, 2000))
def test_every_time_slot_gets_one_snapshot(period: int, ticks: int) -> None:
    """A period of k ticks gives one snapshot per k ticks, plus one for the slot that has begun."""
    cadence = Cadence(period * 0.02)
    taken = sum(cadence.take(0.02 * tick) for tick in range(ticks))
    assert taken == (ticks - 1) // period + 1


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full, the disk that is always full, on this system")
def test_a_full_disk_is_reported_once_and_does_not_end_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []
    monkeypatch.setattr("simcore.telemetry.wpilog.WpilogSink._flush", _flush_later(WpilogSink._flush))
    sink = GuardedSink(WpilogSink("/dev/full"), said.append)
    written = 0
    for tick in range(200):
        time = 0.02 * (tick + 1)
        if sink.due(time):
            sink.write(Snapshot(time=time, tick=tick, doubles={"a": time}))
            written += 1
    sink.close()
    assert len(said) == 1 and "No space left on device" in said[0] and "/dev/full" in said[0]
    assert sink.failure == said[0]
    assert written < 60, "not asked again"


def _flush_later(flush):  # type: ignore[no-untyped-def]
    """Return a `_flush` that skips the header, so that the disk fills up only later."""

    def wrapped(self, micros):  # type: ignore[no-untyped-def]
        if micros:
            flush(self, micros)

    return wrapped


def test_a_guarded_sink_still_raises_programming_errors(tmp_path: Path) -> None:
    sink = GuardedSink(WpilogSink(tmp_path / "x.wpilog"), sys.exit)
    sink.write(Snapshot(time=0.02, tick=0, doubles={"a": 1.0}))
    with pytest.raises(ConfigError, match="one key has one type"):
        sink.write(Snapshot(time=0.04, tick=1, booleans={"a": True}))
    sink.close()
    sink.close()
