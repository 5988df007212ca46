"""Side on which an open surface gets its thickness when face winding is mixed or the two halves disagree."""

import math
import warnings

import numpy as np
import pytest
from each_case import each
from hypothesis import given, settings
from hypothesis import strategies as st

from games.rebuilt.game import REBUILT
from simcore.world.field import FieldGeometry
from simcore.world.mesh import decompose
from simcore.world.obj import ObjGroup, format_obj
from simcore.world.shapes import Box
from simcore.world.symmetry import FieldSymmetry

pytestmark = pytest.mark.engines("bullet")

LENGTH, WIDTH, T = 16.0, 8.0, 0.05
ROTATE, MIRROR = (FieldSymmetry(kind, (LENGTH, WIDTH)) for kind in ("rotate", "mirror"))
CX, CY = 4.0, 4.0


def plates_of(vertices, triangles):
    """Return the plates of an open surface, behind the side that most of its area faces."""
    return [plate for sheet in decompose(vertices, triangles) for plate in sheet.plates(0.05)]


def funnel(name="hub_funnel", *, outward=False):
    """Return six slopes from a throat of 0.3 m at 1.2 m up to an opening of 0.6 m at 1.8 m; the inside is free."""
    angle = np.arange(6) * math.tau / 6
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    low, high = (np.column_stack([r * ring + (CX, CY), np.full(6, z)]) for r, z in ((0.3, 1.2), (0.6, 1.8)))
    faces = tuple((i, 6 + i, 6 + (i + 1) % 6, (i + 1) % 6) for i in range(6))
    return ObjGroup(name, np.vstack([low, high]), reversed_faces(faces) if outward else faces)


def ramp(name="hub_ramp"):
    """Return a ramp from 0.8 m at the back down to the lower edge of the exit, 0.5 m; the upper side is free."""
    corners = [
        (CX - 0.5, CY - 0.5, 0.8),
        (CX + 0.5, CY - 0.5, 0.5),
        (CX + 0.5, CY + 0.5, 0.5),
        (CX - 0.5, CY + 0.5, 0.8),
    ]
    return ObjGroup(name, np.array(corners), ((0, 1, 2, 3),))


def panel(name="hub_side"):
    """Return an upright triangle next to the hub; the side toward -y is free."""
    return ObjGroup(name, np.array([(CX, 3.4, 1.2), (CX + 0.6, 3.4, 1.2), (CX + 0.6, 3.4, 3.0)]), ((0, 1, 2),))


def reversed_faces(faces):
    return tuple(face[::-1] for face in faces)


def flipped(group, symmetry=ROTATE, *, turned_round=False):
    """Return the image of a group on the other half; `turned_round` reverses its faces, as careless scripts do."""
    faces = group.faces if symmetry is ROTATE else reversed_faces(group.faces)
    faces = reversed_faces(faces) if turned_round else faces
    return ObjGroup(f"red_{group.name}", symmetry.flip_points(group.vertices), faces)


@pytest.fixture
def load(tmp_path):
    def write_and_load(*groups, symmetry=ROTATE):
        path = tmp_path / "field.obj"
        path.write_text(format_obj(groups))
        return FieldGeometry.load(path, symmetry=symmetry)

    return write_and_load


@pytest.fixture
def quietly(load):
    def without_warning(*groups, symmetry=ROTATE):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            return load(*groups, symmetry=symmetry)

    return without_warning


def corners(element):
    half = np.array(element.shape.size) / 2 if isinstance(element.shape, Box) else None
    if half is None:
        return element.shape.points + element.position
    return element.position + half * np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])


def points_of(field, group):
    return np.vstack([corners(e) for e in field.elements if e.name.partition(".")[0] == group])


def throat(field, group, symmetry=ROTATE):
    """Return the smallest distance of a funnel's plates from its axis: 0.3 m if they grew outward."""
    center = (CX, CY) if not group.startswith("red_") else symmetry.flip_point(CX, CY)
    return float(np.linalg.norm(points_of(field, group)[:, :2] - center, axis=1).min())


