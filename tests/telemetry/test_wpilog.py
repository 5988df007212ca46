import lzma
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from simcore.errors import ConfigError, OutputError
from simcore.telemetry.snapshot import Snapshot
from simcore.telemetry.wpilog import WpilogSink, read_log

log = pytest.importorskip("wpiutil.log", reason="WPILib's own reader checks what we write")


def read(path: Path) -> tuple[dict[str, str], dict[str, list[tuple[int, bytes]]]]:
    """Return types and (microseconds, payload) pairs by name, from WPILib's reader."""
    reader = log.DataLogReader(str(path))
    assert reader.isValid()
    assert reader.getVersion() == 0x0100
    names: dict[int, str] = {}
    types: dict[str, str] = {}
    values: dict[str, list[tuple[int, bytes]]] = {}
    for record in reader:
        if record.isStart():
            start = record.getStartData()
            names[start.entry], types[start.name] = start.name, start.type
            values[start.name] = []
        else:
            assert not record.isControl()
            values[names[record.getEntry()]].append((record.getTimestamp(), bytes(record.getRaw())))
    return types, values


EVERY_TICK = {"bulk_period": 0.02}


def written(path: Path, snapshots: list[Snapshot], **options: Any) -> Path:
    options = EVERY_TICK | options
    with WpilogSink(path, **options) as sink:
        for snapshot in snapshots:
            if sink.due(snapshot.time):
                sink.write(snapshot)
    return path


def test_types_and_names_equal_those_of_a_networktables_log(tmp_path: Path, snapshots: list[Snapshot]) -> None:
    types, _ = read(written(tmp_path / "run.wpilog", snapshots))
    assert types == {
        "NT:/.schema/struct:Translation3d": "structschema",
        "NT:/.schema/struct:Quaternion": "structschema",
        "NT:/.schema/struct:Rotation3d": "structschema",
        "NT:/.schema/struct:Pose3d": "structschema",
        "NT:/.schema/struct:Rotation2d": "structschema",
        "NT:/.schema/struct:SwerveModuleState": "structschema",
        "NT:/Sim/Robot/Pose3d": "struct:Pose3d",
        "NT:/Sim/GamePieces/Fuel": "struct:Pose3d[]",
        "NT:/Sim/Robot/ComponentPoses": "struct:Pose3d[]",
        "NT:/Sim/Robot/GroundClearance": "double",
        "NT:/Sim/Debug/HoodAngleDeg": "double",
        "NT:/Sim/Score/Total": "int64",
        "NT:/Sim/Robot/IsAirborne": "boolean",
        "NT:/Sim/PieceIds/Fuel": "int64[]",
        "NT:/Sim/PieceIds/Held": "int64[]",
        "NT:/Sim/Match/Period": "string",
    }


def test_schemas_equal_those_of_wpimath(tmp_path: Path) -> None:
    geometry = pytest.importorskip("wpimath.geometry")
    from wpimath.kinematics import SwerveModuleState
    from wpiutil import wpistruct

    _, values = read(written(tmp_path / "empty.wpilog", []))
    expected: dict[str, bytes] = {}
    for struct in (geometry.Pose3d, SwerveModuleState):
        wpistruct.forEachNested(
            struct,
            lambda name, schema: expected.__setitem__(name, schema if isinstance(schema, bytes) else schema.encode()),
        )
    assert {name.removeprefix("NT:/.schema/"): rows[0][1] for name, rows in values.items()} == expected


def test_numbers_are_written_only_when_they_change(tmp_path: Path, snapshots: list[Snapshot]) -> None:
    _, values = read(written(tmp_path / "run.wpilog", snapshots))
    assert len(values["NT:/Sim/Robot/GroundClearance"]) == 20
    assert values["NT:/Sim/Debug/HoodAngleDeg"] == [(20_000, np.float64(25.0).tobytes())]
    totals = [(stamp, int.from_bytes(payload, "little")) for stamp, payload in values["NT:/Sim/Score/Total"]]
    assert totals == [(20_000, 0), (120_000, 1), (220_000, 2), (320_000, 3)]
    airborne = values["NT:/Sim/Robot/IsAirborne"]
    assert airborne == [(20_000, b"\0"), (200_000, b"\1"), (220_000, b"\0"), (400_000, b"\1")]


