"""Reading of logs of simcore, WPILib and AdvantageKit: whole, cut off and damaged."""

import struct
from pathlib import Path

import numpy as np
import pytest
from wpiutil.log import DataLogReader

from simcore.errors import LogError, UnknownNameError
from simcore.telemetry.snapshot import Snapshot
from simcore.telemetry.wpilog import WpilogSink, read_log


@pytest.fixture
def path(tmp_path: Path, snapshots: list[Snapshot]) -> Path:
    sink = WpilogSink(tmp_path / "run.wpilog", bulk_period=0.02)
    for snapshot in snapshots:
        sink.write(snapshot)
    sink.close()
    return sink.path


def start(entry: int, name: str, kind: str, micros: int = 0) -> bytes:
    texts = b"".join(struct.pack("<I", len(t)) + t.encode() for t in (name, kind, ""))
    return record(0, b"\0" + struct.pack("<I", entry) + texts, micros)


def record(entry: int, payload: bytes, micros: int) -> bytes:
    """Return a record as short as WPILib's writer makes it: one byte each, and three for the time."""
    return bytes([0b0_010_00_00, entry, len(payload)]) + micros.to_bytes(3, "little") + payload


HEADER = b"WPILOG" + struct.pack("<HI", 0x0100, 3) + b"abc"


def test_every_value_is_read_back_at_its_time(path: Path, snapshots: list[Snapshot]) -> None:
    log = read_log(path)
    assert not log.ends_early
    assert log.span == pytest.approx((snapshots[0].time, snapshots[-1].time))
    for want in snapshots:
        got = log.snapshot_at(want.time)
        np.testing.assert_array_equal(got.poses["Sim/Robot/Pose3d"], want.poses["Sim/Robot/Pose3d"])
        for key, rows in want.pose_arrays.items():
            np.testing.assert_array_equal(got.pose_arrays[key], rows)
        assert got.doubles == want.doubles
        assert got.integers == want.integers
        assert got.booleans == want.booleans
        assert got.strings == want.strings
        assert {k: v.tolist() for k, v in got.integer_arrays.items()} == {
            k: v.tolist() for k, v in want.integer_arrays.items()
        }
    half_way = log.snapshot_at(snapshots[3].time + 0.01)
    assert half_way.doubles == snapshots[3].doubles, "a value stands until the next"
    assert log.snapshot_at(0.0).poses == {}


def test_the_columns_are_those_that_wpilib_reads(path: Path) -> None:
    names, mine, theirs = {}, read_log(path), {}
    for entry in DataLogReader(str(path)):
        if entry.isStart():
            data = entry.getStartData()
            names[data.entry] = data.name
        elif not entry.isControl():
            theirs.setdefault(names[entry.getEntry()], []).append((entry.getTimestamp(), bytes(entry.getRaw())))
    assert {f"NT:/{k}" if not k.startswith(".schema") else k for k in mine.columns} | {"NT:/.schema"} >= {
        name for name in theirs if name.startswith("NT:/Sim")
    }
    for name, values in theirs.items():
        column = mine.columns[name.removeprefix("NT:/")]
        assert [round(1e6 * t) for t in column.times] == [t for t, _ in values]
        assert [column.payload(i) for i in range(len(column))] == [raw for _, raw in values]


def test_numbers_and_poses_are_read_as_arrays(path: Path, snapshots: list[Snapshot]) -> None:
    log = read_log(path)
    times, values = log.series("Sim/Robot/GroundClearance")
    assert values.tolist() == pytest.approx([s.doubles["Sim/Robot/GroundClearance"] for s in snapshots])
    assert times.tolist() == pytest.approx([s.time for s in snapshots])
    assert log.column("Sim/Robot/Pose3d").value(0).shape == (7,)
    assert log.column("Sim/GamePieces/Fuel").value(2).shape == (504, 7)
    with pytest.raises(LogError, match="'struct:Pose3d'"):
        log.series("Sim/Robot/Pose3d")
    with pytest.raises(LogError, match="'structschema', not one of"):
        log.column(".schema/struct:Pose3d").value(0)
    with pytest.raises(UnknownNameError, match="Did you mean 'Sim/Score/Total'"):
        log.series("Sim/Score/Totl")


