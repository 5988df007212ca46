"""What a run leaves behind, and that nothing of it can stop the run."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy import ndimage

from games.rebuilt import REBUILT
from simcore import cli
from simcore.match.runner import play_auto
from simcore.show import raster
from simcore.show.animation import FramePainter
from simcore.show.failed_run import save_failed_run
from simcore.show.frames import filled
from simcore.show.palette import rgb
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
    """An auto of which everything was recorded, closed; and for each tenth of a second where the fuel was."""
    recording, truth = Recording(), {}

    def note(sim):
        if sim.ticks % 15 == 0:
            truth[round(sim.time, 2)] = sim.piece_positions()["Fuel"].copy()

    run = play_auto(REBUILT, "depot", seconds=9.0, sinks=[recording], on_tick=note)
    run.match.close()
    return run, recording, truth


def test_log_picture_and_page_by_default_an_animation_on_demand(here, capsys):
    written, said = outputs(capsys)
    assert written == {kind: str(Path("out") / f"depot.{suffix}") for kind, suffix in
                       (("log", "wpilog"), ("picture", "png"), ("page", "html"))}  # fmt: skip
    assert said == ""
    written, _ = outputs(capsys, "--animation", "--picture", "p/x.png")
    assert Path(written["animation"]) == Path("p/x.gif") and Path(written["page"]) == Path("p/x.html")
    written, _ = outputs(capsys, "--animation", "q/y.gif")
    with Image.open(written["animation"]) as gif:
        assert gif.n_frames >= 3


def test_frames_of_a_real_run_show_fuel_where_the_engine_had_it(depot):
    run, recording, truth = depot
    scene = scene_of(run.match)
    painter = FramePainter(recording, scene)
    below = 100.0 * scene.field_size[1]
    (left, top), (right, _) = np.array(painter.points(np.array([(0.0, below), (100.0, below)]))) / 2.0
    scale = right - left
    for time in (0.3, 4.2, 8.1):
        (moment,) = (one for one in filled(recording) if abs(one.time - time) < 0.001)
        image = np.asarray(painter.draw(moment), dtype=int)
        labels, count = ndimage.label(np.abs(image - rgb("#ffd923")).max(axis=2) < 12)
        middles = np.array(ndimage.center_of_mass(np.ones_like(labels), labels, range(1, count + 1)))
        seen = np.column_stack(((middles[:, 1] + 0.5 - left) / scale, (top - middles[:, 0] - 0.5) / scale))
        fuel = truth[time]
        distance = np.linalg.norm(seen[:, None, :] - fuel[None, :, :2], axis=2)
        pixel = 1.0 / scale
        x, y, _ = run.path[round(time / 0.02) - 1]
        outside = np.linalg.norm(seen - (x, y), axis=1) > 0.65  # in the robot are those that it holds
        assert (distance.min(axis=1) < pixel)[outside].mean() > 0.99, "what is drawn is there"
        is_free = (np.linalg.norm(fuel[:, :2] - (x, y), axis=1) > 0.65) & (fuel[:, 2] < 0.3)
        assert is_free.sum() > 400
        assert (distance[:, is_free].min(axis=0) < pixel).mean() > 0.99, "what is there is drawn"


def test_the_recording_ends_where_the_run_ended(depot):
    run, recording, _ = depot
    _, rows = recording.poses("Sim/Robot/Pose3d")
    assert rows[:, :2] == pytest.approx(run.path[:, :2])
    assert recording.series("Sim/Score/Blue")[1][-1] == run.report.score.blue
    shots = shots_of(recording, scene_of(run.match))
    assert (len(shots), len([shot for shot in shots if shot.scored])) == (run.report.shots, run.report.hits)
    battery, drive = (recording.series(f"Sim/Debug/{key}Current")[1] for key in ("Battery", "Drivetrain"))
    assert battery.max() > 50.0 and (battery - drive).max() > 20.0, "mechanisms draw something too"


def test_a_failed_test_leaves_evidence_of_a_closed_game(depot, tmp_path):
    run, recording, _ = depot
    left = save_failed_run(recording, tmp_path, name="test_x", scene=scene_of(run.match), note="assert 8 >= 20")
    assert left.problems == ()
    assert left.page is not None and left.page.stat().st_size < 1_000_000


@pytest.mark.parametrize("what", ["out as a file", "a folder in the way of the page"])
def test_usual_files_that_cannot_be_written_are_one_sentence_and_the_run_goes_on(here, capsys, what):
    if what == "out as a file":
        Path("out").write_text("keep me")
        written, said = outputs(capsys)
        assert written == {}
        assert said.count("\n") == 1
        assert said.startswith("simcore: cannot write to 'out' (")
        assert said.endswith("the run goes on without log, picture and page\n")
        assert Path("out").read_text() == "keep me"
    else:
        Path("out/depot.html").mkdir(parents=True)
        written, said = outputs(capsys)
        assert set(written) == {"log", "picture"} and said.endswith("goes on without page\n") and said.count("\n") == 1


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full, the disk that is always full, on this system")
def test_a_disk_that_is_full_at_the_end_costs_the_page_alone(here, capsys):
    Path("full.html").symlink_to("/dev/full")
    written, said = outputs(capsys, "--page", "full.html")
    assert set(written) == {"log", "picture"}
    assert said.count("\n") == 1 and "cannot write the page 'full.html': No space left on device" in said


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full, the disk that is always full, on this system")
def test_a_disk_that_fills_up_during_the_run_ends_the_log_and_not_the_run(here, capsys, monkeypatch):
    flush = "simcore.telemetry.wpilog.WpilogSink._flush"
    original = __import__("simcore.telemetry.wpilog", fromlist=["x"]).WpilogSink._flush
    monkeypatch.setattr(flush, lambda self, micros: original(self, micros) if micros else None)
    Path("full.wpilog").symlink_to("/dev/full")
    assert main(["--seconds", "2", "--json", "--log", "full.wpilog"]) == 0
    said = capsys.readouterr()
    report = json.loads(said.out)
    assert report["ticks"] == 100 and set(report["outputs"]) == {"picture", "page"}
    assert said.err.count("\n") == 1 and said.err.endswith("The run goes on\n") and "No space left" in said.err


def test_an_animation_or_a_picture_that_cannot_be_is_refused_before_the_run(here, capsys):
    assert main(["--animation", "x.avi", "--seconds", "1600"]) == 1
    assert "animations end in .gif" in capsys.readouterr().err
    assert main(["--picture", "x.jpg", "--seconds", "1600"]) == 1
    assert "cannot draw 'x.jpg': pictures end in .pdf, .png, .svg" in capsys.readouterr().err
    assert not [path for path in here.rglob("*") if path.is_file()]


def test_two_outputs_cannot_be_one_file(here, capsys):
    assert main(["--page", "x.png", "--picture", "x.png"]) == 1
    assert "picture and page cannot be one file" in capsys.readouterr().err


def test_without_the_drawing_libraries_a_run_still_is_a_run(here, capsys, monkeypatch):
    for name in ("PIL", "resvg_py"):
        monkeypatch.setitem(sys.modules, name, None)
    raster._font.cache_clear()
    written, said = outputs(capsys, "--animation")
    assert set(written) == {"log", "page"}
    assert "pip install resvg-py" in said and "pip install pillow" in said and said.count("\n") == 2