def test_long_arrays_are_written_less_often_and_no_value_twice(tmp_path: Path) -> None:
    long, short = np.zeros((100, 7)), np.zeros((16, 7))
    rows = []
    for k in range(1, 13):
        long, short = long + 1.0, short + (k > 6)
        rows.append(Snapshot(time=0.02 * k, tick=k, pose_arrays={"fuel": long.copy(), "parts": short.copy()}))
    _, values = read(written(tmp_path / "run.wpilog", rows, bulk_period=0.06))
    assert [stamp for stamp, _ in values["NT:/fuel"]] == [20_000, 60_000, 120_000, 180_000, 240_000]
    assert values["NT:/fuel"][-1][1] == long.tobytes(), "also the last"
    assert [stamp for stamp, _ in values["NT:/parts"]] == [20_000, *range(140_000, 240_001, 20_000)]


def test_held_pieces_are_written_less_often_and_all_last_values_at_the_end(tmp_path: Path) -> None:
    rows = [
        Snapshot(
            time=0.02 * k,
            tick=k,
            pose_arrays={
                "Sim/Held/Fuel": np.full((3, 7), float(k)),
                "Sim/GamePieces/Fuel": np.full((100, 7), float(k)),
            },
            integer_arrays={"Sim/NewestShots": np.arange(4 * k), "Sim/HeldIds/Fuel": np.full(3, k)},
        )
        for k in range(1, 66)
    ]
    path = tmp_path / "run.wpilog"
    with WpilogSink(path) as sink:
        for row in rows:
            sink.write(row)
    _, values = read(path)
    assert len(values["NT:/Sim/NewestShots"]) == 65, "a shot has the time of its row"
    held = [stamp for stamp, _ in values["NT:/Sim/Held/Fuel"]]
    assert held == [20_000, *range(40_000, 1_300_000, 40_000), 1_300_000]
    assert held == [stamp for stamp, _ in values["NT:/Sim/HeldIds/Fuel"]]
    lying = [stamp for stamp, _ in values["NT:/Sim/GamePieces/Fuel"]]
    assert lying == [20_000, *range(100_000, 1_300_001, 100_000)]
    end = read_log(path).snapshot_at(1.3)
    assert end.pose_arrays["Sim/GamePieces/Fuel"][0, 0] == 65.0 and len(end.integer_arrays["Sim/NewestShots"]) == 260


def test_timestamps_longer_than_four_bytes_are_read_back(tmp_path: Path) -> None:
    """Four bytes of microseconds are 71.6 minutes."""
    times = (4294.96, 4294.98, 5000.0)
    rows = [Snapshot(time=time, tick=k, doubles={"x": time}) for k, time in enumerate(times)]
    path = written(tmp_path / "run.wpilog", rows)
    _, values = read(path)
    assert [stamp for stamp, _ in values["NT:/x"]] == [4_294_960_000, 4_294_980_000, 5_000_000_000]
    assert read_log(path).series("x")[0].tolist() == list(times)


