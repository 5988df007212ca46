"""Shapes that groups of triangles become, and the OBJ reader with good and bad files."""

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from simcore.errors import ConfigError, FieldMeshError
from simcore.world.field import FieldGeometry
from simcore.world.mesh import Sheet, decompose
from simcore.world.obj import ObjGroup, format_obj, read_obj, triangulate
from simcore.world.shapes import Box, Hull, Mesh

SQUARE = np.array([[0.0, 0, 1], [2, 0, 1], [2, 3, 1], [0, 3, 1]])
TWO = np.array([[0, 1, 2], [0, 2, 3]])


def classify(vertices, triangles, *, plate_thickness=0.05):
    """Return the shapes for some triangles; an open surface becomes plates behind the side that its winding faces."""
    pieces = decompose(vertices, triangles)
    return tuple(part for p in pieces for part in (p.plates(plate_thickness) if isinstance(p, Sheet) else [p]))


def parts_of(mesh, **kwargs):
    return classify(np.asarray(mesh.vertices), np.asarray(mesh.faces), **kwargs)


def top_of(part):
    return part.position[2] + (part.shape.size[2] / 2 if isinstance(part.shape, Box) else part.shape.points[:, 2].max())


def test_an_axis_aligned_box_becomes_a_box():
    mesh = trimesh.creation.box(extents=(1.0, 2.0, 0.5))
    mesh.apply_translation((3.0, 4.0, 5.0))
    (part,) = parts_of(mesh)
    assert isinstance(part.shape, Box)
    assert part.shape.size == pytest.approx((1.0, 2.0, 0.5))
    assert part.position == pytest.approx((3.0, 4.0, 5.0))


def test_a_finely_triangulated_box_with_unshared_vertices_is_still_a_box():
    mesh = trimesh.creation.box().subdivide().subdivide()
    vertices = mesh.triangles.reshape(-1, 3)
    (part,) = classify(vertices, np.arange(len(vertices)).reshape(-1, 3))
    assert isinstance(part.shape, Box)


@given(st.integers(0, 2**12 - 1))
def test_a_box_is_recognized_whatever_the_winding_of_its_faces(flips):
    mesh = trimesh.creation.box()
    faces = np.array([f[::-1] if flips >> i & 1 else f for i, f in enumerate(mesh.faces)])
    (part,) = classify(np.asarray(mesh.vertices), faces)
    assert isinstance(part.shape, Box)


def test_a_rotated_box_becomes_a_hull_of_its_corners():
    mesh = trimesh.creation.box()
    mesh.apply_transform(trimesh.transformations.rotation_matrix(0.3, (0, 0, 1)))
    (part,) = parts_of(mesh)
    assert isinstance(part.shape, Hull)
    assert len(part.shape.points) == 8


def test_a_closed_body_with_a_dent_is_a_mesh():
    ring = trimesh.creation.annulus(r_min=0.5, r_max=1.0, height=0.2)
    (part,) = parts_of(ring)
    assert isinstance(part.shape, Mesh)
    assert type(part.shape.vertices) is type(part.position) is np.ndarray
    back = part.shape.vertices + part.position
    assert trimesh.Trimesh(back, part.shape.faces).volume == pytest.approx(ring.volume)


def test_two_boxes_in_a_group_are_separated():
    a, b = trimesh.creation.box(), trimesh.creation.box()
    b.apply_translation((3.0, 0.0, 0.0))
    assert [type(p.shape) for p in parts_of(trimesh.util.concatenate(a, b))] == [Box, Box]


def test_touching_boxes_are_separated_if_they_have_their_own_vertices():
    a, b = trimesh.creation.box(), trimesh.creation.box(extents=(1.0, 1.0, 2.0))
    b.apply_translation((1.0, 0.0, 0.5))
    parts = classify(np.vstack([a.vertices, b.vertices]), np.vstack([a.faces, np.asarray(b.faces) + 8]))
    assert [type(p.shape) for p in parts] == [Box, Box]


def test_an_open_square_becomes_a_plate_behind_its_normal():
    (part,) = classify(SQUARE, TWO, plate_thickness=0.05)
    assert isinstance(part.shape, Box)
    assert part.shape.size == pytest.approx((2.0, 3.0, 0.05))
    assert top_of(part) == pytest.approx(1.0)  # the normal points up, so the plate extends downward


def test_a_flipped_square_becomes_a_plate_on_the_other_side():
    (part,) = classify(SQUARE, TWO[:, ::-1], plate_thickness=0.05)
    assert top_of(part) == pytest.approx(1.05)


def test_a_finely_triangulated_flat_sheet_becomes_a_single_plate():
    vertices, faces = trimesh.remesh.subdivide(SQUARE, TWO)
    vertices, faces = trimesh.remesh.subdivide(vertices, faces)
    assert len(faces) == 32
    (part,) = classify(vertices, faces)
    assert isinstance(part.shape, Box)


