from dataclasses import replace

import numpy as np
import pytest
from made_up_run import places, pose, recorded, snapshot

from simcore.errors import ConfigError, UnknownNameError
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot


def centers(recording: Recording, time: float) -> np.ndarray:
    return recording.array_at("Sim/GamePieces/Fuel", time)[:, :3]


def test_recorded_columns_are_the_published_values() -> None:
    recording = recorded(50)
    times, volts = recording.series("Sim/Debug/BatteryVoltage")
    assert times == pytest.approx(0.02 * np.arange(1, 51))
    assert volts == pytest.approx(12.0 - times)
    at, rows = recording.poses("Sim/Robot/Pose3d")
    assert np.array_equal(rows, [pose(time) for time in at])
    assert recording.path("Sim/Robot/Pose3d")[:, 2] == pytest.approx(0.8 * at)
    assert recording.path("Sim/Robots/1/Robot/Pose3d").shape == (0, 3)
    assert recording.series("Sim/Robot/IsAirborne")[1].tolist() == [0.0] * 21 + [1.0] * 29


def test_pieces_are_kept_every_second_tick_and_the_newest_rows_are_found() -> None:
    recording = recorded(50)
    shown = [(snapshot.time, snapshot.pose_arrays["Sim/GamePieces/Fuel"]) for snapshot in recording.snapshots()]
    kept = [time for row, (time, rows) in enumerate(shown) if not row or rows is not shown[row - 1][1]]
    assert kept[:4] == pytest.approx([0.02, 0.04, 0.08, 0.12])
    some = [snapshot.pose_arrays["Sim/GamePieces/Fuel"] for snapshot in recording.snapshots([2, 9, 49])]
    assert np.array_equal(some, [shown[row][1] for row in (2, 9, 49)])
    assert centers(recording, 0.15) == pytest.approx(places(0.12), abs=1e-6)
    assert centers(recording, 0.12) == pytest.approx(places(0.12), abs=1e-6), "up to and including its own time"
    assert centers(recording, 0.0) == pytest.approx(places(0.02), abs=1e-6), "before the first there is only the first"
    assert recording.array_at("Sim/GamePieces/Fuel", 0.5).shape == (100, 7)


def test_recorded_snapshots_are_read_back() -> None:
    recording = recorded(7)
    for tick, back in enumerate(recording.snapshots()):
        sent = snapshot(tick)
        assert (back.time, back.tick) == (sent.time, sent.tick)
        assert (back.doubles, back.integers, back.booleans) == (sent.doubles, sent.integers, sent.booleans)
        assert type(back.integers["Sim/Score/Red"]) is int and type(back.booleans["Sim/Robot/IsAirborne"]) is bool
        assert np.array_equal(back.poses["Sim/Robot/Pose3d"], sent.poses["Sim/Robot/Pose3d"])
        assert back.strings == sent.strings
        assert back.integer_arrays["few"].tolist() == sent.integer_arrays["few"].tolist()
        due = snapshot((0, 1, 1, 3, 3, 5, 5)[tick])
        for field, key in (("pose_arrays", "Sim/GamePieces/Fuel"), ("integer_arrays", "Sim/PieceIds/Fuel")):
            newest, kept = getattr(back, field)[key], getattr(due, field)[key]
            assert newest == pytest.approx(kept, abs=1e-6), "the newest that was due, and ids with their poses"
    assert tick == 6


def test_texts_and_integer_arrays_are_read_back() -> None:
    recording = recorded(20)
    times, texts = recording.strings("Sim/Match/Period")
    assert texts == ["auto"] * 4 + ["teleop"] * 16 and times == pytest.approx(recording.times)
    assert recording.integers_at("Sim/PieceIds/Fuel", 0.3).tolist() == [*range(1000, 1100)]
    assert [recording.integers_at("few", 0.02 * k).tolist() for k in range(5)] == [[], [], [0], [0, 1], []]
    assert recording.integers_at("few", 9.0).dtype == np.int64
    assert {"few", "Sim/Match/Period"} <= set(recording.keys)


def test_keys_that_are_missing_at_times_leave_gaps() -> None:
    recording = Recording()
    for tick, keys in enumerate((("a",), ("a", "b"), ("b",), ("a", "b"))):
        time = 0.02 * (tick + 1)
        recording.write(
            Snapshot(
                time=time,
                tick=tick,
                doubles=dict.fromkeys(keys, float(tick)),
                poses={key: np.full(7, float(tick)) for key in keys},
            )
        )
    assert recording.series("a")[1].tolist() == [0.0, 1.0, 3.0]
    assert recording.series("b")[0] == pytest.approx([0.04, 0.06, 0.08])
    assert recording.poses("a")[1][:, 0].tolist() == [0.0, 1.0, 3.0]
    assert [sorted(s.doubles) for s in recording.snapshots()] == [["a"], ["a", "b"], ["b"], ["a", "b"]]
    assert [sorted(s.poses) for s in recording.snapshots()] == [["a"], ["a", "b"], ["b"], ["a", "b"]]