def test_wpilib_decodes_every_kind_of_value(tmp_path: Path, snapshots: list[Snapshot]) -> None:
    """Values are poses, module states, texts and integer arrays; empty arrays are written once."""
    geometry = pytest.importorskip("wpimath.geometry")
    from wpimath.kinematics import SwerveModuleState
    from wpiutil import wpistruct

    states = np.array([(1.5, -0.25), (-2.0, 3.0)])
    arrays = {"Sim/Robot/SwerveStates": states, "Sim/Robot/SwerveSetpoints": states[:0]}
    snapshots[0] = replace(snapshots[0], state_arrays=arrays)
    path = written(tmp_path / "run.wpilog", snapshots)
    types, values = read(path)
    pose = wpistruct.unpack(geometry.Pose3d, values["NT:/Sim/Robot/Pose3d"][3][1])
    assert (pose.X(), pose.Y(), pose.Z()) == (4.0, 2.0, 0.0) and pose.rotation().Z() == pytest.approx(1.0)
    fuel = wpistruct.unpackArray(geometry.Pose3d, values["NT:/Sim/GamePieces/Fuel"][3][1])
    assert len(fuel) == 504 and (fuel[7].X(), fuel[7].Y()) == (7.003, -3.0)
    assert [payload for _, payload in values["NT:/Sim/Robot/ComponentPoses"]] == [b""]
    assert types["NT:/Sim/Robot/SwerveStates"] == "struct:SwerveModuleState[]"
    found = wpistruct.unpackArray(SwerveModuleState, values["NT:/Sim/Robot/SwerveStates"][0][1])
    assert [(one.speed, one.angle.radians()) for one in found] == [(1.5, -0.25), (-2.0, 3.0)]
    assert values["NT:/Sim/Robot/SwerveSetpoints"] == [(20_000, b"")]
    again = read_log(path).snapshot_at(0.02).state_arrays
    assert np.array_equal(again["Sim/Robot/SwerveStates"], states) and again["Sim/Robot/SwerveSetpoints"].shape == (
        0,
        2,
    )
    ids = [(stamp, np.frombuffer(raw, "<i8").tolist()) for stamp, raw in values["NT:/Sim/PieceIds/Fuel"]]
    assert ids == [(t, [*range(n, n + 504)]) for t, n in ((20_000, 0), (180_000, 1), (340_000, 2))], "when they change"
    periods = [(stamp, raw.decode()) for stamp, raw in values["NT:/Sim/Match/Period"]]
    assert periods == [(20_000, "auto"), (320_000, "Übergang")]


def test_a_constant_nan_is_written_once(tmp_path: Path) -> None:
    rows = [Snapshot(time=0.02 * k, tick=k, doubles={"x": float("nan")}, integers={"n": -(2**63)}) for k in range(3)]
    _, values = read(written(tmp_path / "run.wpilog", rows))
    assert len(values["NT:/x"]) == 1
    assert values["NT:/n"] == [(0, (-(2**63)).to_bytes(8, "little", signed=True))]


def test_a_key_that_changes_type_is_refused_even_if_the_value_is_equal(tmp_path: Path) -> None:
    rows = [Snapshot(time=0.0, tick=0, doubles={"x": 1.0}), Snapshot(time=0.02, tick=1, integers={"x": 1})]
    with pytest.raises(ConfigError, match="logged as double before, now as int64"):
        written(tmp_path / "run.wpilog", rows)


@pytest.mark.parametrize("shape", [(3, 7), (3,)])
def test_an_array_changed_in_place_is_logged_again(tmp_path: Path, shape: tuple[int, ...]) -> None:
    rows = np.zeros(shape) if len(shape) == 2 else np.zeros(shape, dtype=np.int64)
    kind = "pose_arrays" if len(shape) == 2 else "integer_arrays"
    with WpilogSink(tmp_path / "run.wpilog") as sink:
        for tick in range(4):
            rows[0] = tick // 2
            sink.write(Snapshot(time=0.02 * tick, tick=tick, **{kind: {"rows": rows}}))
    _, values = read(tmp_path / "run.wpilog")
    assert [stamp for stamp, _ in values["NT:/rows"]] == [0, 40_000]


def test_period_and_prefix_apply_to_every_key(tmp_path: Path, snapshots: list[Snapshot]) -> None:
    _, values = read(written(tmp_path / "run.wpilog", snapshots, period=0.1, prefix="/"))
    assert [stamp for stamp, _ in values["/Sim/Robot/Pose3d"]] == [20_000, 100_000, 200_000, 300_000, 400_000]


def test_two_logs_of_equal_runs_have_equal_bytes(tmp_path: Path, snapshots: list[Snapshot]) -> None:
    one, two = written(tmp_path / "1.wpilog", snapshots), written(tmp_path / "2.wpilog", snapshots)
    assert one.read_bytes() == two.read_bytes()


def test_a_killed_run_leaves_a_readable_log(tmp_path: Path) -> None:
    path = tmp_path / "killed.wpilog"
    script = """
import os, sys
import numpy as np
from simcore.telemetry.snapshot import Snapshot
from simcore.telemetry.wpilog import WpilogSink
sink = WpilogSink(sys.argv[1])
for tick in range(1, 175):
    sink.write(Snapshot(time=tick * 0.02, tick=tick, doubles={"x": float(tick)}))
os.kill(os.getpid(), 9) if hasattr(os, "fork") else os._exit(9)
"""
    result = subprocess.run([sys.executable, "-c", script, str(path)], cwd=Path.cwd(), timeout=60, check=False)
    assert result.returncode != 0
    _, values = read(path)
    # flushed every simulated second: 3 of 3.48 s
    assert [np.frombuffer(payload)[0] for _, payload in values["NT:/x"]] == [float(k) for k in range(1, 151)]


