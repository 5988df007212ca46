"""Field geometry: surfaces by name, boundary, outlines, and meshes that cannot be a field."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from each_case import each

from simcore.errors import ConfigError, FieldMeshError, UnknownNameError
from simcore.world.contact_law import CARPET, POLYCARBONATE, RUBBER, WALL
from simcore.world.field import FieldBoundary, FieldElement, FieldGeometry
from simcore.world.obj import ObjGroup, format_obj
from simcore.world.shapes import Box, Compound, Cylinder, Hull, Mesh, Part, Sphere
from simcore.world.symmetry import FieldSymmetry


def group(name, mesh, shift=(0.0, 0.0, 0.0)):
    return ObjGroup(name, np.asarray(mesh.vertices) + shift, tuple(tuple(f) for f in np.asarray(mesh.faces).tolist()))


@pytest.fixture
def save(tmp_path):
    def write(*groups):
        path = tmp_path / "field.obj"
        path.write_text(format_obj(groups))
        return path

    return write


@pytest.fixture
def path(save):
    box = trimesh.creation.box()
    pair = trimesh.util.concatenate([box, box.copy().apply_translation((3.0, 0.0, 0.0))])
    return save(group("hub_base", box), group("hub_funnel", box, (0, 2, 0)), group("posts", pair, (0, 5, 0)))


def test_the_groups_of_a_mesh_become_named_elements(path):
    field = FieldGeometry.load(path)
    assert [e.name for e in field.elements] == ["hub_base", "hub_funnel", "posts.0", "posts.1"]
    assert field.element("posts.1").position == pytest.approx((3.0, 5.0, 0.0))
    assert {e.surface for e in field.elements} == {WALL}


def test_surfaces_match_by_pattern_and_the_last_match_wins(path):
    field = FieldGeometry.load(
        path, surfaces={"hub_*": RUBBER, "*_funnel*": POLYCARBONATE, "posts": CARPET}, default_surface=WALL
    )
    assert [e.surface for e in field.elements] == [RUBBER, POLYCARBONATE, CARPET, CARPET]


def test_the_error_for_a_pattern_without_a_match_lists_the_groups(path):
    with pytest.raises(UnknownNameError, match=r"hub_funel.*Did you mean 'hub_funnel'.*posts"):
        FieldGeometry.load(path, surfaces={"hub_funel": RUBBER})


def test_the_error_for_an_unknown_element_suggests_the_nearest_name(path):
    with pytest.raises(UnknownNameError, match="hub_base"):
        FieldGeometry.load(path).element("hub_bas")


def test_the_boundary_walls_are_outside_the_field(path):
    boundary = FieldBoundary(length=16.0, width=8.0, side_height=0.5, end_height=2.0)
    field = FieldGeometry.load(path, boundary=boundary, surfaces={"boundary_left": RUBBER})
    walls = {e.name: e for e in field.elements if e.name.startswith("boundary")}
    faces = {
        name: (wall.position - np.array(wall.shape.size) / 2, wall.position + np.array(wall.shape.size) / 2)
        for name, wall in walls.items()
    }
    assert faces["boundary_right"][1][1] == pytest.approx(0.0)
    assert faces["boundary_left"][0][1] == pytest.approx(8.0)
    assert faces["boundary_blue"][1][0] == pytest.approx(0.0)
    assert faces["boundary_red"][0][0] == pytest.approx(16.0)
    assert faces["boundary_blue"][0][1] == pytest.approx(-0.3)  # corners are closed
    assert faces["boundary_red"][1] == pytest.approx((16.3, 8.3, 2.0))
    assert all(low[2] == pytest.approx(0.0) for low, _ in faces.values())
    assert walls["boundary_left"].surface is RUBBER and walls["boundary_right"].surface is WALL


@each("name", ["length", "width", "side_height", "end_height", "thickness"])
@each("value", [0.0, -1.0, float("nan"), float("inf")])
def test_an_invalid_boundary_is_refused(name, value):
    good = FieldBoundary(length=16.0, width=8.0, side_height=0.5, end_height=2.0)
    with pytest.raises(ConfigError, match=name):
        replace(good, **{name: value})


@pytest.mark.parametrize("scale", [1000.0, 39.37])
def test_the_error_for_a_field_in_other_units_gives_the_likely_reason(save, scale):
    floor = trimesh.creation.box(extents=(16.5 * scale, 8.0 * scale, 1.0))
    with pytest.raises(FieldMeshError, match=r"in (millimeters \(scale it by 0\.001|inches \(scale it by 0\.0254)"):
        FieldGeometry.load(save(group("floor", floor)))


@each(
    ("place", "said"),
    [
        (lambda p: p / 0.3048, r"in feet \(scale it by 0\.3048\)$"),
        (lambda p: p - (8.0, 4.0, 0.0), r"It is about its middle \(move it by 8, 4 m\)$"),
        (lambda p: p[:, (0, 2, 1)] * (1, 1, -1), r"It is with y up \(export it with z up\)$"),
        (lambda p: (p - (8.0, 4.0, 0.0))[:, (0, 2, 1)] * (1, 1, -1) / 0.0254, "in inches .* with y up .* its middle"),
    ],
)
def test_the_error_names_the_export_mistake_if_the_field_size_is_known(save, place, said):
    box = trimesh.creation.box(extents=(16.0, 8.0, 0.2))
    box.vertices = place(np.asarray(box.vertices) + np.array((8.0, 4.0, 0.1)))
    with pytest.raises(FieldMeshError, match=said):
        FieldGeometry.load(save(group("floor", box)), symmetry=FieldSymmetry("rotate", (16.0, 8.0)))


def test_a_field_far_from_the_origin_is_refused(save):
    with pytest.raises(FieldMeshError, match="from the origin"):
        FieldGeometry.load(save(group("box", trimesh.creation.box(), (500.0, 0.0, 0.0))))


def test_a_mesh_without_area_is_refused(save):
    line = ObjGroup("line", np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), ((0, 1, 2),))
    with pytest.raises(FieldMeshError, match="none of its faces has an area"):
        FieldGeometry.load(save(line))


def test_a_missing_file_raises_a_field_mesh_error(tmp_path):
    with pytest.raises(FieldMeshError, match="nowhere"):
        FieldGeometry.load(tmp_path / "nowhere.obj")


def test_many_triangles_give_a_warning_that_names_the_script(save):
    ball = group("ball", trimesh.creation.icosphere(subdivisions=2))  # 320 triangles
    with pytest.warns(UserWarning, match=r"320 triangles.*scripts/simplify_field\.py"):
        FieldGeometry.load(save(ball), max_triangles=100)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        FieldGeometry.load(save(ball), max_triangles=320)


def test_far_too_many_triangles_raise_an_error(save):
    ball = group("ball", trimesh.creation.icosphere(subdivisions=2))
    with pytest.raises(FieldMeshError, match="simplify_field"):
        FieldGeometry.load(save(ball), max_triangles=15)


@pytest.mark.parametrize("count", [0, -1])
def test_the_triangle_limit_must_be_positive(path, count):
    with pytest.raises(ConfigError, match="max_triangles"):
        FieldGeometry.load(path, max_triangles=count)


def test_groups_that_remain_meshes_are_logged(save, caplog):
    ring = trimesh.creation.annulus(r_min=0.5, r_max=1.0, height=0.2)
    field = FieldGeometry.load(save(group("ring", ring)))
    assert isinstance(field.elements[0].shape, Mesh)
    assert "'ring' stays a triangle mesh" in caplog.text


@each(
    ("shape", "area"),
    [
        (Box((2.0, 3.0, 1.0)), 6.0),
        (Hull(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])), 0.5),
        (Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]])), 0.5),
        (Sphere(1.0), np.pi),
        (Cylinder(1.0, 5.0), np.pi),
        (Compound((Part(Box((1.0, 1.0, 1.0))), Part(Box((1.0, 1.0, 1.0)), (1.0, 0.0, 0.0)))), 2.0),
    ],
)
def test_an_outline_has_the_area_of_the_shape_seen_from_above(shape, area):
    element = FieldElement(name="x", shape=shape, position=np.array([5.0, 6.0, 7.0]))
    x, y = element.outline().T
    signed = np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2
    assert signed == pytest.approx(area, rel=0.02)  # above zero: counter-clockwise
    (name, outline) = FieldGeometry((element,)).outlines()[0]
    assert name == "x" and outline == pytest.approx(element.outline())


def test_the_outline_of_an_upright_triangle_is_a_line():
    shape = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 0, 1]]), np.array([[0, 1, 2]]))
    outline = FieldElement(name="x", shape=shape, position=np.zeros(3)).outline()
    assert outline == pytest.approx(np.array([[0.0, 0.0], [1.0, 0.0]]))


def test_two_elements_with_the_same_name_are_refused():
    element = FieldElement(name="wall", shape=Sphere(1.0), position=np.zeros(3))
    with pytest.raises(ConfigError, match="wall"):
        FieldGeometry((element, element))


@pytest.mark.parametrize("position", [(0.0, 0.0), (0.0, 0.0, float("nan"))])
def test_a_position_must_be_three_finite_numbers(position):
    with pytest.raises(ConfigError, match="position"):
        FieldElement(name="x", shape=Sphere(1.0), position=np.array(position))


def test_the_position_of_an_element_is_a_read_only_copy():
    given = np.zeros(3)
    element = FieldElement(name="x", shape=Sphere(1.0), position=given)
    given[0] = 1.0
    assert element.position[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        element.position[0] = 1.0


def test_the_bounds_contain_every_element(path):
    low, high = FieldGeometry.load(path).bounds()
    assert low == pytest.approx((-0.5, -0.5, -0.5))
    assert high == pytest.approx((3.5, 5.5, 0.5))


def test_a_field_that_was_scaled_twice_is_refused(tmp_path):
    mesh = tmp_path / "tiny.obj"
    mesh.write_text("o a\nv 0 0 0\nv 0.01 0 0\nv 0 0.01 0\nv 0 0 0.01\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
    with pytest.raises(FieldMeshError, match=r"only 0\.01 m long"):
        FieldGeometry.load(mesh)
