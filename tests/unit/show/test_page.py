"""The page as a file; what a browser makes of it where there is one."""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_up_run import SCENE, places, pose, recorded

from simcore.errors import OutputError
from simcore.show.page import write_page
from simcore.show.scene import PieceLook
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


def page(tmp_path: Path, recording: Recording | None = None, **words: str) -> str:
    path = tmp_path / "new" / "run.html"
    write_page(path, recorded() if recording is None else recording, SCENE, **words)
    return path.read_text(encoding="utf-8")


def data(text: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="run">(.*?)</script>', text, re.DOTALL)
    assert found
    return json.loads(found.group(1))  # type: ignore[no-any-return]


def test_nothing_is_loaded_from_anywhere(tmp_path: Path) -> None:
    text = page(tmp_path)
    assert not re.search(r"https?:|//[a-z]|\bsrc=|@import|url\(|<link|<iframe|<img", text, re.IGNORECASE)
    assert "default-src 'none'" in text


def test_frames_say_where_pieces_and_robot_were(tmp_path: Path) -> None:
    run = data(page(tmp_path))
    assert [frame["time"] for frame in run["frames"]][:3] == [0.02, 0.04, 0.08]
    assert run["frames"][-1]["time"] == run["end"] == 1.0
    on_field: Counter[int] = Counter()
    for frame in run["frames"][:-1]:
        on_field.subtract(frame["gone"])
        on_field.update(frame["come"])
        shown = sorted(
            ((code // 32768 - 500) / 100, (code // 16 % 2048 - 500) / 100, code % 16 / 10)
            for code in on_field.elements()
        )
        truth = sorted(places(frame["time"]).tolist())
        assert np.array(shown)[:, :2] == pytest.approx(np.array(truth)[:, :2], abs=0.0051), "to the centimeter"
        assert sum(z > 0.9 for _, _, z in shown) == 1
        x, y, yaw = frame["robots"][0]
        assert (x / 100, y / 100, yaw) == pytest.approx((*pose(frame["time"])[:2], 0.8 * frame["time"]), abs=2e-3)
    assert sum(len(frame["come"]) for frame in run["frames"][1:]) < 11 * len(run["frames"]), "only what moved"


def test_several_types_of_pieces_have_numbers_looks_and_outlines(tmp_path: Path) -> None:
    crate = PieceLook(size=(0.6, 0.2, 0.3), color="#11aaee", air_color="#0000aa", edge_color="#222222")
    rows = np.zeros((2, 7))
    rows[:, :3] = (2.0, 1.0, 0.15), (6.0, 3.5, 1.25)
    rows[:, 3], rows[:, 6] = (1.0, np.cos(np.pi / 8)), (0.0, np.sin(np.pi / 8))
    recording = Recording()
    balls = np.array([[4.0, 1.0, 0.075, 1.0, 0.0, 0.0, 0.0]])
    arrays = {"Sim/GamePieces/Fuel": balls, "Sim/GamePieces/Crate": rows}
    recording.write(Snapshot(time=0.02, tick=0, pose_arrays=arrays))
    path = tmp_path / "run.html"
    write_page(path, recording, replace(SCENE, pieces={**SCENE.pieces, "Crate": crate}, shots=()))
    text = path.read_text(encoding="utf-8")
    run = data(text)
    assert [(look["isRound"], look["reach"], look["color"]) for look in run["pieces"]] == [
        (True, 7.5, "#ffd923"),
        (False, 35.0, "#11aaee"),
    ]
    ball, flat, turned = run["frames"][0]["come"]
    assert ball < 2**31 and max(flat, turned) < 2**53
    assert [code // 2**31 % 16 for code in (ball, flat, turned)] == [0, 1, 1]
    for code, heading in ((flat, 0.0), (turned, np.pi / 4)):
        outline = code // 2**35
        assert outline % 64 * np.pi / 64 == pytest.approx(heading, abs=0.025)
        assert (outline // 4096 * 70 / 63, outline // 64 % 64 * 70 / 63) == pytest.approx((60, 20), abs=0.6)
    assert turned % 16 == 12, "decimeters high"
    assert "<polygon" in text and "crate (darker and larger: in the air)" in text


def test_facts_shots_and_charts_are_there_without_a_script(tmp_path: Path) -> None:
    text = page(tmp_path, title="my run", subtitle="a note")
    for words in ("my run", "a note", "1 of 2", "hit, shot at 0.40 s by robot 0", "Battery [V]", "Fuel held"):
        assert words in html.unescape(text)
    assert text.count("<polyline") >= 2 + 1 + 5, "shots, path and curves"
    assert text.count("<circle") == 2 + 100, "shots' ends, and pieces at the end"


def test_a_title_cannot_break_the_page(tmp_path: Path) -> None:
    text = page(tmp_path, title="</title><script>alert(1)</script>", subtitle="<b>&")
    assert "<script>alert" not in text and "&lt;b&gt;&amp;" in text
    assert "box &lt;1&gt;" in text
    assert data(text)["end"] == 1.0


def test_a_run_without_ticks_and_one_with_infinities(tmp_path: Path) -> None:
    assert data(page(tmp_path, Recording()))["frames"] == []
    strange = recorded(3)
    numbers = {"Sim/Debug/BatteryVoltage": float("inf"), "Sim/Debug/BatteryCurrent": float("-inf")}
    strange.write(Snapshot(time=9.0, tick=449, doubles=numbers))
    assert data(page(tmp_path, strange))["end"] == 9.0


def test_unwritable(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot write the page"):
        write_page(tmp_path / "file" / "x.html", recorded(), SCENE)


@pytest.mark.skipif(BROWSER is None, reason="no Chromium or Chrome here")
def test_a_browser_plays_it_without_an_error(tmp_path: Path) -> None:
    page(tmp_path, title="run")
    target = (tmp_path / "new" / "run.html").as_uri() + "#t=0.5"
    command = [
        str(BROWSER), "--headless=new", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path / 'profile'}",
        "--enable-logging=stderr", "--virtual-time-budget=2000", "--dump-dom", target,
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert "CONSOLE" not in done.stderr, done.stderr
    assert "0.50 s</output>" in done.stdout
    assert 'class="end"' not in done.stdout, "the script has taken over"
    values = re.findall(r'<span class="value">([^<]*)<', done.stdout)
    assert values == ["2", "0", "11.50", "3", "20"], "score blue and red, volts, held, amperes at 0.5 s"
