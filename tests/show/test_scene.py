"""Looks of pieces and robots."""

import pytest

from simcore.errors import ConfigError
from simcore.show.scene import PLAIN_PIECE, PieceLook, RobotLook, Scene


def test_the_air_and_edge_colors_of_a_piece_are_derived_from_its_color() -> None:
    look = PieceLook(radius=0.1, color="#804020")
    assert (look.air_color, look.edge_color) == ("#603018", "#402010")


def test_a_scene_names_its_pieces_and_shows_unknown_types_plainly() -> None:
    scene = Scene(field_size=(2.0, 1.0), pieces={"Ball": PieceLook(radius=0.1, color="#804020")})
    assert scene.piece_names == "ball" and Scene(field_size=(2.0, 1.0)).piece_names == "pieces"
    assert scene.look("Crate") is PLAIN_PIECE


def test_invalid_looks_are_refused() -> None:
    for options in ({}, {"radius": 0.1, "size": (0.1, 0.1, 0.1)}):
        with pytest.raises(ConfigError, match="radius or size"):
            PieceLook(color="#ffffff", **options)
    with pytest.raises(ConfigError, match="above 0"):
        PieceLook(color="#ffffff", size=(0.1, 0.0, 0.1))
    with pytest.raises(ConfigError, match="bumpers"):
        RobotLook(bumpers=(0.8, 0.0))
