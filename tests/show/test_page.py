"""Contents of the page of a run, read by `page_reader.py`; tests with a browser are in tests/view."""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from made_up_run import HELD, PIECES, SCENE, places, pose, recorded
from page_reader import PageReader, yaw_of

from simcore.errors import OutputError
from simcore.match.game import Game
from simcore.match.runner import split_level
from simcore.pieces.resting_places import RestingPlace
from simcore.show import page as page_module
from simcore.show.page import page_html, write_page
from simcore.show.scene import PieceLook, Scene, bare_scene
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot
from simcore.world.zones import BoxZone, CapsuleZone, CylinderZone

PLACES = (
    RestingPlace(name="Blue A Top", level="BlueTop", zone=CylinderZone((2.0, 1.0), 0.1, 1.0, 1.2), capacity=1),
    RestingPlace(name="Blue B Top", level="BlueTop", zone=CylinderZone((2.0, 2.0), 0.1, 1.0, 1.2), capacity=1),
    RestingPlace(name="Blue tray", level="BlueTray", zone=CapsuleZone((1.5, 1.5, 0.5), (2.5, 1.5, 0.5), 0.1)),
    RestingPlace(name="shelf", level="Shelf", zone=BoxZone((5.0, 1.0, 0.3), (6.0, 2.0, 0.6))),
    RestingPlace(name="not counted", zone=BoxZone((7.0, 1.0, 0.3), (7.5, 2.0, 0.6))),
)
COUNTS = [  # time, and pieces in each place of each level
    (0.0, {"BlueTop": (0, 0), "BlueTray": (0,), "Shelf": (2,)}),
    (1.0, {"BlueTop": (0, 1), "BlueTray": (0,), "Shelf": (2,)}),
    (2.0, {"BlueTop": (0, 0), "BlueTray": (3,), "Shelf": (1,)}),
]


def page(tmp_path: Path, recording: Recording | None = None, scene: Scene = SCENE, **words: str) -> PageReader:
    path = tmp_path / "new" / "run.html"
    write_page(path, recorded() if recording is None else recording, scene, **words)
    return PageReader(path)


def test_a_page_loads_no_external_resource(tmp_path: Path) -> None:
    text = re.sub(r'(<script type="text/plain" id="\w+">)[^<]*', r"\1", page(tmp_path).text)
    assert not re.search(r"https?:|//[a-z]|\bsrc=|@import|url\(|<iframe|<img", text, re.IGNORECASE)
    assert "default-src 'none'" in text and "connect-src 'none'" in text and "connect-src 'self'" in page_html("live")


def test_frames_contain_the_positions_of_pieces_and_robots_and_the_estimated_pose(tmp_path: Path) -> None:
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


def test_the_page_contains_box_attitudes_and_identifies_pieces_without_ids_by_row(tmp_path: Path) -> None:
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


def test_a_page_contains_facts_shots_events_boards_and_charts(tmp_path: Path) -> None:
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


def test_a_name_is_shown_as_text_and_cannot_break_the_page(tmp_path: Path) -> None:
    recording = Recording()
    for tick in range(3):
        recording.write(Snapshot(time=0.02 * tick, tick=tick, strings={"Sim/Match/Period": "<!--<script>"}))
    run = page(tmp_path, recording, title="</title><script>alert(1)</script>", subtitle="<b>&")
    assert "<script>alert" not in run.text and "&lt;/title&gt;" in run.text
    assert run.board("period", 0.0) == "<!--<script>" and run.meta["notes"] == ["<b>&"]
    assert [name for name, *_ in run.meta["field"]["outlines"]] == ["blue_hub", "box <1>"]
    player = Path(page_module.__file__).with_name("player")
    assert not [path.name for path in player.glob("*.js") if "innerHTML" in path.read_text(encoding="utf-8")]


def test_levels_contain_their_places_and_the_counts_of_pieces_in_each_place(tmp_path: Path) -> None:
    game = Game.bare(size=SCENE.field_size, places=PLACES, robot=lambda: pytest.fail("no robot is asked for"))
    recording = Recording()
    for tick, (time, levels) in enumerate(COUNTS):
        counts = {f"Sim/Places/{name}": np.array(row) for name, row in levels.items()}
        totals = {f"Sim/Placed/{name}": sum(row) for name, row in levels.items()}
        recording.write(Snapshot(time=time, tick=tick, integer_arrays=counts, integers=totals))
    run = page(tmp_path, recording, replace(SCENE, levels=bare_scene(game).levels))
    assert [tuple(level.values()) for level in run.meta["levels"]] == [
        ("BlueTop", "blue", "Top", ["A", "B"], 2, True, [2.0, 1.5]),
        ("BlueTray", "blue", "Tray", [""], 1, False, [2.0, 1.5]),
        ("Shelf", "", "Shelf", [""], 1, False, [5.5, 1.5]),
    ]
    assert {"placed, blue top +1", "placed, shelf -1"} <= {text for _, _, text in run.meta["events"]}
    steps = {name: list(zip(*changes.values(), strict=True)) for name, changes in run.meta["cells"].items()}
    assert steps == {
        "BlueTop/0": [(0.0, 0)], "BlueTop/1": [(0.0, 0), (1.0, 1), (2.0, 0)],
        "BlueTop": [(0.0, 0), (1.0, 1), (2.0, 0)], "BlueTray/0": [(0.0, 0), (2.0, 3)], "BlueTray": [(0.0, 0), (2.0, 3)],
        "Shelf/0": [(0.0, 2), (2.0, 1)], "Shelf": [(0.0, 2), (2.0, 1)],
    }  # fmt: skip
    assert page(tmp_path, recording).meta["levels"] == [], "of a game without places"


def test_levels_named_only_like_an_alliance_belong_to_no_alliance() -> None:
    assert [split_level(name) for name in ("RedL1", "Red", "Reef")] == [("red", "L1"), ("", "Red"), ("", "Reef")]


def test_a_page_is_written_for_a_run_without_ticks_or_with_infinities(tmp_path: Path) -> None:
    assert page(tmp_path, Recording()).group("robots")[1].shape == (0, 11)
    strange = recorded(3)
    numbers = {"Sim/Debug/BatteryVoltage": float("inf"), "Sim/Debug/BatteryCurrent": float("-inf")}
    strange.write(Snapshot(time=9.0, tick=449, doubles=numbers))
    assert page(tmp_path, strange).meta["end"] == 9.0


def test_objects_whose_models_cannot_be_read_are_drawn_as_plain_shapes(tmp_path: Path) -> None:
    folder = tmp_path / "models" / "Field3d_Broken"
    folder.mkdir(parents=True)
    (folder / "config.json").write_text('{"name": "Broken", "widthInches": 600, "heightInches": 300}')
    (folder / "model.glb").write_text("version https://git-lfs.github.com/spec/v1")
    for models in (folder.parent, tmp_path / "nowhere"):
        run = page(tmp_path, scene=replace(SCENE, models=models))
        assert run.meta["field"]["solids"] == [] and len(run.meta["field"]["outlines"]) == 2
        assert run.meta["models"][0]["body"], "boxes of a robot without a model"


def test_two_pages_of_the_same_run_have_the_same_bytes(tmp_path: Path) -> None:
    assert page(tmp_path).text == page(tmp_path).text


def test_a_page_that_cannot_be_written_raises_an_output_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot write the page"):
        write_page(tmp_path / "file" / "x.html", recorded(), SCENE)