def test_poses_of_long_arrays_keep_their_rotation() -> None:
    recording, turned = Recording(), np.tile([1.0, 2.0, 3.0, 0.6, 0.0, 0.0, 0.8], (70, 1))
    recording.write(Snapshot(time=0.02, tick=0, pose_arrays={"many": turned, "few": turned[:3]}))
    assert recording.array_at("many", 1.0) == pytest.approx(turned, abs=1e-6)
    assert np.array_equal(recording.array_at("few", 1.0), turned[:3])


def test_a_snapshot_with_an_earlier_time_starts_a_new_run() -> None:
    recording = recorded(50)
    recording.write(replace(snapshot(0), doubles={"new": 1.0}))
    assert len(recording) == 1
    assert not recording.has("Sim/Debug/BatteryVoltage")
    assert centers(recording, 9.9) == pytest.approx(places(0.02), abs=1e-6)


def test_a_second_snapshot_of_one_time_replaces_the_first() -> None:
    """At the end of a match, shortfalls are published again with the last tick."""
    recording, last = recorded(3), snapshot(2)
    recording.write(replace(last, doubles={**last.doubles, "new": 1.0}, strings={"Sim/Warnings": "nothing held"}))
    assert recording.times == pytest.approx([0.02, 0.04, 0.06])
    assert recording.series("new")[0] == pytest.approx([0.06])
    assert recording.strings("Sim/Warnings")[1] == ["nothing held"]
    *_, end = recording.snapshots()
    assert end.pose_arrays["Sim/GamePieces/Fuel"].shape == (100, 7), "long arrays, too"
    assert len(recording.series("Sim/Debug/BatteryVoltage")[1]) == len(recording.poses("Sim/Robot/Pose3d")[1]) == 3
    assert len(list(recording.snapshots())) == 3


def test_the_recording_of_an_endless_run_keeps_its_end_and_stays_small() -> None:
    recording = recorded(1000, seconds=2.0)
    times = recording.times
    assert times[-1] == pytest.approx(20.0)
    assert 2.0 <= times[-1] - times[0] <= 2.5 + 0.02
    assert centers(recording, times[0]) == pytest.approx(places(times[0]), abs=0.04), "0.04 s old at most"
    _, rows = recording.poses("Sim/Robot/Pose3d")
    assert len(recording.strings("Sim/Match/Period")[1]) == len(times)
    assert recording.integers_at("few", 20.0).tolist() == [*range(999 % 3)]
    assert len(rows) == len(recording.series("Sim/Score/Blue")[1]) == len(times) == len(recording)


def test_the_recording_keeps_all_events_and_restarts_when_their_numbers_restart() -> None:
    """Event k occurs at tick k; each tick shows the newest ten, and the recording keeps every fifth tick for 2 s."""
    recording = Recording(period=0.1, seconds=2.0)

    def play(first: int, last: int, so_far: int) -> None:
        for tick in range(first, last):
            numbers = np.arange(max(1, so_far + tick - first - 8), so_far + tick - first + 2)
            rows = np.column_stack((numbers, 10 * numbers, -numbers)).ravel()
            if recording.due(0.02 * tick):
                recording.write(
                    Snapshot(time=0.02 * tick, tick=tick, integer_arrays={"Sim/NewestTakenIn": rows, "few": rows})
                )

    play(0, 501, 0)
    assert len(recording) < 30 and len(recording.events("Sim/NewestTakenIn")) == 501
    assert [row for _, row in recording.events("Sim/NewestTakenIn")] == [[k, 10 * k, -k] for k in range(1, 502)]
    times = np.array([time for time, _ in recording.events("Sim/NewestTakenIn")])
    assert times[0] == recording.times[0] > 0.0, "what is older is known from the first row on"
    late = times > times[0]
    assert times[late] == pytest.approx(0.1 * np.ceil(np.arange(501)[late] / 5.0)), "the first tick that shows it"
    again = Recording(seconds=60.0)
    for row in recording.snapshots():
        again.write(row)
    assert again.events("Sim/NewestTakenIn") == recording.events("Sim/NewestTakenIn"), "a log of it has them, too"
    play(501, 504, 0)
    play(504, 507, 3)  # the field was reset
    assert [row[0] for _, row in recording.events("Sim/NewestTakenIn")] == [*range(1, 6)]


def test_unknown_names_and_invalid_settings_are_refused() -> None:
    recording = recorded(3)
    with pytest.raises(UnknownNameError, match="Did you mean 'Sim/Score/Blue'"):
        recording.series("Sim/Score/Blu")
    with pytest.raises(UnknownNameError):
        recording.poses("Sim/Robot/Pose")
    with pytest.raises(UnknownNameError):
        recording.array_at("Sim/GamePieces/Coral", 0.0)
    with pytest.raises(UnknownNameError):
        recording.integers_at("ids", 0.0)
    with pytest.raises(UnknownNameError):
        recording.strings("Sim/Match/Perio")
    for option in ("period", "bulk_period", "seconds"):
        with pytest.raises(ConfigError, match="above 0"):
            Recording(**{option: 0.0})
