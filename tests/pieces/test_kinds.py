"""Kinds of pieces: derived numbers against their formulas, and refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest
from each_case import each

from simcore.errors import ConfigError
from simcore.pieces.kinds import GamePieceConfig
from simcore.world.contact_law import FoamStiffness
from simcore.world.shapes import Box, Compound, Cylinder, Hull, Mesh, Part, Sphere, centered, tube


def test_the_shape_determines_the_rest_height_and_bounding_radius_of_a_piece():
    ball = GamePieceConfig(name="Ball", shape=Sphere(0.1), mass=1.0)
    can = GamePieceConfig(name="Can", shape=Cylinder(0.3, 0.8), mass=1.0)
    crate = GamePieceConfig(name="Crate", shape=Box((0.2, 0.4, 0.4)), mass=1.0)
    assert [c.rest_height for c in (ball, can, crate)] == pytest.approx([0.1, 0.4, 0.2])
    assert [c.bounding_radius for c in (ball, can, crate)] == pytest.approx([0.1, 0.5, 0.3])


@each(
    ("field", "value"),
    [
        ("name", ""),
        ("name", "a/b"),
        ("mass", -0.2),
        ("mass", 0.0),
        ("mass", math.nan),
        ("friction", -1.0),
        ("restitution", 1.5),
        ("rolling", -1.0),
    ],
)
def test_the_error_names_the_field_of_an_impossible_piece(field, value):
    with pytest.raises(ConfigError, match=field):
        GamePieceConfig(**{"name": "Fuel", "shape": Sphere(0.075), "mass": 0.2, field: value})


def test_the_error_for_a_ball_too_stiff_for_its_mass_gives_a_valid_stiffness():
    """The limit is 2.5e6 N/m per kg: 1e5 N/m need 40 g, and a ping-pong ball of 2.7 g allows 6,750 N/m."""
    with pytest.raises(ConfigError, match=r"at most 6.75e\+03 N/m can be simulated, or at least 0.04 kg"):
        GamePieceConfig(name="Ping", shape=Sphere(0.02), mass=0.0027, stiffness=1e5)
    GamePieceConfig(name="Ping", shape=Sphere(0.02), mass=0.0027, stiffness=6750.0)
    foam = FoamStiffness(linear=1e3, cubic=1e9)  # 170 kN/m at 7.5 mm
    with pytest.raises(ConfigError, match=r"a stiffness of 1.7e\+05 N/m"):
        GamePieceConfig(name="Rubber", shape=Sphere(0.075), mass=0.05, stiffness=foam)


def test_a_piece_without_a_stiffness_is_as_stiff_as_its_mass_allows():
    def stiffness(shape, mass):
        return GamePieceConfig(name="Piece", shape=shape, mass=mass).surface.stiffness

    assert stiffness(Sphere(0.02), 0.0027) == pytest.approx(6750.0)
    assert stiffness(Sphere(0.0214), 0.046) == 1e5
    assert stiffness(Box((0.1, 0.1, 0.1)), 0.0027) == 1e5, "a box is the engine's"
    light = replace(GamePieceConfig(name="Ball", shape=Sphere(0.02), mass=1.0), mass=0.0027)
    assert light.foam[0] == pytest.approx(6750.0)


OFF_CENTER = Compound((Part(Sphere(0.1)), Part(Sphere(0.1), (0.4, 0.0, 0.0))))


@each(
    ("shape", "words"),
    [
        (
            Mesh(np.eye(3), np.array([[0, 1, 2]])),
            "shape must be a Sphere, a Cylinder, a Box, a Hull or a Compound, got a Mesh",
        ),
        (Compound((Part(Sphere(0.1)),) * 40), "40 parts are too many to be simulated, at most 32"),
        (OFF_CENTER, r"its center of mass, which is at \(0.2, 0, 0\) m; give `centered\(shape\)`"),
        (tube(length=0.3, outer_radius=0.05, inner_radius=0.0475), "a part is 2.5 mm thick, engines need 3 mm"),
        (Hull(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]])), "one plane"),
    ],
)
def test_a_shape_that_engines_simulate_badly_is_refused(shape, words):
    with pytest.raises(ConfigError, match=words):
        GamePieceConfig(name="Thing", shape=shape, mass=1.0)
    assert GamePieceConfig(name="Thing", shape=centered(OFF_CENTER), mass=1.0).rest_height == pytest.approx(0.1)
