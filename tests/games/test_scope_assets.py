"""Plain AdvantageScope models of games without models."""

from __future__ import annotations

import json

import numpy as np
import pytest
import trimesh
from check_models import check_folder
from scope_assets import write_assets

from simcore.show.scope_layout import game_snapshot, scope_layout
from simcore.show.view_models import load_models


def test_plain_models_are_written_for_the_field_the_pieces_and_blue_and_red_robots(game, tmp_path):
    """Models show the engine's elements at their positions in the field frame."""
    folders = write_assets(game, tmp_path)
    assert [path.is_dir() for path in folders] == [True] * 3
    assert check_folder(tmp_path, parts=0) == []
    models = load_models(tmp_path)
    assert models.field.size == pytest.approx(game.field.size, abs=1e-3)
    drawn = trimesh.load_scene(models.field.body.path)
    for element in game.field.load().elements:
        mesh = drawn.geometry.get(element.name)
        if mesh is not None:
            seen = mesh.vertices @ models.field.body.transform[:3, :3].T + models.field.body.transform[:3, 3]
            assert seen[:, :2].max(axis=0) == pytest.approx(element.outline().max(axis=0), abs=1e-3), element.name
            assert mesh.volume > 0.0, f"{element.name} is inside out"
    assert len(drawn.geometry) >= 1 + len(game.field.load().elements) - 1
    for supply in game.pieces:
        piece = trimesh.load_scene(models.field.pieces[supply.kind.name].path)
        assert np.abs(piece.bounds).max() <= supply.kind.bounding_radius + 1e-6
    config = json.loads((folders[0] / "config.json").read_text())
    stations = np.array(config["driverStations"])
    assert (stations[:3, 0] > 0.0).all() and stations[:3, 1].tolist() == sorted(stations[:3, 1])
    assert stations[3:] == pytest.approx(-stations[:3], abs=1e-3)
    blue, red = models.robots
    body = game.robot().body
    for robot, channel in ((blue, 2), (red, 0)):
        scene = trimesh.load_scene(robot.body.path)
        assert scene.extents[:2] == pytest.approx((body.bumper_length, body.bumper_width), abs=0.02)
        assert np.argmax(scene.geometry["bumper_front"].visual.material.baseColorFactor[:3]) == channel
    layout = scope_layout(game_snapshot(game, robots=2), models)
    field = layout["hubs"][0]["state"]["tabs"]["tabs"][0]["controller"]
    assert field["game"] == f"FRC:{models.field.name}"
    shown = {source["logKey"]: source["options"] for source in field["sources"]}
    assert shown["NT:/Sim/Robots/1/Robot/Pose3d"] == {"model": red.name}
    for supply in game.pieces:
        assert shown[f"NT:/Sim/GamePieces/{supply.kind.name}"] == {"variant": supply.kind.name}
    assert not any("/InFlight/" in key for key in shown), "those in flight are among them, and are drawn once"
