"""Which places of a field are taken, on the page and in pictures."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from made_up_run import SCENE
from page_reader import PageReader

from simcore.geometry.zones import BoxZone, CapsuleZone, CylinderZone
from simcore.match.game import Game
from simcore.match.runner import split_level
from simcore.pieces.resting_places import RestingPlace
from simcore.show.page import write_page
from simcore.show.place_board import PlaceBoard
from simcore.show.scene import bare_scene
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot

PLACES = (
    RestingPlace(name="Blue A Top", level="BlueTop", zone=CylinderZone((2.0, 1.0), 0.1, 1.0, 1.2), capacity=1),
    RestingPlace(name="Blue B Top", level="BlueTop", zone=CylinderZone((2.0, 2.0), 0.1, 1.0, 1.2), capacity=1),
    RestingPlace(name="Blue tray", level="BlueTray", zone=CapsuleZone((1.5, 1.5, 0.5), (2.5, 1.5, 0.5), 0.1)),
    RestingPlace(name="shelf", level="Shelf", zone=BoxZone((5.0, 1.0, 0.3), (6.0, 2.0, 0.6))),
    RestingPlace(name="not counted", zone=BoxZone((7.0, 1.0, 0.3), (7.5, 2.0, 0.6))),
)
ROWS = [  # time, and pieces in each place of each level
    (0.0, {"BlueTop": (0, 0), "BlueTray": (0,), "Shelf": (2,)}),
    (1.0, {"BlueTop": (0, 1), "BlueTray": (0,), "Shelf": (2,)}),
    (2.0, {"BlueTop": (0, 0), "BlueTray": (3,), "Shelf": (1,)}),
]


@pytest.fixture
def scene():
    game = Game.bare(size=SCENE.field_size, places=PLACES, robot=lambda: pytest.fail("no robot is asked for"))
    return replace(SCENE, levels=bare_scene(game).levels)


def recorded() -> Recording:
    recording = Recording()
    for tick, (time, levels) in enumerate(ROWS):
        counts = {f"Sim/Places/{name}": np.array(row) for name, row in levels.items()}
        totals = {f"Sim/Placed/{name}": sum(row) for name, row in levels.items()}
        recording.write(Snapshot(time=time, tick=tick, integer_arrays=counts, integers=totals))
    return recording


def test_a_board_has_a_row_a_level_and_a_mark_for_what_is_taken(scene) -> None:
    assert [(level.alliance, level.label, level.places, level.is_single) for level in scene.levels] == [
        ("blue", "Top", ("A", "B"), True), ("blue", "Tray", ("",), False), ("", "Shelf", ("",), False),
    ]  # fmt: skip
    assert [level.middle for level in scene.levels] == [(2.0, 1.5), (2.0, 1.5), (5.5, 1.5)]
    board = PlaceBoard(recorded(), scene)
    assert board.alliances == ["blue", ""]
    text = board.board("blue", 1.5)
    full = re.findall(r'class="cell full" data-cell="([^"]+)"', text)
    assert full == ["BlueTop/1"] and text.count('class="cell"') == 2 and "<title>Top B</title>" in text
    assert [text.count(f">{name}</text>") for name in ("A", "B", "Top", "Tray", "of 2")] == [1] * 5
    counts = board.field_counts(2.0, 400.0)
    assert counts.count("<rect") == 2 and re.findall(r">(Top|Tray|Shelf|\d)</text>", counts) == [
        "Top", "0", "Tray", "3", "Shelf", "1",
    ]  # fmt: skip


def test_page_and_picture_have_boards_and_a_run_without_places_has_none(scene, tmp_path: Path) -> None:
    write_page(tmp_path / "run.html", recorded(), scene)
    page = PageReader(tmp_path / "run.html")
    assert "Placed for blue" in page.meta["places"][0] and "<strong>Placed</strong>" in page.meta["places"][1]
    assert {"placed, blue top +1", "placed, shelf -1"} <= {text for _, _, text in page.meta["events"]}
    steps = {name: list(zip(*changes.values(), strict=True)) for name, changes in page.meta["cells"].items()}
    assert steps == {
        "BlueTop/0": [(0.0, 0)], "BlueTop/1": [(0.0, 0), (1.0, 1), (2.0, 0)],
        "BlueTop": [(0.0, 0), (1.0, 1), (2.0, 0)], "BlueTray/0": [(0.0, 0), (2.0, 3)], "BlueTray": [(0.0, 0), (2.0, 3)],
        "Shelf/0": [(0.0, 2), (2.0, 1)], "Shelf": [(0.0, 2), (2.0, 1)],
    }  # fmt: skip
    for levels, recording in ((scene.levels, Recording()), ((), recorded())):
        assert PlaceBoard(recording, replace(scene, levels=levels)).alliances == []
        assert PlaceBoard(recording, replace(scene, levels=levels)).field_counts(0.0, 400.0) == ""


def test_levels_that_are_called_like_an_alliance_alone_are_nobodys() -> None:
    assert [split_level(name) for name in ("RedL1", "Red", "Reef")] == [("red", "L1"), ("", "Red"), ("", "Reef")]
