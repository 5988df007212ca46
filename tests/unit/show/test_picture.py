from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from simcore.errors import ConfigError, OutputError
from simcore.show.picture import draw_match
from simcore.show.scene import PieceLook, RobotLook, Scene, ShotTrace
from simcore.telemetry.sinks import require_writable

SCENE = Scene(
    field_outlines=[("blue_hub", np.array([[4.0, 3.4], [5.2, 3.4], [5.2, 4.6], [4.0, 4.6]]))],
    field_size=(16.541, 8.069),
    robots=[RobotLook(bumpers=(0.8, 0.8))],
    pieces={
        "Fuel": PieceLook(radius=0.075, color="#ffd923", edge_color="#7d6400"),
        "Crate": PieceLook(size=(0.6, 0.4, 0.3), color="#11aaee"),
    },
)


def poses(*centers: tuple[float, float, float]) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.array([(*center, 1.0, 0.0, 0.0, 0.0) for center in centers])


RUN: dict[str, Any] = {
    "robot_paths": [np.array([[1.0 + 0.02 * k, 2.0, 0.01 * k] for k in range(200)])],
    "pieces_before": {"Fuel": poses((8.0, 4.0, 0.075), (8.2, 4.0, 0.075)), "Crate": poses((3.0, 7.0, 0.15))},
    "pieces_after": {"Fuel": poses((12.0, 6.0, 0.075)), "Crate": poses((12.0, 7.0, 0.15))},
}
EMPTY = np.empty((0, 3))


def pixels(path: Path) -> np.ndarray[Any, np.dtype[np.float64]]:
    from matplotlib.image import imread

    return np.asarray(imread(path), dtype=np.float64)[:, :, :3]


def near(image: np.ndarray[Any, np.dtype[np.float64]], rgb: tuple[float, float, float]) -> int:
    return int((np.abs(image - rgb).max(axis=2) < 0.02).sum())


def test_picture_shows_pieces_hits_and_misses(tmp_path: Path) -> None:
    shots = [
        ShotTrace(points=np.array([[2.0, 2.0, 0.5], [4.6, 4.0, 1.8]]), scored=True),
        ShotTrace(points=np.array([[2.0, 2.0, 0.5], [6.6, 4.0, 0.0]]), scored=False),
    ]
    draw_match(tmp_path / "all.png", replace(SCENE, shots=shots), **RUN, title="a $1 title", subtitle="and more")
    draw_match(tmp_path / "none.png", SCENE)
    full, bare = pixels(tmp_path / "all.png"), pixels(tmp_path / "none.png")
    assert full.shape == (1000, 1600, 3)
    for color in ((1.0, 0.851, 0.137), (0.067, 0.667, 0.933), (0.055, 0.541, 0.263), (0.878, 0.384, 0.051)):
        assert near(full, color) > near(bare, color)


def test_nothing_at_all_and_another_field_shape(tmp_path: Path) -> None:
    shots = [ShotTrace(points=EMPTY, scored=False)]
    draw_match(tmp_path / "new" / "square.svg", Scene(field_size=(3.6, 3.6), shots=shots))
    assert (tmp_path / "new" / "square.svg").stat().st_size > 1000


def test_unwritable(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot write the picture"):
        draw_match(tmp_path / "file" / "x.png", SCENE)
    with pytest.raises(OutputError, match=r"pictures end in \.pdf, \.png, \.svg"):
        draw_match(tmp_path / "x.gif", SCENE)


def test_check_before_the_run_leaves_nothing_and_keeps_what_is_there(tmp_path: Path) -> None:
    require_writable("picture", tmp_path / "out" / "new.png")
    assert list((tmp_path / "out").iterdir()) == []
    (tmp_path / "old.png").write_text("old")
    require_writable("picture", tmp_path / "old.png")
    assert (tmp_path / "old.png").read_text() == "old"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"pieces_after": {"Fuel": np.zeros((3, 2))}}, r"pieces_after\['Fuel'\] needs shape \(n, 7\)"),
        ({"robot_paths": [EMPTY, EMPTY]}, "2 robot_paths for 1 robots"),
        ({"path_period": float("nan")}, "path_period"),
    ],
)
def test_bad_input(tmp_path: Path, change: dict[str, Any], words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        draw_match(tmp_path / "x.png", SCENE, **(RUN | change))


def test_bad_shots(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"shots\[0\]"):
        draw_match(tmp_path / "x.png", replace(SCENE, shots=[ShotTrace(points=np.zeros(3), scored=True)]))


def test_import_loads_no_matplotlib_and_logs_need_no_ntcore() -> None:
    code = (
        "import sys, simcore.show.picture, simcore.telemetry.wpilog, simcore.telemetry.sinks\n"
        "import simcore.show.failed_run, simcore.show.animation\n"
        "assert not {'matplotlib', 'PIL', 'ntcore', 'wpiutil'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