def is_image(field, symmetry=ROTATE):
    """Return whether the flipped corners of each element are the corners of some element."""
    clouds = [corners(e) for e in field.elements]

    def same(a, b):
        return len(a) == len(b) and np.linalg.norm(a[:, None] - b[None], axis=2).min(axis=1).max() < 1e-6

    return all(any(same(symmetry.flip_points(a), b) for b in clouds) for a in clouds)


# --- single groups ----------------------------------------------------------------------------------------------------


@settings(max_examples=50)
@given(st.integers(1, 2**12 - 2))
def test_triangles_of_mixed_winding_become_plates_on_the_side_of_the_larger_area(turned):
    """Any of twelve triangles may be reversed; the plates are those of uniform winding by the larger area."""
    group = funnel()
    triangles = group.triangles()
    mask = np.array([bool(turned >> i & 1) for i in range(12)])
    mixed = np.where(mask[:, None], triangles[:, ::-1], triangles)
    a, b, c = (group.vertices[triangles[:, i]] for i in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0
    more = areas[~mask].sum() - areas[mask].sum()
    got = plates_of(group.vertices, mixed)
    assert len(got) == 6
    if abs(more) < 1e-9:
        return  # a tie: all on either side
    want = plates_of(group.vertices, triangles if more > 0.0 else triangles[:, ::-1])
    for a, b in zip(got, want, strict=True):
        assert a.position == pytest.approx(b.position)
        assert np.sort(a.shape.points, axis=0) == pytest.approx(np.sort(b.shape.points, axis=0))


def test_two_triangles_of_opposite_winding_become_one_square_plate():
    square = np.array([[0.0, 0, 1], [2, 0, 1], [2, 3, 1], [0, 3, 1]])
    (part,) = plates_of(square, np.array([[0, 1, 2], [0, 3, 2]]))
    assert isinstance(part.shape, Box) and part.shape.size == pytest.approx((2.0, 3.0, T))


@each("turned", [{0}, {1, 2}, {0, 2, 4}, {0, 1, 2, 3}, {0, 1, 2, 3, 4}])
def test_a_lone_funnel_of_mixed_winding_opens_upward_with_a_warning(load, turned):
    group = funnel()
    mixed = ObjGroup(
        group.name, group.vertices, tuple(f[::-1] if i in turned else f for i, f in enumerate(group.faces))
    )
    with pytest.warns(UserWarning, match=r"\['hub_funnel'\] now face up.*wound both ways") as said:
        field = load(mixed, symmetry=None)
    assert len(said) == 1
    assert throat(field, "hub_funnel") == pytest.approx(0.3)


def test_an_upright_wall_of_mixed_winding_gives_a_warning(load):
    wall = ObjGroup("fence", np.array([(2.0, 1, 0), (2, 2, 0), (2, 4, 0), (2, 1, 1), (2, 2, 1), (2, 4, 1)]),
                    ((0, 1, 4, 3), (1, 4, 5, 2)))  # fmt: skip
    with pytest.warns(UserWarning, match=r"\['fence'\] now face where most"):
        field = load(wall, symmetry=None)
    low, high = field.bounds()
    assert (low[0], high[0]) == pytest.approx((2.0, 2.0 + T)), "the face of 2 m looks to -x"


def test_consistently_wound_surfaces_keep_the_side_in_the_file(quietly):
    """Without another half to compare with, a ceiling may face down and a funnel may be a dome."""
    field = quietly(funnel(outward=True), symmetry=None)
    assert throat(field, "hub_funnel") < 0.3


# --- two halves -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("symmetry", [ROTATE, MIRROR])
def test_two_field_halves_that_agree_give_no_warning(quietly, symmetry):
    groups = [funnel(), ramp(), panel()]
    field = quietly(*groups, *(flipped(group, symmetry) for group in groups), symmetry=symmetry)
    assert is_image(field, symmetry)
    assert throat(field, "hub_funnel") == pytest.approx(0.3)
    assert throat(field, "red_hub_funnel", symmetry) == pytest.approx(0.3)


@each("symmetry", [ROTATE, MIRROR])
@each("upside_down", [False, True])
def test_a_field_half_with_reversed_faces_is_corrected(load, symmetry, upside_down):
    """A ramp and a funnel face up on both halves, whichever half was wrong; upright panels follow the first half.

    Before, the red ramp grew 0.05 m up into an exit of 0.2 m, and balls of 0.15 m stuck there.
    """
    groups = [funnel(outward=upside_down), ramp(), panel()]
    others = [flipped(group, symmetry, turned_round=True) for group in groups]
    with pytest.warns(UserWarning, match=r"now face up.*now face as their image") as said:
        field = load(*groups, *others, symmetry=symmetry)
    assert len(said) == 1
    text = str(said[0].message)
    assert all(
        name in text for name in ("'hub_funnel', 'hub_ramp', 'red_hub_funnel', 'red_hub_ramp'", "['red_hub_side']")
    )
    assert is_image(field, symmetry)
    for name in ("hub_funnel", "red_hub_funnel"):
        assert throat(field, name, symmetry) == pytest.approx(0.3)
    for name in ("hub_ramp", "red_hub_ramp"):
        points = points_of(field, name)
        assert points[:, 2].max() == pytest.approx(0.8) and points[:, 2].min() < 0.5
    assert points_of(field, "hub_side")[:, 1].min() == pytest.approx(3.4)


@pytest.mark.parametrize("symmetry", [ROTATE, MIRROR])
def test_a_group_of_mixed_winding_faces_like_its_mirror_image(quietly, symmetry):
    """Most of the group's faces are reversed, but its image has uniform winding."""
    group = funnel()
    mixed = ObjGroup(group.name, group.vertices, tuple(f if i < 1 else f[::-1] for i, f in enumerate(group.faces)))
    for some in ([mixed, flipped(group, symmetry)], [flipped(group, symmetry), mixed]):
        field = quietly(*some, symmetry=symmetry)
        assert is_image(field, symmetry)
        assert throat(field, "hub_funnel") == pytest.approx(0.3)


def test_groups_without_a_mirror_image_give_a_warning(load):
    """One ramp has no image, another is 0.1 m away from its image."""
    aside = ObjGroup("red_hub_ramp", ROTATE.flip_points(ramp().vertices) + np.array([0.0, 0.1, 0.0]), ramp().faces)
    with pytest.warns(
        UserWarning, match=r"\['hub_ramp', 'red_hub_ramp', 'hub_side'\] have nothing in their place"
    ) as said:
        load(funnel(), flipped(funnel()), ramp(), aside, panel())
    assert len(said) == 1


def test_field_halves_that_are_split_into_different_faces_agree(quietly):
    """An L-shaped floor plate is two quads on one half, and two different quads on the other."""
    outline = np.array([(1.0, 1, 1), (3, 1, 1), (3, 2, 1), (2, 2, 1), (2, 3, 1), (1, 3, 1), (1, 2, 1), (2, 1, 1)])
    one = ObjGroup("ledge", outline, ((0, 7, 1, 2, 3, 6), (6, 3, 4, 5)))
    two = ObjGroup("red_ledge", ROTATE.flip_points(outline), ((0, 7, 3, 4, 5, 6), (7, 1, 2, 3)))
    quietly(one, two)


def test_the_two_sides_of_a_wall_on_the_center_line_are_mirror_images(quietly):
    """The wall is two back-to-back sheets on the field's middle line, each with separate vertices."""
    square = np.array([(8.0, 3, 0), (8, 5, 0), (8, 5, 1), (8, 3, 1)])
    quietly(ObjGroup("divider_a", square, ((0, 1, 2, 3),)), ObjGroup("divider_b", square, ((3, 2, 1, 0),)))


def test_the_field_of_rebuilt_gives_no_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        REBUILT.field.load()
