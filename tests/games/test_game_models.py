"""Committed models of each game: equal to the scripts' output, sound, about their own axles, and with layouts."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from check_models import check_folder

from games.rebuilt import REBUILT
from games.reefscape import REEFSCAPE
from simcore.show.view_models import load_models

ROOT = Path(__file__).resolve().parents[2]
both = pytest.mark.parametrize("game", [REBUILT, REEFSCAPE], ids=lambda game: game.name)


def script(name):
    spec = importlib.util.spec_from_file_location(name, ROOT / "scripts" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def shapes(path):
    """Return name, bounds, number of faces and color of every mesh in a GLB, independent of vertex order."""
    scene = trimesh.load_scene(path)
    return {
        name: (np.round(mesh.bounds, 4).tolist(), len(mesh.faces), mesh.visual.material.baseColorFactor.tolist())
        for name, mesh in scene.geometry.items()
    }


@both
def test_committed_models_are_small_valid_and_equal_the_output_of_the_scripts(game, tmp_path):
    command = f"make_{game.name}_models"
    script(command).write_all(tmp_path)
    layouts = script("make_layout")
    layouts.write_layouts(game, tmp_path)
    made, committed = (
        sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
        for folder in (tmp_path, game.models)
    )
    assert committed == made and game.models.resolve() == ROOT / "models" / game.name / "advantagescope"
    for name in made:
        if name.suffix == ".glb":
            assert shapes(game.models / name) == shapes(tmp_path / name), f"{name}: run python scripts/{command}.py"
        else:
            committed_text, text = ((folder / name).read_text("utf-8") for folder in (game.models, tmp_path))
            assert json.loads(committed_text) == json.loads(text), f"{name}: run the scripts"
    assert check_folder(game.models, parts=len(game.robot().components)) == []
    assert sum(path.stat().st_size for path in game.models.rglob("*") if path.is_file()) < 2_000_000


@both
def test_each_part_model_has_its_axle_at_the_origin(game):
    """A wheel that turned about any other axis would wobble."""
    parts, components = load_models(game.models).robots[0].parts, game.robot().components
    assert len(parts) == len(components) == {"rebuilt": 16, "reefscape": 8}[game.name]
    for part, component in zip(parts, components, strict=True):
        turning = [joint.axis for joint in component.joints if not joint.slides]
        if turning and component.name not in ("hood", "arm"):
            middle = trimesh.load_scene(part.path).bounds.mean(axis=0)
            across = [i for i in range(3) if turning[-1][i] == 0.0]
            assert np.abs(middle[across]).max() < 0.005, component.name


@both
def test_blue_and_red_models_have_equal_part_counts_and_bumpers_in_alliance_color(game):
    blue, red = load_models(game.models).robots
    assert red.name == blue.name + " (red)" and len(red.parts) == len(blue.parts)
    for robot, channel in ((blue, 2), (red, 0)):
        for name, mesh in trimesh.load_scene(robot.body.path).geometry.items():
            if "bumper" in name:
                assert np.argmax(mesh.visual.material.baseColorFactor[:3]) == channel, name
