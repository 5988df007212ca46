"""Outlines of pieces from above."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from simcore.errors import ConfigError
from simcore.show.scene import PLAIN_PIECE, PieceLook, RobotLook, Scene


def rows(*rotations: Rotation) -> np.ndarray:
    """Poses at (1, 2, 0.5) with these rotations, shape (n, 7)."""
    return np.array([(1.0, 2.0, 0.5, *rotation.as_quat(scalar_first=True)) for rotation in rotations])


def test_a_box_is_seen_from_above_as_it_lies() -> None:
    look = PieceLook(size=(0.3, 0.12, 0.1), color="#ffffff")
    seen = look.rectangles(
        rows(
            Rotation.identity(),
            Rotation.from_euler("z", 130, degrees=True),
            Rotation.from_euler("x", 90, degrees=True),
            Rotation.from_euler("y", 90, degrees=True),
            Rotation.from_euler("y", 30, degrees=True),
        )
    )
    tilted = 0.3 * math.cos(math.radians(30)) + 0.1 * math.sin(math.radians(30))
    assert seen[:, :2] == pytest.approx(np.array([(0.3, 0.12), (0.3, 0.12), (0.3, 0.1), (0.12, 0.1), (tilted, 0.12)]))
    assert seen[:, 2] == pytest.approx([0.0, math.radians(-50), 0.0, math.pi / 2, 0.0])


def test_a_disk_and_derived_colors() -> None:
    look = PieceLook(radius=0.1, color="#804020")
    assert look.rectangles(rows(Rotation.identity())).tolist() == [[0.2, 0.2, 0.0]]
    assert (look.air_color, look.edge_color) == ("#603018", "#402010")


def test_names_and_unknown_types() -> None:
    scene = Scene(field_size=(2.0, 1.0), pieces={"Ball": PieceLook(radius=0.1, color="#804020")})
    assert scene.piece_names == "ball" and Scene(field_size=(2.0, 1.0)).piece_names == "pieces"
    assert scene.look("Crate") is PLAIN_PIECE


def test_bad_looks() -> None:
    for options in ({}, {"radius": 0.1, "size": (0.1, 0.1, 0.1)}):
        with pytest.raises(ConfigError, match="radius or size"):
            PieceLook(color="#ffffff", **options)
    with pytest.raises(ConfigError, match="above 0"):
        PieceLook(color="#ffffff", size=(0.1, 0.0, 0.1))
    with pytest.raises(ConfigError, match="bumpers"):
        RobotLook(bumpers=(0.8, 0.0))
