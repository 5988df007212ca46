"""The page as a file; what a browser makes of it where there is one."""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_up_run import HELD, PIECES, SCENE, places, pose, recorded

from simcore.errors import OutputError
from simcore.show.page import write_page
from simcore.show.scene import PieceLook
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
WIDTH = 100 * SCENE.field_size[1]


def page(tmp_path: Path, recording: Recording | None = None, **words: str) -> str:
    path = tmp_path / "new" / "run.html"
    write_page(path, recorded() if recording is None else recording, SCENE, **words)
    return path.read_text(encoding="utf-8")


def data(text: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="run">(.*?)</script>', text, re.DOTALL)
    assert found
    return json.loads(found.group(1))  # type: ignore[no-any-return]


def test_nothing_is_loaded_from_anywhere(tmp_path: Path) -> None:
    text = page(tmp_path).replace('xmlns="http://www.w3.org/2000/svg"', "").replace('"http://www.w3.org/2000/svg"', "")
    assert not re.search(r"https?:|//[a-z]|\bsrc=|@import|url\(|<link|<iframe|<img", text, re.IGNORECASE)
    assert "default-src 'none'" in text


def test_frames_say_where_each_piece_and_robot_was_and_what_the_robot_believed(tmp_path: Path) -> None:
    run = data(page(tmp_path))
    frames = run["frames"]
    assert [frame["time"] for frame in frames][:3] == [0.02, 0.04, 0.08]
    assert frames[-1]["time"] == run["end"] == 1.0
    assert run["kinds"] == [PIECES + 1]
    table = {row[0]: row[1:] for row in run["first"]}
    for frame in frames:
        for row, holder, x, y, scale, in_air in frame["moved"]:
            table[row] = [holder, x, y, scale, scale, 0, in_air]
        time = frame["time"]
        shown = np.array([table[row] for row in range(PIECES)])
        assert set(shown[:, 0]) == {0}
        truth = places(round(time / 0.04) * 0.04 if time not in (0.02, 1.0) else time)
        seen = np.column_stack((shown[:, 1], WIDTH - shown[:, 2])) / 100
        assert seen == pytest.approx(truth[:, :2], abs=0.0051), "each by its id, to the centimeter"
        assert shown[:, 6].tolist() == [1] + [0] * (PIECES - 1), "the first one flies"
        holder, x, y, *_ = table[PIECES]
        assert (holder, x / 100, -y / 100) == pytest.approx((1, *HELD), abs=0.0051), "in robot 0, in its frame"
        (x, y, yaw), (bx, by, _) = frame["robots"][0], frame["ghosts"][0]
        assert (x / 100, y / 100, yaw) == pytest.approx((*pose(time)[:2], 0.8 * time), abs=2e-3)
        assert (bx - x, by - y) == pytest.approx((30, 40), abs=0.11)
    assert sum(len(frame["moved"]) for frame in frames) < 12 * len(frames), "only what moved"


def test_boxes_are_scaled_and_turned(tmp_path: Path) -> None:
    crate = PieceLook(size=(0.6, 0.2, 0.3), color="#11aaee", air_color="#0000aa", edge_color="#222222")
    rows = np.zeros((2, 7))
    rows[:, :3] = (2.0, 1.0, 0.15), (6.0, 3.5, 0.15)
    rows[:, 3], rows[:, 6] = (1.0, np.cos(np.pi / 8)), (0.0, np.sin(np.pi / 8))
    recording = Recording()
    balls = np.array([[4.0, 1.0, 0.075, 1.0, 0.0, 0.0, 0.0]])
    arrays = {"Sim/GamePieces/Fuel": balls, "Sim/GamePieces/Crate": rows}
    recording.write(Snapshot(time=0.02, tick=0, pose_arrays=arrays))  # without ids, as old logs are
    path = tmp_path / "run.html"
    write_page(path, recording, replace(SCENE, pieces={**SCENE.pieces, "Crate": crate}))
    text = path.read_text(encoding="utf-8")
    run = data(text)
    assert run["kinds"] == [1, 2] and run["round"] == [True, False]
    assert [row[1:] for row in run["first"]] == [
        [0, 400, 300, 100, 100, 0, 0],
        [0, 200, 300, 60, 20, 0, 0],
        [0, 600, 50, 60, 20, 315, 0],  # a turn to the left is one against the clock, which y down makes negative
    ]
    assert 'fill="#11aaee"' in text and ">crate</span>" in text.replace(" crate", "crate").replace("</svg>", ">")


def test_facts_shots_events_and_charts_are_there_without_a_script(tmp_path: Path) -> None:
    text = html.unescape(page(tmp_path, title="my run", subtitle="a note"))
    for words in ("my run", "a note", "hit, shot at 0.40 s by robot 0", "Battery [V]", "Fuel held [pieces]", "time [s]",
                  "Pose estimate off by [m]", "missed short", "1 (50 %)", "0.40 s: shot, hit (1.0 m, 5.8 m/s)",
                  "0.60 s: shot, miss, short", "teleop", "blue +"):  # fmt: skip
        assert words in text, words
    assert text.count('<use href="#p0') == PIECES + 1, "pieces at the start"
    assert text.count('class="robot') == text.count('class="ghost"') == 1


def test_a_title_cannot_break_the_page(tmp_path: Path) -> None:
    text = page(tmp_path, title="</title><script>alert(1)</script>", subtitle="<b>&")
    assert "<script>alert" not in text and "&lt;b&gt;&amp;" in text
    assert "box &lt;1" in text
    assert data(text)["end"] == 1.0


def test_a_name_can_neither_end_the_data_nor_hide_their_end(tmp_path: Path) -> None:
    recording = Recording()
    for tick in range(3):
        recording.write(Snapshot(time=0.02 * tick, tick=tick, strings={"Sim/Match/Period": "<!--<script>"}))
    run = re.search(r'id="run">(.*?)</script>', page(tmp_path, recording), re.DOTALL)[1]  # type: ignore[index]
    assert "<" not in run and r"\u003c!--\u003cscript>" in run


def test_a_robot_that_only_drives_has_no_view_from_its_side(tmp_path: Path) -> None:
    plain = Recording()
    for snapshot in recorded().snapshots():
        arrays = {key: rows for key, rows in snapshot.pose_arrays.items() if "Held" not in key}
        plain.write(replace(snapshot, pose_arrays=arrays))
    text = page(tmp_path, plain)
    assert data(text)["side"] is None and '<figure class="of-robot' not in text
    assert '<figure class="of-robot' in page(tmp_path), "that one holds a piece"


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


_PROBE = """
addEventListener("load", () => {
  const key = (name, shiftKey) => document.body.dispatchEvent(
    new KeyboardEvent("keydown", { key: name, shiftKey, bubbles: true, cancelable: true }));
  const clock = () => document.querySelector("output").textContent;
  const place = (node) => node.getCTM && node.getAttribute("transform");
  const said = [clock()];
  for (const name of ["End", "ArrowLeft", "Home", "ArrowRight"]) { key(name); said.push(clock()); }
  document.querySelector('.timeline [data-to="0.60"]').click();
  said.push(clock());
  parent.postMessage(JSON.stringify({ said, width: document.documentElement.scrollWidth,
    wide: innerWidth, held: document.querySelectorAll("#now .robot .held use").length,
    robot: place(document.querySelector("#now .robot")), off: document.querySelector(".off b").textContent,
    values: [...document.querySelectorAll(".value")].map((node) => node.textContent),
    ahead: (() => { const box = document.querySelector("#now .robot polygon:last-of-type").getAttribute("points");
      return box.split(" ").map((pair) => pair.split(",").map(Number)); })() }), "*");
});
"""


@pytest.mark.skipif(BROWSER is None, reason="no Chromium or Chrome here")
def test_a_browser_plays_it_from_its_start_by_keyboard_and_at_360_pixels(tmp_path: Path) -> None:
    text = page(tmp_path, title="run")
    probe, path = tmp_path / "new" / "probe.html", tmp_path / "frame.html"
    probe.write_text(text.replace("</body>", f"<script>{_PROBE}</script></body>"), encoding="utf-8")
    frame = '<iframe src="new/probe.html" style="width:360px;height:700px;border:0"></iframe>'
    listen = "<script>addEventListener('message', (event) => document.title = event.data)</script>"
    path.write_text(f"<!DOCTYPE html><body>{listen}{frame}</body>", encoding="utf-8")
    command = [
        str(BROWSER), "--headless=new", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path / 'profile'}",
        "--enable-logging=stderr", "--virtual-time-budget=2000", "--dump-dom", path.as_uri(),
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert "CONSOLE" not in done.stderr, done.stderr
    found = re.search(r"<title>(.*?)</title>", done.stdout)
    assert found, done.stdout[:300]
    told = json.loads(html.unescape(found[1]))
    assert told["said"] == ["0.02 s", "1.00 s", "0.90 s", "0.02 s", "0.12 s", "0.60 s"]
    assert told["wide"] == 360 >= told["width"], "nothing overflows"
    assert told["held"] == 1 and told["off"] == "0.50 m"
    x, y, turn = map(float, re.findall(r"-?[\d.]+", told["robot"]))
    assert (x, WIDTH - y) == pytest.approx(100 * pose(0.6)[:2], abs=0.2) and turn == pytest.approx(
        -np.degrees(0.48), abs=0.1
    )
    tip = np.array(told["ahead"])
    corners = np.array([tip[0] - tip[1], tip[0] - tip[2], tip[1] - tip[2]])
    assert tip[0, 0] == tip[:, 0].max() == pytest.approx(32), "at the front edge of the deck"
    sides = np.linalg.norm(corners, axis=1)
    assert sides[2] < min(sides[:2]), "its sharpest corner is in front"
    assert told["values"][:3] == ["2", "0", "11.40"], "score blue and red, volts"
