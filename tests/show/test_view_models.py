"""Model folders: read as AdvantageScope reads them, with checks for what it would skip in silence."""

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from check_models import check_folder

from simcore.errors import ModelError
from simcore.show.view_models import load_models


def glb(path: Path, size: float = 0.5) -> None:
    path.write_bytes(trimesh.Scene(trimesh.creation.box((size, size, size))).export(file_type="glb"))


def edit(folder: Path, **changes: Any) -> None:
    path = folder / "config.json"
    config = json.loads(path.read_text())
    for key, value in changes.items():
        if value is None:
            config.pop(key)
        else:
            config[key] = value
    path.write_text(json.dumps(config))


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    folder = tmp_path / "Robot_Mine"
    folder.mkdir()
    config = {
        "name": "Mine", "rotations": [{"axis": "x", "degrees": 90}], "position": [0.1, 0.0, 0.0],
        "cameras": [{"name": "Front", "rotations": [], "position": [0, 0, 0], "resolution": [960, 720], "fov": 90}],
        "components": [{"zeroedRotations": [], "zeroedPosition": [0, 0, 0]}] * 2,
    }  # fmt: skip
    (folder / "config.json").write_text(json.dumps(config))
    for name in ("model.glb", "model_0.glb", "model_1.glb"):
        glb(folder / name)
    return folder


@pytest.fixture
def field(tmp_path: Path) -> Path:
    folder = tmp_path / "Field3d_Mine"
    folder.mkdir()
    config = {
        "name": "Mine", "isFTC": False, "coordinateSystem": "wall-blue", "rotations": [], "position": [0, 0, 0],
        "widthInches": 1000 / 2.54, "heightInches": 400 / 2.54, "driverStations": [],
        "gamePieces": [{"name": "Ball", "rotations": [], "position": [0, 0, 0], "stagedObjects": []}], "aprilTags": [],
    }  # fmt: skip
    (folder / "config.json").write_text(json.dumps(config))
    glb(folder / "model.glb", 5.0)
    glb(folder / "model_0.glb", 0.1)
    return folder


def texts(folder: Path, **options: Any) -> list[str]:
    return [str(finding) for finding in check_folder(folder, **options)]


def test_nothing_is_reported_for_valid_folders(robot: Path, field: Path) -> None:
    assert texts(robot.parent) == []
    assert texts(robot, parts=2) == []


def test_rotations_are_applied_in_order_and_then_the_position(robot: Path) -> None:
    """A rotation by 90 about x sets a Y-up export upright; another by 90 about z turns its front."""
    body = load_models(robot.parent).robots[0].body.transform
    np.testing.assert_allclose(body @ (0, 1, 0, 1), (0.1, 0, 1, 1), atol=1e-12)
    edit(robot, rotations=[{"axis": "x", "degrees": 90}, {"axis": "z", "degrees": 90}], position=[0, 0, 0])
    body = load_models(robot.parent).robots[0].body.transform
    np.testing.assert_allclose(body @ (1, 0, 0, 1), (0, 1, 0, 1), atol=1e-12)
    np.testing.assert_allclose(body @ (0, 1, 0, 1), (0, 0, 1, 1), atol=1e-12)


def test_a_field_model_has_its_origin_at_the_center_and_red_at_minus_x(field: Path) -> None:
    models = load_models(field.parent).field
    assert models is not None and models.size == pytest.approx((10.0, 4.0))
    np.testing.assert_allclose(models.body.transform @ (-5.0, -2.0, 0.0, 1.0), (10.0, 4.0, 0.0, 1.0), atol=1e-9)
    assert list(models.pieces) == ["Ball"]


