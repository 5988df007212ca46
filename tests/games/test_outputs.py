"""Output files of a run: they exist, and no failure to write them stops the run."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from page_reader import PageReader

from games.rebuilt import REBUILT
from simcore import cli
from simcore.match.runner import play_auto
from simcore.show.failed_run import save_failed_run
from simcore.show.scene import scene_of
from simcore.show.shots import shots_of
from simcore.telemetry.recording import Recording


def main(words: list[str]) -> int:
    return cli.main(["play", "rebuilt", *words], program="python -m games.rebuilt")


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def outputs(capsys, *arguments: str) -> tuple[dict[str, str], str]:
    assert main(["--seconds", "0.3", "--json", *arguments]) == 0
    said = capsys.readouterr()
    return json.loads(said.out)["outputs"], said.err


@pytest.fixture(scope="module")
def depot():
    """Return a closed auto with its recording, and the positions of fuel at some times."""
    recording, truth = Recording(), {}

    def note(match):
        if match.ticks in (15, 211, 405):
            truth[round(match.time, 2)] = match.piece_positions()["Fuel"].copy()

    run = play_auto(REBUILT, "depot", seconds=9.0, sinks=[recording], on_tick=note)
    run.match.close()
    return run, recording, truth


def test_a_run_writes_log_and_page_by_default(here, capsys):
    written, said = outputs(capsys)
    assert written == {kind: str(Path("out") / f"depot.{suffix}") for kind, suffix in
                       (("log", "wpilog"), ("page", "html"))}  # fmt: skip
    assert said == ""


def test_the_recording_ends_with_the_state_at_the_end_of_the_run(depot):
    run, recording, _ = depot
    _, rows = recording.poses("Sim/Robot/Pose3d")
    assert rows[:, :2] == pytest.approx(run.path[:, :2])
    assert recording.series("Sim/Score/Blue")[1][-1] == run.report.score.blue
    shots = shots_of(recording, scene_of(run.match))
    assert (len(shots), len([shot for shot in shots if shot.scored])) == (run.report.shots, run.report.hits)
    battery, drive = (recording.series(f"Sim/Debug/{key}Current")[1] for key in ("Battery", "Drivetrain"))
    assert battery.max() > 50.0 and (battery - drive).max() > 20.0, "mechanisms draw something too"


def test_a_failed_test_leaves_a_page_even_of_a_closed_match(depot, tmp_path):
    run, recording, truth = depot
    left = save_failed_run(recording, tmp_path, name="test_x", scene=scene_of(run.match), note="assert 8 >= 20")
    assert left.problems == ()
    assert left.page is not None and left.page.stat().st_size < 1_000_000
    page, held = PageReader(left.page), 3.0
    for time, fuel in truth.items():
        rows = page.pieces(time)
        lying = rows[(rows[:, 3] > 0.0) & (rows[:, 3] < held)]
        assert len(lying) == len(fuel) > 400
        assert np.sort(lying[:, :3], axis=0) == pytest.approx(np.sort(fuel, axis=0), abs=0.02), (
            "to the centimeter, and what rolls between two frames"
        )


@pytest.mark.parametrize("what", ["out as a file", "a folder in the way of the page"])
def test_unwritable_default_files_are_reported_once_and_the_run_continues(here, capsys, what):
    if what == "out as a file":
        Path("out").write_text("keep me")
        written, said = outputs(capsys)
        assert written == {}
        assert said.count("\n") == 1
        assert said.startswith("simcore: cannot write to 'out' (")
        assert said.endswith("the run goes on without log and page\n")
        assert Path("out").read_text() == "keep me"
    else:
        Path("out/depot.html").mkdir(parents=True)
        written, said = outputs(capsys)
        assert set(written) == {"log"} and said.endswith("goes on without page\n") and said.count("\n") == 1


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full, the disk that is always full, on this system")
def test_a_full_disk_at_the_end_prevents_only_the_page(here, capsys):
    Path("full.html").symlink_to("/dev/full")
    written, said = outputs(capsys, "--page", "full.html")
    assert set(written) == {"log"}
    assert said.count("\n") == 1 and "cannot write the page 'full.html': No space left on device" in said


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full, the disk that is always full, on this system")
def test_a_disk_that_fills_up_ends_the_log_but_not_the_run(here, capsys, monkeypatch):
    flush = "simcore.telemetry.wpilog.WpilogSink._flush"
    original = __import__("simcore.telemetry.wpilog", fromlist=["x"]).WpilogSink._flush
    monkeypatch.setattr(flush, lambda self, micros: original(self, micros) if micros else None)
    Path("full.wpilog").symlink_to("/dev/full")
    assert main(["--seconds", "2", "--json", "--log", "full.wpilog"]) == 0
    said = capsys.readouterr()
    report = json.loads(said.out)
    assert report["ticks"] == 100 and set(report["outputs"]) == {"page"}
    assert said.err.count("\n") == 1 and said.err.endswith("The run goes on\n") and "No space left" in said.err


def test_two_outputs_cannot_share_a_file(here, capsys):
    assert main(["--page", "x.html", "--log", "x.html"]) == 1
    assert "log and page cannot be one file, got 'x.html' for both" in capsys.readouterr().err
