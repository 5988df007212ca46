"""The page as a file: what it says of a run, by the reader of `page_reader.py`; a browser is in tests/view."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from made_up_run import HELD, PIECES, SCENE, places, pose, recorded
from page_reader import PageReader, yaw_of

from simcore.errors import OutputError
from simcore.show.page import page_html, write_page
from simcore.show.scene import PieceLook, Scene
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot


def page(tmp_path: Path, recording: Recording | None = None, scene: Scene = SCENE, **words: str) -> PageReader:
    path = tmp_path / "new" / "run.html"
    write_page(path, recorded() if recording is None else recording, scene, **words)
    return PageReader(path)


def test_nothing_is_loaded_from_anywhere(tmp_path: Path) -> None:
    text = re.sub(r'(<script type="text/plain" id="\w+">)[^<]*', r"\1", page(tmp_path).text)
    assert not re.search(r"https?:|//[a-z]|\bsrc=|@import|url\(|<iframe|<img", text, re.IGNORECASE)
    assert "default-src 'none'" in text and "connect-src 'none'" in text and "connect-src 'self'" in page_html("live")


def test_frames_say_where_each_piece_and_robot_was_and_what_the_robot_believed(tmp_path: Path) -> None:
    run = page(tmp_path)
    assert run.meta["end"] == 1.0 and [kind["count"] for kind in run.meta["kinds"]] == [PIECES + 1]
    for time in run.group("robots")[0]:
        at, (x, y, yaw) = run.robot(0, time)
        assert at == pytest.approx(pose(time), abs=6e-4) and yaw_of(at) == pytest.approx(0.8 * time, abs=1e-4)
        assert (x - at[0], y - at[1], yaw) == pytest.approx((0.3, 0.4, 0.8 * time), abs=1.1e-3)
    for time in run.group("pieces")[0][:-1]:
        rows = run.pieces(time)
        assert rows[:PIECES, :2] == pytest.approx(
            places(math.floor(time / 0.04 + 1e-6) * 0.04 or time)[:, :2], abs=0.011
        )
        assert rows[:PIECES, 3].tolist() == [2.0] + [1.0] * (PIECES - 1), "the first one flies"
        assert rows[PIECES, 3] == 3.0 and rows[PIECES, :2] == pytest.approx(HELD, abs=6e-4), "in robot 0's frame"


def test_a_box_has_its_attitude_and_pieces_without_ids_are_told_apart_by_their_rows(tmp_path: Path) -> None:
    crate = PieceLook(size=(0.6, 0.2, 0.3), color="#11aaee")
    rows = np.zeros((2, 7))
    rows[:, :3] = (2.0, 1.0, 0.15), (6.0, 3.5, 0.15)
    rows[:, 3], rows[:, 6] = (1.0, np.cos(np.pi / 8)), (0.0, np.sin(np.pi / 8))
    recording = Recording()
    recording.write(Snapshot(time=0.02, tick=0, pose_arrays={"Sim/GamePieces/Crate": rows}))
    run = page(tmp_path, recording, replace(SCENE, pieces={"Crate": crate}))
    (kind,) = run.meta["kinds"]
    assert kind["size"] == [0.6, 0.2, 0.3] and not kind["round"] and kind["color"] == "#11aaee"
    seen = run.group("pieces")[1].reshape(2, 8)
    assert seen[:, :3] == pytest.approx(1000 * rows[:, :3]) and seen[:, 3].tolist() == [2, 2]
    assert seen[:, 4:] / 32767 == pytest.approx(rows[:, 3:], abs=1e-4)


def test_facts_shots_events_board_and_charts(tmp_path: Path) -> None:
    run = page(tmp_path, title="my run", subtitle="a note")
    assert run.meta["title"] == "my run" and run.meta["notes"] == ["a note"]
    assert run.facts["score blue"] == "4" and ["hits", "1 (50 %)"] in run.table("Shots (2)")
    told = {(time, kind): text for time, kind, text in run.meta["events"]}
    assert told[0.4, "hit"] == "shot, hit (1.0 m, 5.8 m/s)" and told[0.6, "miss"].startswith("shot, miss, short")
    assert (
        run.board("period", 0.02) == "auto" and run.board("period", 0.9) == "teleop" and run.board("held", 0.5) == "1"
    )
    times, volts = run.curve("Battery", "at its terminals")
    assert volts == pytest.approx(12.0 - times, abs=1e-3), "to the resolution of what is kept"
    shot = run.meta["shots"][0]
    assert (shot["result"], shot["piece"], shot["end"]) == ("hit", 0, pytest.approx(0.6, abs=0.021))


def test_a_name_is_a_text_and_cannot_break_the_page(tmp_path: Path) -> None:
    recording = Recording()
    for tick in range(3):
        recording.write(Snapshot(time=0.02 * tick, tick=tick, strings={"Sim/Match/Period": "<!--<script>"}))
    run = page(tmp_path, recording, title="</title><script>alert(1)</script>", subtitle="<b>&")
    assert "<script>alert" not in run.text and "&lt;/title&gt;" in run.text
    assert run.board("period", 0.0) == "<!--<script>" and run.meta["notes"] == ["<b>&"]
    assert "box &lt;1" in run.meta["top"] and "box <1" not in run.meta["top"], "what is drawn is escaped"


def test_a_run_without_ticks_and_one_with_infinities(tmp_path: Path) -> None:
    assert page(tmp_path, Recording()).group("robots")[1].shape == (0, 11)
    strange = recorded(3)
    numbers = {"Sim/Debug/BatteryVoltage": float("inf"), "Sim/Debug/BatteryCurrent": float("-inf")}
    strange.write(Snapshot(time=9.0, tick=449, doubles=numbers))
    assert page(tmp_path, strange).meta["end"] == 9.0


def test_models_that_cannot_be_read_cost_their_looks_alone(tmp_path: Path) -> None:
    folder = tmp_path / "models" / "Field3d_Broken"
    folder.mkdir(parents=True)
    (folder / "config.json").write_text('{"name": "Broken", "widthInches": 600, "heightInches": 300}')
    (folder / "model.glb").write_text("version https://git-lfs.github.com/spec/v1")
    for models in (folder.parent, tmp_path / "nowhere"):
        run = page(tmp_path, scene=replace(SCENE, models=models))
        assert run.meta["field"]["solids"] == [] and len(run.meta["field"]["outlines"]) == 2
        assert run.meta["models"][0]["body"], "boxes of a robot without a model"


def test_two_pages_of_a_run_are_the_same_bytes(tmp_path: Path) -> None:
    assert page(tmp_path).text == page(tmp_path).text


def test_unwritable(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot write the page"):
        write_page(tmp_path / "file" / "x.html", recorded(), SCENE)
