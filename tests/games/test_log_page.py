"""A run of which only the log is left looks the same."""

from __future__ import annotations

import struct

import pytest

from games.rebuilt import REBUILT
from simcore.cli import main
from simcore.errors import LogError
from simcore.match.runner import play_auto
from simcore.show.log_page import recording_of, scene_of_log
from simcore.show.scene import scene_of
from simcore.telemetry.log_reader import read_log
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot
from simcore.telemetry.wpilog import WpilogSink


@pytest.fixture(scope="module")
def depot(tmp_path_factory):
    log = tmp_path_factory.mktemp("log") / "depot.wpilog"
    recording = Recording()
    run = play_auto(REBUILT, "depot", alliance="red", seconds=10.0, sinks=[recording, WpilogSink(log)])
    run.match.close()
    return scene_of(run.match), recording, log


def test_numbers_poses_and_pieces_come_back(depot):
    _, live, log = depot
    back = recording_of(read_log(log))
    assert back.times == pytest.approx(live.times)
    for key in ("Sim/Debug/BatteryVoltage", "Sim/Score/Red", "Sim/Performance/AwakePieces"):
        assert back.series(key)[1] == pytest.approx(live.series(key)[1]), key
    assert back.poses("Sim/Robot/Pose3d")[1] == pytest.approx(live.poses("Sim/Robot/Pose3d")[1])
    for time in (0.48, 4.8, 9.12):  # logs keep long arrays every 0.08 s, recordings every 0.04
        assert back.pieces_at(time)["Fuel"] == pytest.approx(live.pieces_at(time)["Fuel"], abs=1e-5)


def test_shots_are_put_together_again(depot):
    scene, _, log = depot
    again = scene_of_log(recording_of(read_log(log)))
    assert (len(again.shots), again.hits) == (len(scene.shots), scene.hits)
    assert again.hits > 25
    for one, other in zip(again.shots, scene.shots, strict=True):
        assert one.time == pytest.approx(other.time)
        n = len(one.points)
        assert n > 10 and one.points == pytest.approx(other.points[:n], abs=1e-9), "until its first touch"
    assert [robot.alliance for robot in again.robots] == ["red"]
    assert again.field_size == scene.field_size and len(again.field_outlines) == len(scene.field_outlines)


def test_the_command_writes_page_picture_and_animation_beside_the_log(depot, tmp_path, capsys):
    log = tmp_path / "run.wpilog"
    log.write_bytes(depot[2].read_bytes()[:300_000])  # its program was killed
    assert main(["page", str(log), "--animation", str(tmp_path / "run.gif")]) == 0
    assert {path.suffix for path in tmp_path.iterdir()} == {".wpilog", ".html", ".png", ".gif"}
    said = capsys.readouterr().out
    assert said.count("\n") == 4 and said.startswith("game       rebuilt\n")


def test_logs_that_show_no_run(tmp_path, capsys):
    assert main(["page", str(tmp_path / "none.wpilog")]) == 1
    assert "cannot read the log" in capsys.readouterr().err
    with WpilogSink(tmp_path / "other.wpilog") as sink:
        sink.write(Snapshot(time=0.1, tick=0, doubles={"Shooter/Speed": 1.0}))
    with pytest.raises(LogError, match="no run of a simulation"):
        recording_of(read_log(tmp_path / "other.wpilog"))


def test_a_stamp_a_day_later_is_left_out(depot, tmp_path, capsys):
    """A flipped byte must not make a run of a day: what was logged together is the run."""
    later = tmp_path / "later.wpilog"
    records = [struct.pack("<BBBQd", 0b0111_0000, entry, 8, 86_400_000_000, 1.0) for entry in range(1, 60)]
    later.write_bytes(depot[2].read_bytes() + b"".join(records))
    assert recording_of(read_log(later)).times[-1] < 60.0
    assert "nothing was logged for over 60 s" in capsys.readouterr().err


def test_a_full_disk_or_a_wrong_name_is_one_sentence(depot, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert main(["page", str(depot[2]), "--page", str(tmp_path / "file" / "x.html")]) == 1
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "cannot write the page" in said