def test_a_log_cut_off_anywhere_is_read_up_to_the_cut(path: Path, tmp_path: Path) -> None:
    whole = path.read_bytes()
    full = {key: len(column) for key, column in read_log(path).columns.items()}
    cut = tmp_path / "cut.wpilog"
    seen_early = 0
    for size in [*range(12, 900, 7), *range(900, len(whole), 20_011), len(whole) - 1]:
        cut.write_bytes(whole[:size])
        try:
            log = read_log(cut)
        except LogError as error:
            assert "holds no record" in str(error) and size < 200
            continue
        seen_early += log.ends_early
        assert all(len(column) <= full[key] for key, column in log.columns.items())
        log.snapshot_at(log.span[1])
    assert seen_early > 50


def test_a_log_with_garbage_in_its_middle_is_read_up_to_the_garbage(
    path: Path, tmp_path: Path, snapshots: list[Snapshot]
) -> None:
    whole = path.read_bytes()
    broken = tmp_path / "broken.wpilog"
    broken.write_bytes(whole[: len(whole) // 2] + b"\xff" * 2000)
    log = read_log(broken)
    assert log.ends_early
    assert 0 < len(log.column("Sim/Robot/Pose3d")) < len(snapshots)


def test_logs_with_short_records_foreign_types_and_unordered_times_are_read(tmp_path: Path) -> None:
    """AdvantageKit logs and merged logs have other names, short fields, late records and two entries per key."""
    number = struct.Struct("<d").pack
    path = tmp_path / "foreign.wpilog"
    path.write_bytes(
        HEADER
        + start(1, "/RealOutputs/Sim/Score", "double")
        + start(2, "/SystemStats/Name", "string")
        + start(3, "NT:/AdvantageKit/RealOutputs/Other", "float")
        + record(1, number(1.0), 100_000)
        + record(1, number(3.0), 300_000)
        + record(2, b"robot", 150_000)
        + record(1, number(2.0), 200_000)
        + record(3, struct.pack("<f", 0.5), 250_000)
        + record(0, b"\1" + struct.pack("<I", 1), 310_000)
        + record(1, number(9.0), 320_000)
        + start(4, "/RealOutputs/Sim/Score", "double", 330_000)
        + record(4, number(4.0), 400_000)
        + record(9, b"never started", 400_000)
    )
    log = read_log(path)
    assert not log.ends_early
    assert sorted(log.columns) == ["Other", "Sim/Score", "SystemStats/Name"]
    times, values = log.series("Sim/Score")
    assert times.tolist() == pytest.approx([0.1, 0.2, 0.3, 0.4])
    assert values.tolist() == [1.0, 2.0, 3.0, 4.0]
    assert log.series("Other")[1].tolist() == [0.5]
    assert log.column("SystemStats/Name").value(0) == "robot"
    assert log.snapshot_at(0.25).doubles == {"Sim/Score": 2.0, "Other": 0.5}


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "is empty"),
        (b"glTF and more than twelve bytes", "not a .wpilog file"),
        (b"WPILOG", "not a .wpilog file"),
        (b"WPILOG" + struct.pack("<HI", 0x0200, 0), "has format 2.0"),
        (HEADER, "holds no record"),
    ],
)
def test_a_file_that_is_not_a_log_is_refused_in_one_sentence(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "x.wpilog"
    path.write_bytes(content)
    with pytest.raises(LogError, match=words) as caught:
        read_log(path)
    assert "x.wpilog" in str(caught.value) and "\n" not in str(caught.value)


def test_a_missing_log_and_a_folder_are_refused(tmp_path: Path) -> None:
    for path in (tmp_path / "none.wpilog", tmp_path):
        with pytest.raises(LogError, match="cannot read the log"):
            read_log(path)
