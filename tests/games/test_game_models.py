"""The committed models of each game: what the scripts make, sound, about their own axles, and with layouts for them."""

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
from simcore import Match
from simcore.show.scope_layout import game_snapshot
from simcore.show.view_models import load_models

ROOT = Path(__file__).resolve().parents[2]
both = pytest.mark.parametrize("game", [REBUILT, REEFSCAPE], ids=lambda game: game.name)


def script(name):
    spec = importlib.util.spec_from_file_location(name, ROOT / "scripts" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def shapes(path):
    """Every mesh of a GLB: name, bounds and color, which do not depend on how trimesh orders its vertices."""
    scene = trimesh.load_scene(path)
    return {
        name: (np.round(mesh.bounds, 4).tolist(), len(mesh.faces), mesh.visual.material.baseColorFactor.tolist())
        for name, mesh in scene.geometry.items()
    }


@both
def test_the_committed_files_are_what_the_scripts_make_sound_and_small(game, tmp_path):
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
def test_each_part_is_drawn_about_its_own_origin(game):
    """A wheel that turned about another place than its axle would wobble."""
    parts, components = load_models(game.models).robot().parts, game.robot().components
    assert len(parts) == len(components) == {"rebuilt": 16, "reefscape": 8}[game.name]
    for part, component in zip(parts, components, strict=True):
        turning = [joint.axis for joint in component.joints if not joint.slides]
        if turning and component.name not in ("hood", "arm"):
            middle = trimesh.load_scene(part.path).bounds.mean(axis=0)
            across = [i for i in range(3) if turning[-1][i] == 0.0]
            assert np.abs(middle[across]).max() < 0.005, component.name


@both
def test_red_robots_have_a_model_of_their_own(game):
    blue, red = load_models(game.models).robots
    assert red.name == blue.name + " (red)" and len(red.parts) == len(blue.parts)
    for robot, channel in ((blue, 2), (red, 0)):
        for name, mesh in trimesh.load_scene(robot.body.path).geometry.items():
            if "bumper" in name:
                assert np.argmax(mesh.visual.material.baseColorFactor[:3]) == channel, name


@both
@pytest.mark.parametrize(("file", "robots"), [("layout.json", 1), ("layout_six.json", 6)])
def test_the_layouts_show_only_what_is_published_and_what_there_are_models_for(game, file, robots):
    s = game_snapshot(game, robots=robots)
    kinds = {
        "Pose3d": s.poses,
        "Pose3d[]": s.pose_arrays,
        "SwerveModuleState[]": s.state_arrays,
        "Boolean": s.booleans,
        "String": s.strings,
        "Number": {**s.doubles, **s.integers},
    }
    (hub,) = json.loads((game.models / file).read_text())["hubs"]
    tabs = hub["state"]["tabs"]["tabs"]
    sources = [
        item
        for tab in tabs
        if isinstance(tab["controller"], dict)
        for key in ("sources", "leftSources", "rightSources", "discreteSources")
        for item in tab["controller"].get(key, [])
    ]
    for source in sources:
        assert source["logKey"].startswith("NT:/")
        assert source["logKey"].removeprefix("NT:/") in kinds[source["logType"]]
    table = next(tab["controller"] for tab in tabs if tab["type"] == 4)
    assert all(any(key.removeprefix("NT:/") in kind for kind in kinds.values()) for key in table)
    own = {"rebuilt": "NT:/Sim/Match/BlueHubActive", "reefscape": "NT:/Sim/Placed/BlueL4"}[game.name]
    assert {"NT:/Sim/Match/Period", own, "NT:/Sim/Score/Red"} <= set(table)
    assert all(tab["controller"]["leftLockedRange"] is None for tab in tabs if tab["type"] == 1), "an axis that cuts"
    currents = next(tab["controller"]["leftSources"] for tab in tabs if tab["title"] == "Currents")
    assert len(currents) == 1 + len(game.robot().mechanisms)
    models = load_models(game.models)
    field = tabs[0]["controller"]
    assert field["game"] == f"FRC:{models.field.name}"
    drawn = [item for item in field["sources"] if item["type"] == "robot"]
    assert [item["options"]["model"] for item in drawn] == [
        f"Simcore {game.name.title()}{' (red)' if number and 2 * number >= robots else ''}" for number in range(robots)
    ]
    for item in field["sources"]:
        if item["type"] == "gamePiece":
            assert item["options"]["variant"] in models.field.pieces
    following = [b["type"] for a, b in zip(field["sources"], field["sources"][1:], strict=False) if a in drawn]
    assert following == ["component"] * robots, "right after its robot"


def test_the_arm_of_the_drawn_robot_goes_up_with_its_elevator():
    """Every stage goes its share, so that none leaves the next; the coral in the claw is where the arm is."""
    names = [part.name for part in REEFSCAPE.robot().components]
    with Match(REEFSCAPE) as match:
        robot = match.robots[0]
        before = dict(zip(names, robot.component_poses(), strict=True))
        for _ in range(60):
            robot.mechanisms["elevator"].set_volts(8.0)
            for mechanism in robot.mechanisms.values():
                mechanism.step(0.02)
        after = dict(zip(names, robot.component_poses(), strict=True))
        rise = {name: float(after[name][2] - before[name][2]) for name in names}
        height = robot.mechanisms["elevator"].height
        assert height > 0.8 and rise["carriage"] == pytest.approx(height, abs=1e-9) == pytest.approx(rise["arm"])
        assert rise["elevator stage 1"] == pytest.approx(height / 3.0)
        assert rise["elevator stage 2"] == pytest.approx(height / 1.5)
        assert rise["hook"] == rise["funnel roller"] == 0.0
