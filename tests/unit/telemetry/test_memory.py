from __future__ import annotations

import pytest

from simcore.errors import ConfigError, UnknownNameError
from simcore.telemetry.snapshot import Snapshot, TelemetrySink
from simcore.testing.doubles import ManualClock, MemorySink


def test_keeps_all_in_order(snapshots: list[Snapshot]) -> None:
    sink = MemorySink()
    as_protocol: TelemetrySink = sink
    for snapshot in snapshots:
        assert as_protocol.due(snapshot.time)
        as_protocol.write(snapshot)
    assert list(sink.snapshots) == snapshots


def test_period_and_capacity(snapshots: list[Snapshot]) -> None:
    sink = MemorySink(period=0.04, capacity=3)
    for snapshot in snapshots:
        if sink.due(snapshot.time):
            sink.write(snapshot)
    assert [round(s.time, 6) for s in sink.snapshots] == [0.32, 0.36, 0.4]


def test_series_and_close(snapshots: list[Snapshot]) -> None:
    sink = MemorySink()
    for snapshot in snapshots[:2]:
        sink.write(snapshot)
    sink.close()
    sink.close()
    assert not sink.due(9.0)
    assert sink.series("Sim/Robot/GroundClearance") == ([0.02, 0.04], [0.0, 0.01])
    with pytest.raises(UnknownNameError, match="Did you mean 'Sim/Score/Total'"):
        sink.series("Sim/Score/Totl")


def test_bad_capacity() -> None:
    with pytest.raises(ConfigError, match="at least 1"):
        MemorySink(capacity=0)


def test_clock_does_not_run_backwards() -> None:
    clock = ManualClock(1.0)
    with pytest.raises(ConfigError, match="seconds"):
        clock.advance(-0.1)
    assert clock() == 1.0