def test_models_that_cannot_be_loaded_are_reported(robot: Path, field: Path, tmp_path: Path) -> None:
    (robot / "model_1.glb").unlink()
    with pytest.raises(ModelError, match=r"Robot_Mine: model_1\.glb is missing"):
        load_models(tmp_path)
    with pytest.raises(ModelError, match="no folder"):
        load_models(tmp_path / "none")
    with pytest.raises(ModelError, match="neither a Field3d_"):
        load_models(robot)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"name": None}, 'needs a "name"'),
        ({"name": ""}, 'needs a "name"'),
        ({"rotations": [{"axis": "w", "degrees": 90}]}, "rotations must be a list"),
        ({"rotations": [{"axis": "x"}]}, "rotations must be a list"),
        ({"position": [0, 0]}, "position [x, y, z]"),
        ({"position": [0, 0, float("nan")]}, "finite"),
        ({"components": 3}, "components must be a list"),
        ({"components": [{"zeroedPosition": "high"}, {}]}, "position [x, y, z]"),
        ({"cameras": [{"fov": 90}]}, "camera 0 needs"),
        ({"components": [{}]}, "2 poses are published"),
    ],
)
def test_mistakes_in_a_robot_config_are_reported(robot: Path, changes: dict[str, Any], words: str) -> None:
    edit(robot, **changes)
    found = texts(robot, parts=2)
    assert any(words in line for line in found), found
    assert all(line.startswith(("ERROR: Robot_Mine", "warning: Robot_Mine")) and "\n" not in line for line in found)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"isFTC": None}, "isFTC"),
        ({"coordinateSystem": None}, "wall-blue"),
        ({"coordinateSystem": "wall-bleu"}, "wall-blue"),
        ({"widthInches": "long"}, "widthInches"),
        ({"heightInches": -3}, "heightInches"),
        ({"gamePieces": [{}]}, "game piece 0 needs"),
        ({"gamePieces": None}, "model_0.glb: is not used"),
    ],
)
def test_mistakes_in_a_field_config_are_reported(field: Path, changes: dict[str, Any], words: str) -> None:
    edit(field, **changes)
    found = texts(field)
    assert any(words in line for line in found), found


def test_a_git_lfs_pointer_is_reported(robot: Path) -> None:
    (robot / "model_0.glb").write_text("version https://git-lfs.github.com/spec/v1\noid sha256:4d7a21\nsize 7340032\n")
    assert texts(robot) == [
        "ERROR: Robot_Mine/model_0.glb: is a Git LFS pointer, not the model: "
        "run `git lfs install` and `git lfs pull` in the project"
    ]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "is empty"),
        (b"solid stl" * 9, "no GLB"),
        (struct.pack("<4sII", b"glTF", 1, 30) + b" " * 18, "glTF 1"),
        (struct.pack("<4sII", b"glTF", 2, 9000) + b" " * 18, "cut off: 30 of 9000 bytes"),
    ],
)
def test_broken_model_files_are_reported(robot: Path, content: bytes, words: str) -> None:
    (robot / "model.glb").write_bytes(content)
    (line,) = texts(robot)
    assert line.startswith("ERROR: Robot_Mine/model.glb: ") and words in line


def test_missing_renamed_unused_and_huge_models_are_reported(robot: Path) -> None:
    (robot / "model_1.glb").rename(robot / "Model_1.glb")
    glb(robot / "model_7.glb")
    glb(robot / "model.glb", 800.0)
    found = texts(robot)
    assert "ERROR: Robot_Mine: model_1.glb is missing; there is 'Model_1.glb', but names are case-sensitive" in found
    assert any("model_7.glb: is not used" in line for line in found)
    assert any("is 800 long" in line and "millimeters" in line for line in found)


def test_a_file_of_a_hundred_megabytes_gives_a_warning(robot: Path) -> None:
    with (robot / "model.glb").open("r+b") as file:
        file.seek(12)
        binary = 20 + struct.unpack("<I", file.read(4))[0]  # where the second chunk begins, which is made longer
        for place, length in ((8, 100_000_000), (binary, 100_000_000 - binary - 8)):
            file.seek(place)
            file.write(struct.pack("<I", length))
        file.truncate(100_000_000)
    assert any(line.startswith("warning") and "is 100 MB" in line for line in texts(robot))


def test_invalid_json_configs_and_duplicate_names_are_reported(robot: Path, tmp_path: Path) -> None:
    other = tmp_path / "Robot_Zwei"
    other.mkdir()
    assert any("Robot_Zwei: cannot read config.json" in line for line in texts(tmp_path))
    (other / "config.json").write_text("{name: 3}")
    assert any("config.json is not JSON" in line for line in texts(tmp_path))
    (other / "config.json").write_text("[]")
    assert any("must be an object" in line for line in texts(tmp_path))
    (other / "config.json").write_text('{"name": "Mine"}')
    assert any("'Mine' is taken by Robot_Mine" in line for line in texts(tmp_path))


def test_a_folder_without_models_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="no folder"):
        check_folder(tmp_path / "none")
    with pytest.raises(ModelError, match="looks at no other"):
        check_folder(tmp_path)
