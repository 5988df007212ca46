"""Shapes in game tables: hulls and slopes on both halves, hollow cones on poles, and pieces staged inside elements."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from simcore.errors import ConfigError
from simcore.match.game import Game, PieceSupply, StagedPieces, for_both_alliances
from simcore.match.match import Match
from simcore.pieces.kinds import GamePieceConfig
from simcore.units import inches
from simcore.world.field import FieldElement, box_element, slope_element
from simcore.world.shapes import Box, Cylinder, Mesh, Sphere, hollow_cone, mass_properties, parts_of
from simcore.world.symmetry import FieldSymmetry

SIZE = (16.0, 8.0)
CONE = GamePieceConfig(
    name="Cone",
    shape=hollow_cone(
        height=inches(12.81), bottom_radius=inches(3.3), top_radius=inches(0.9), wall=inches(0.25), foot=inches(8.375)
    ),
    mass=0.65,
    friction=0.6,
    restitution=0.2,
)
BALL = GamePieceConfig(name="Ball", shape=Sphere(0.1), mass=0.25)


def corners(element):
    """Return the corners of a hull, field frame, sorted."""
    points = np.round(element.shape.points + element.position, 9)
    return points[np.lexsort(points.T)].tolist()


@pytest.mark.parametrize("kind", ["rotate", "mirror"])
@pytest.mark.parametrize("toward", ["+x", "-x", "+y", "-y"])
def test_slopes_are_flipped_to_the_other_half(kind, toward):
    symmetry = FieldSymmetry(kind, SIZE)
    blue, red = for_both_alliances([slope_element("ramp", (2.0, 1.0, 0.0), (3.0, 3.0, 0.2), toward)], symmetry)
    assert (blue.name, red.name) == ("blue_ramp", "red_ramp")
    flipped = replace(red, shape=replace(red.shape, points=symmetry.flip_vectors(red.shape.points)))
    flipped = replace(flipped, position=symmetry.flip_points(red.position[None])[0])
    assert corners(flipped) == corners(blue) and mass_properties(red.shape).volume == pytest.approx(0.2)
    axis, edge = "xy".index(toward[1]), 1 if toward[0] == "+" else 0
    top = [point for point in corners(blue) if point[2] == pytest.approx(0.2)]
    assert len(top) == 2 and {point[axis] for point in top} == {((2.0, 3.0), (1.0, 3.0))[axis][edge]}


def test_shapes_that_cannot_be_flipped_and_invalid_slopes_are_refused():
    mesh = Mesh(np.eye(3), np.array([[0, 1, 2]]))
    with pytest.raises(ConfigError, match="boxes, cylinders, balls and hulls can be put on both sides, got a Mesh"):
        for_both_alliances([FieldElement(name="net", shape=mesh, position=np.zeros(3))], FieldSymmetry("rotate", SIZE))
    with pytest.raises(ConfigError, match=r"ramp: a slope rises toward '\+x', .* got 'up'"):
        slope_element("ramp", (2.0, 1.0, 0.0), (3.0, 3.0, 0.2), "up")


def test_a_hollow_cone_sits_on_a_pole():
    """The inside of the cone's top rests on the top of the pole."""
    pole = FieldElement(name="pole", shape=Cylinder(0.012, 0.8), position=np.array([4.0, 4.0, 0.4]))
    game = replace(Game.bare(elements=(pole,), pieces=(PieceSupply(CONE, 1),)), starts=((8.0, 4.0, 0.0),))
    low = min(part.offset[2] for part in parts_of(CONE.shape) if isinstance(part.shape, Box)) - inches(0.125)
    top = inches(12.81) + low - inches(0.25)  # top of the hollow, above the center
    with Match(game) as match:
        (slot,) = match.pieces.spawn("Cone", np.array([[4.0, 4.0, 0.8 - top + 0.01]]))
        match.play(3.0)
        x, y, z = match.pieces.state.pos[slot]
        assert (x, y) == pytest.approx((4.0, 4.0), abs=0.02) and z == pytest.approx(0.8 - top, abs=0.01)


def test_an_invalid_hollow_cone_is_refused():
    sizes = dict(height=0.3, bottom_radius=0.1, top_radius=0.02)
    with pytest.raises(ConfigError, match="wall must be below both radii"):
        hollow_cone(**sizes, wall=0.03)
    with pytest.raises(ConfigError, match="foot must be wider than the opening"):
        hollow_cone(**sizes, wall=0.01, foot=0.1)


@pytest.mark.parametrize(
    ("kind", "place", "said"),
    [
        (BALL, (3.0, 3.0, 0.2), r"Ball 0 is staged inside of shelf: \(3.000, 3.000, 0.200\) m is \d+ mm deep in it"),
        (CONE, (3.0, 3.0, 0.35), r"Cone 0 is staged inside of shelf: .* mm deep in it; positions are of a piece's cen"),
        (BALL, (5.0, 5.0, 0.0), r"Ball 0 is staged inside of the floor: \(5.000, 5.000, 0.000\) m is 100 mm deep"),
        (CONE, (5.0, 5.0, 0.0), r"Cone 0 is staged inside of the floor"),
        (BALL, (3.0, 3.0, 0.51), None),
        (CONE, (3.0, 3.0, 0.55), None),
    ],
)
def test_pieces_staged_inside_an_element_are_refused(kind, place, said):
    shelf = box_element("shelf", (2.5, 2.5, 0.0), (3.5, 3.5, 0.4))
    game = replace(
        Game.bare(elements=(shelf,), pieces=(PieceSupply(kind, 1),)),
        staging=lambda rng, entries: [StagedPieces(kind=kind.name, positions=np.array([place]))],
        starts=((8.0, 4.0, 0.0),),
    )
    if said is None:
        Match(game).close()
        return
    with pytest.raises(ConfigError, match=said):
        Match(game)
