"""Page made from a log alone: equal to the page of the run."""

from __future__ import annotations

import struct
from dataclasses import replace

import numpy as np
import pytest
from page_reader import PageReader

from games.rebuilt import REBUILT
from simcore.cli import main
from simcore.errors import LogError
from simcore.match.runner import play_auto
from simcore.show.log_page import recording_of, scene_of_log
from simcore.show.page import write_page
from simcore.show.scene import scene_of
from simcore.show.shots import shots_of
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot
from simcore.telemetry.wpilog import WpilogSink, read_log


@pytest.fixture(scope="module")
def depot(tmp_path_factory):
    log = tmp_path_factory.mktemp("log") / "depot.wpilog"
    recording = Recording()
    run = play_auto(REBUILT, "depot", alliance="red", seconds=11.0, sinks=[recording, WpilogSink(log)])
    run.match.close()
    return scene_of(run.match), recording, log, run.match.record.shots


def test_the_reader_returns_the_numbers_poses_and_pieces_in_a_log(depot):
    _, live, log, _ = depot
    back = recording_of(read_log(log))
    assert back.times == pytest.approx(live.times)
    for key in ("Sim/Debug/BatteryVoltage", "Sim/Score/Red", "Sim/Performance/AwakePieces"):
        assert back.series(key)[1] == pytest.approx(live.series(key)[1]), key
    assert back.poses("Sim/Robot/Pose3d")[1] == pytest.approx(live.poses("Sim/Robot/Pose3d")[1])
    for time in (0.4, 4.8, 9.2):  # logs keep long arrays every 0.1 s, recordings every 0.04 s
        key = "Sim/GamePieces/Fuel"
        assert back.array_at(key, time) == pytest.approx(live.array_at(key, time), abs=1e-5)


def test_the_columns_of_a_log_agree_with_its_snapshots(depot):
    log = read_log(depot[2])
    back = recording_of(log)
    rows = [0, 1, 7, 200, len(back) - 1]
    for row, snapshot in zip(rows, back.snapshots(rows), strict=True):
        want = log.snapshot_at(snapshot.time + 1e-6)
        assert snapshot.tick == row
        for field in ("doubles", "integers", "booleans", "strings"):
            assert getattr(snapshot, field) == getattr(want, field), field
        for field, is_kept in (("poses", True), ("integer_arrays", False)):  # long arrays are kept less often
            for key, values in getattr(want, field).items():
                if is_kept or len(values) <= 64:
                    assert getattr(snapshot, field)[key].tolist() == values.tolist(), key


def test_the_reader_returns_the_shots_in_a_log_with_their_flights(depot):
    scene, live, log, truth = depot
    back = recording_of(read_log(log))
    again = scene_of_log(back)
    shots = shots_of(back, again)
    assert [shot.scored for shot in shots] == [record.scored for record in truth]
    assert sum(shot.scored for shot in shots) > 20
    for one, other, record in zip(shots, shots_of(live, scene), truth, strict=True):
        assert one.time == pytest.approx(record.time) and one.side == other.side
        n = len(one.points)
        assert n > 10 and one.points == pytest.approx(np.array(record.points)[:n], abs=1e-9), "until its first touch"
    assert [robot.alliance for robot in again.robots] == ["red"]
    assert again.field_size == scene.field_size and len(again.field_outlines) == len(scene.field_outlines)
    assert again.goals == scene.goals


def test_a_page_can_be_made_from_a_log_of_an_older_version(depot, tmp_path):
    """The log has no ids, no results of shots and no pose estimates."""
    _, live, *_ = depot
    old = Recording()
    for snapshot in list(live.snapshots())[:50]:
        poses = {key: row for key, row in snapshot.poses.items() if "Estimated" not in key}
        arrays = {key: rows for key, rows in snapshot.pose_arrays.items() if "Held" not in key}
        old.write(replace(snapshot, poses=poses, pose_arrays=arrays, integer_arrays={}, strings={}))
    write_page(tmp_path / "old.html", old, scene_of_log(old))
    page = PageReader(tmp_path / "old.html")
    assert (page.pieces(0.5)[:, 3] > 0).sum() > 400 and not page.meta["tables"]


def test_the_view_command_writes_the_page_next_to_the_log(depot, tmp_path, capsys):
    log = tmp_path / "run.wpilog"
    log.write_bytes(depot[2].read_bytes()[:300_000])  # as if the program had been killed
    assert main(["view", "--no-browser", str(log)]) == 0
    assert {path.suffix for path in tmp_path.iterdir()} == {".wpilog", ".html"}
    said = capsys.readouterr().out
    assert said.count("\n") == 2 and said.startswith("game       rebuilt\n")


def test_logs_without_a_run_are_refused(tmp_path, capsys):
    assert main(["view", "--no-browser", str(tmp_path / "none.wpilog")]) == 1
    assert "cannot read the log" in capsys.readouterr().err
    with WpilogSink(tmp_path / "other.wpilog") as sink:
        sink.write(Snapshot(time=0.1, tick=0, doubles={"Shooter/Speed": 1.0}))
    with pytest.raises(LogError, match="no simulated run"):
        recording_of(read_log(tmp_path / "other.wpilog"))


def test_a_time_stamp_a_day_later_is_ignored(depot, tmp_path, capsys):
    """A flipped byte must not stretch the run to a day: only entries close in time belong to the run."""
    later = tmp_path / "later.wpilog"
    records = [struct.pack("<BBBQd", 0b0111_0000, entry, 8, 86_400_000_000, 1.0) for entry in range(1, 60)]
    later.write_bytes(depot[2].read_bytes() + b"".join(records))
    assert recording_of(read_log(later)).times[-1] < 60.0
    assert "nothing was logged for over 60 s" in capsys.readouterr().err


def test_a_page_that_cannot_be_written_is_reported_in_one_message(depot, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert main(["view", "--no-browser", str(depot[2]), "--page", str(tmp_path / "file" / "x.html")]) == 1
    said = capsys.readouterr().err
    assert said.strip().count("\n") == 0 and "cannot write the page" in said