def test_missing_folders_are_made_and_an_existing_file_is_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "out" / "deep" / "run.wpilog"
    for _ in range(2):
        written(path, [Snapshot(time=0.0, tick=0, doubles={"x": 1.0})])
    _, values = read(path)
    assert len(values["NT:/x"]) == 1


def test_an_unwritable_log_raises_an_error_at_once(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for bad in (tmp_path, tmp_path / "file" / "run.wpilog"):
        with pytest.raises(OutputError, match="for example") as caught:
            WpilogSink(bad)
        assert repr(str(bad)) in str(caught.value)


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a device that is always full")
def test_a_full_disk_raises_an_output_error() -> None:
    with pytest.raises(OutputError, match="No space left"):
        WpilogSink("/dev/full")


def test_a_disk_that_fills_up_closes_the_log(tmp_path: Path, snapshots: list[Snapshot]) -> None:
    sink = WpilogSink(tmp_path / "run.wpilog", **EVERY_TICK)
    assert sink._file is not None
    os.close(sink._file.fileno())
    with pytest.raises(OutputError, match="ends here: "):
        for snapshot in snapshots:
            sink.write(snapshot)
    assert sink.closed
    sink.close()


def test_writing_to_a_closed_log_raises(tmp_path: Path, snapshots: list[Snapshot]) -> None:
    sink = WpilogSink(tmp_path / "run.wpilog")
    sink.close()
    sink.close()
    assert not sink.due(1.0)
    with pytest.raises(OutputError, match="is closed"):
        sink.write(snapshots[0])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"poses": {"p": np.zeros(6)}}, r"p: a pose needs shape \(7,\)"),
        ({"pose_arrays": {"p": np.zeros((3, 6))}}, r"p: struct:Pose3d\[\] needs shape \(n, 7\) as x, y, z"),
        ({"state_arrays": {"s": np.zeros((4, 3))}}, r"s: struct:SwerveModuleState\[\] needs shape \(n, 2\) as speed"),
        ({"integer_arrays": {"i": np.zeros((3, 2), dtype=np.int64)}}, r"i: integers need shape \(n,\)"),
        ({"integer_arrays": {"i": np.zeros(3)}}, "an integer type"),
        ({"doubles": {"x": 1.0}, "integers": {"x": 1}}, "x: logged as double before, now as int64"),
        ({"doubles": {"/x": 1.0}}, "without a leading '/'"),
        ({"time": -0.02}, "time >= 0"),
        ({"time": float("nan")}, "time >= 0"),
    ],
)
def test_invalid_snapshots_are_refused(tmp_path: Path, change: dict[str, Any], words: str) -> None:
    with WpilogSink(tmp_path / "run.wpilog") as sink, pytest.raises(ConfigError, match=words):
        sink.write(replace(Snapshot(time=0.0, tick=0), **change))


@pytest.mark.parametrize("period", [0.0, -0.02, float("nan"), float("inf")])
def test_an_invalid_period_is_refused(tmp_path: Path, period: float) -> None:
    with pytest.raises(ConfigError, match="period"):
        WpilogSink(tmp_path / "run.wpilog", period=period)


def test_a_compressed_log_returns_the_same_values_even_when_truncated(
    tmp_path: Path, snapshots: list[Snapshot]
) -> None:
    plain, packed, cut = (tmp_path / name for name in ("a.wpilog", "b.wpilogxz", "c.wpilogxz"))
    for path in (plain, packed):
        with WpilogSink(path, **EVERY_TICK) as sink:
            for snapshot in snapshots:
                sink.write(snapshot)
    assert lzma.decompress(packed.read_bytes()) == plain.read_bytes()
    assert read_log(packed).columns.keys() == read_log(plain).columns.keys()
    cut.write_bytes(packed.read_bytes()[:-12])
    assert read_log(cut).columns.keys() <= read_log(plain).columns.keys()
