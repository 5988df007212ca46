"""What the charts of the page show."""

from __future__ import annotations

import numpy as np
import pytest
from simcore.show.view_charts import LogSignals, RecentSignals, unit_of

from simcore.telemetry.log_reader import read_log
from simcore.telemetry.snapshot import Snapshot
from simcore.telemetry.wpilog import WpilogSink

VOLTS, HELD = "Sim/Debug/BatteryVoltage", "Sim/Debug/HeldCount"


def snapshots(seconds: float):
    """Every 20 ms; the voltage is the time, the count changes at 3 s."""
    for tick in range(round(50 * seconds)):
        time = 0.02 * (tick + 1)
        yield Snapshot(
            time=time, tick=tick, doubles={VOLTS: time}, integers={HELD: int(time > 3.0)}, booleans={"Sim/On": True}
        )


def test_a_run_shows_its_last_seconds_of_any_number_and_begins_anew_with_the_next() -> None:
    signals = RecentSignals()
    assert signals.names() == []
    for snapshot in snapshots(30.0):
        signals.note(snapshot)
    assert signals.names() == [VOLTS, HELD, "Sim/On"]
    times, values = signals.recent(VOLTS)
    assert times[0] == pytest.approx(10.0) and times[-1] == pytest.approx(30.0) and np.array_equal(times, values)
    assert signals.recent("Sim/On")[1].tolist() == [1.0] * len(times)
    signals.note(Snapshot(time=0.02, tick=0, doubles={VOLTS: 12.0}))
    assert signals.recent(VOLTS)[1].tolist() == [12.0] and len(signals.recent(HELD)[0]) == 0


def test_a_log_holds_each_value_until_the_next_and_shows_nothing_of_later(tmp_path) -> None:
    sink = WpilogSink(tmp_path / "run.wpilog")
    for snapshot in snapshots(30.0):
        sink.write(snapshot)
    sink.close()
    log = read_log(sink.path)
    signals = LogSignals(log)
    signals.time = log.span[0] + 4.0
    times, values = signals.recent(HELD)
    first, changed = (log.series(HELD)[0][:2] - log.span[0]).tolist()
    assert times.tolist() == pytest.approx([first, changed, changed, 4.0]) and values.tolist() == [0.0, 0.0, 1.0, 1.0]
    signals.time = log.span[0] + 28.0
    assert signals.recent(HELD)[0].tolist() == pytest.approx([8.0, 28.0])
    assert signals.recent(VOLTS)[1].max() == pytest.approx(28.02, abs=0.03)


def test_units_are_told_by_the_name() -> None:
    assert [unit_of(f"Sim/Debug/{name}") for name in (
        "BatteryVoltage", "DrivetrainCurrent", "ShooterVelocityRPS", "HoodAngleDeg", "IntakeExtendedPct", "HeldCount",
    )] == ["V", "A", "turns/s", "\u00b0", "%", ""]  # fmt: skip
    assert unit_of("Sim/Match/TimeLeft") == "s" and unit_of("Sim/Robot/GroundClearance") == "m"
