"""Layouts for Elastic: each widget has its own place and shows a published value of a kind that it can show."""

import json
from itertools import combinations

import numpy as np
import pytest

from games.rebuilt import REBUILT
from games.reefscape import REEFSCAPE
from simcore.cli import main
from simcore.show.elastic_layout import elastic_layout
from simcore.show.scope_layout import game_snapshot

TYPES = {"double": "doubles", "int": "integers", "string": "strings", "boolean": "booleans"}


@pytest.mark.parametrize("game", [REBUILT, REEFSCAPE], ids=lambda game: game.name)
def test_widgets_show_values_that_a_match_publishes_and_do_not_overlap(game):
    snapshot = game_snapshot(game)
    layout = elastic_layout(snapshot)
    assert [tab["name"] for tab in layout["tabs"]] == ["Drive", "Robot"]
    for tab in layout["tabs"]:
        widgets = tab["grid_layout"]["containers"]
        assert len(widgets) > 8
        for one, other in combinations(widgets, 2):
            apart = [
                one[at] + one[size] <= other[at] or other[at] + other[size] <= one[at]
                for at, size in (("x", "width"), ("y", "height"))
            ]
            assert any(apart), (one["title"], other["title"])
        corners = np.array([[w[key] for key in ("x", "y", "width", "height")] for w in widgets])
        assert (corners % layout["grid_size"] == 0.0).all() and (corners[:, 0] + corners[:, 2]).max() <= 11 * 128
        for widget in widgets:
            properties = widget["properties"]
            if "data_type" in properties:
                assert properties["topic"][1:] in getattr(snapshot, TYPES[properties["data_type"]]), widget["title"]


def test_the_command_writes_a_layout(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["layout", "reefscape", "--elastic"]) == 0
    assert "in Elastic, File > Open Layout" in capsys.readouterr().out
    layout = json.loads((tmp_path / "out" / "elastic-layout.json").read_text("utf-8"))
    titles = [w["title"] for tab in layout["tabs"] for w in tab["grid_layout"]["containers"]]
    assert {"Field", "Auto", "Time Left", "Battery Voltage"} <= set(titles)