def test_an_l_shaped_sheet_becomes_two_or_three_plates_that_cover_it():
    outline = np.array([[0.0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [1, 2, 0], [0, 2, 0]])
    faces = np.array(triangulate(outline, tuple(range(6))))
    parts = classify(outline, faces)
    assert 2 <= len(parts) <= 3
    volume = sum(trimesh.convex.convex_hull(_points(part)).volume for part in parts)
    assert volume == pytest.approx(3.0 * 0.05)


def test_an_open_funnel_becomes_a_plate_for_each_side_and_stays_free_inside():
    angle = np.arange(6) * np.pi / 3
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    vertices = np.vstack([np.column_stack([0.3 * ring, np.zeros(6)]), np.column_stack([0.6 * ring, np.full(6, 0.4)])])
    quads = [(i, 6 + i, 6 + (i + 1) % 6, (i + 1) % 6) for i in range(6)]  # normals toward the axis
    group = ObjGroup("funnel", vertices, tuple(quads))
    parts = classify(vertices, group.triangles())
    assert len(parts) == 6 and all(isinstance(p.shape, Hull) for p in parts)
    assert min(np.abs(_points(part)[:, :2] @ ring.T).max() for part in parts) > 0.3
    for part in parts:  # nothing is within the throat
        assert np.linalg.norm(_points(part)[:, :2], axis=1).min() >= 0.3 * np.cos(np.pi / 6) - 1e-9


def test_a_curved_open_surface_stays_a_mesh():
    ball = trimesh.creation.icosphere(subdivisions=3)
    lower = ball.triangles_center[:, 2] < 0.0
    (part,) = classify(np.asarray(ball.vertices), np.asarray(ball.faces)[lower])
    assert isinstance(part.shape, Mesh)


def test_a_mesh_of_slivers_alone_produces_no_shape():
    assert classify(np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), np.array([[0, 1, 2]])) == ()


def test_the_plate_thickness_must_be_positive():
    with pytest.raises(ConfigError, match="plate_thickness"):
        FieldGeometry.load("field.obj", plate_thickness=0.0)


def _points(part):
    if isinstance(part.shape, Hull):
        return part.shape.points + part.position
    half = np.array(part.shape.size) / 2
    return part.position + half * np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])


# --- OBJ --------------------------------------------------------------------------------------------------------------

MIXED = """\
# groups that differ in name, material and corner count
mtllib none.mtl
o slab
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
usemtl a
f 1/1/1 2/2/1 3/3/1
usemtl b
f 1//1 3//1 4//1
g post left
v 5 0 0
v 6 0 0
v 6 1 0
v 5.5 2 0
v 5 1 0
f -5 -4 -3 -2 -1
o slab
f 1 2 3 4
"""


def write(tmp_path, text, name="field.obj"):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def test_groups_keep_their_names_for_any_materials_and_face_corners(tmp_path):
    groups = read_obj(write(tmp_path, MIXED))
    assert [(g.name, len(g.vertices), len(g.triangles())) for g in groups] == [("slab", 4, 4), ("post_left", 5, 3)]


def test_a_written_file_can_be_read_again(tmp_path):
    groups = read_obj(write(tmp_path, MIXED))
    again = read_obj(write(tmp_path, format_obj(groups, header="two lines\nof header"), "again.obj"))
    for a, b in zip(groups, again, strict=True):
        assert (a.name, a.faces) == (b.name, b.faces)
        assert a.vertices == pytest.approx(b.vertices, abs=1e-6)


def test_the_triangles_of_a_concave_polygon_lie_within_its_outline():
    arrow = np.array([[0.0, 0, 0], [2, 2, 0], [0, 1, 0], [-2, 2, 0]])
    for turn in range(4):
        face = tuple(np.roll(range(4), turn).tolist())
        area = sum(np.cross(arrow[b] - arrow[a], arrow[c] - arrow[a])[2] / 2 for a, b, c in triangulate(arrow, face))
        assert area == pytest.approx(2.0)
        assert all(np.cross(arrow[b] - arrow[a], arrow[c] - arrow[a])[2] > 0 for a, b, c in triangulate(arrow, face))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no faces"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", "3 vertices and no faces"),
        ("v 0 0 0\nv 1 0\n", "line 2: a vertex needs 3 numbers"),
        ("v 0 0 nan\n", "line 1: a vertex must have finite"),
        ("v 0 0 1e999\n", "line 1: a vertex must have finite"),
        ("v 0 0 zero\n", "line 1"),
        ("v 0 0 0\nv 1 0 0\nf 1 2 3\n", "line 3: vertex 3 does not exist"),
        ("v 0 0 0\nf 0 1 1\n", "line 2: vertex 0"),
        ("v 0 0 0\nv 1 0 0\nf 1 2 2\n", "3 different vertices"),
        ("<html>not found</html>\n", "unknown statement"),
        (b"glTF\x02\0\0\0", "binary"),
    ],
)
def test_the_error_names_the_invalid_line_of_a_mesh_file(tmp_path, text, message):
    with pytest.raises(FieldMeshError, match=message):
        read_obj(write(tmp_path, text))


def test_a_missing_file_and_a_directory_are_reported(tmp_path):
    with pytest.raises(FieldMeshError, match="No such file"):
        read_obj(tmp_path / "nowhere.obj")
    with pytest.raises(FieldMeshError, match="cannot read"):
        read_obj(tmp_path)
