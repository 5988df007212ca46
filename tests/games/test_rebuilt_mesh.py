"""The committed 2026 field: what the script generates, symmetric, simple, and as the manual says."""

import importlib.util
import math
from pathlib import Path

import numpy as np
import pytest
import trimesh
from mesh_checks import is_free, points, span

from games.rebuilt import dimensions as dim
from games.rebuilt.field import FIELD
from simcore.physics.contact_law import POLYCARBONATE
from simcore.physics.field import FieldGeometry
from simcore.physics.obj import read_obj
from simcore.physics.shapes import Box, Hull
from simcore.units import inches

ROOT = Path(__file__).resolve().parents[2]
MODEL = ROOT / "models" / "rebuilt" / "field_collision.obj"


@pytest.fixture(scope="module")
def field():
    return FieldGeometry.load(MODEL)


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("generate", ROOT / "scripts" / "generate_rebuilt_field.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_committed_file_is_what_the_script_generates(script):
    assert MODEL.read_bytes() == script.generate().encode(), "run: python scripts/generate_rebuilt_field.py"


def test_nothing_needs_a_triangle_mesh(field):
    assert all(isinstance(element.shape, Box | Hull) for element in field.elements)
    assert len(field.elements) == len(read_obj(MODEL))  # one shape a group


def test_the_file_is_small():
    assert sum(len(group.triangles()) for group in read_obj(MODEL)) < 800


def test_every_group_is_closed_with_its_faces_outward():
    for group in read_obj(MODEL):
        mesh = trimesh.Trimesh(group.vertices, group.triangles())
        assert mesh.is_watertight and mesh.is_winding_consistent and mesh.volume > 0.0, group.name


def test_red_is_blue_turned_by_180_degrees(field):
    names = [e.name for e in field.elements]
    for element in field.elements:
        if element.name.startswith("guardrail"):
            other = "guardrail_left" if element.name.endswith("right") else "guardrail_right"
        else:
            other = element.name.replace("blue", "x").replace("red", "blue").replace("x", "red")
        assert other in names
        turned = points(field.element(other)) * [-1, -1, 1] + [dim.FIELD_LENGTH, dim.FIELD_WIDTH, 0.0]
        turned = turned[np.lexsort(np.round(turned, 5).T)]
        assert turned == pytest.approx(points(element), abs=2e-6), element.name
        assert type(field.element(other).shape) is type(element.shape)


def test_field_size_and_perimeter(field):
    assert span(field, "guardrail_right")[1] == pytest.approx((16.541, 0.0, inches(20)), abs=1e-6)
    assert span(field, "guardrail_left")[0][1] == pytest.approx(8.069, abs=1e-6)
    assert span(field, "blue_alliance_wall")[1][0] == pytest.approx(0.0, abs=1e-6)
    assert span(field, "red_alliance_wall")[0][0] == pytest.approx(16.541, abs=1e-6)
    low, high = field.bounds()
    assert low == pytest.approx((-0.3, -0.3, 0.0), abs=1e-6)
    assert high == pytest.approx((16.841, 8.369, dim.HUB_BACKBOARD_TOP), abs=1e-6)


def test_solid_parts_are_thick_enough_for_fast_balls(field):
    """At least 0.05 m, but for what is thinner on the field and lies on the floor or is a bar of the tower."""
    thin = ("tower_base", "tower_upright", "tower_brace", "tower_rung", "depot_barrier")
    for element in field.elements:
        if isinstance(element.shape, Box) and not any(word in element.name for word in thin):
            assert min(element.shape.size) >= 0.05, element.name


def test_hub_stands_where_the_manual_says(field):
    low, high = span(field, "blue_hub_base")
    assert low[0] == pytest.approx(inches(158.6), abs=1e-6)
    assert high[:2] - low[:2] == pytest.approx([inches(47)] * 2, abs=2e-6)
    assert (low + high)[1] / 2 == pytest.approx(dim.FIELD_WIDTH / 2, abs=1e-6)
    assert high[2] == pytest.approx(1.2)


def test_funnel_rim_and_throat(field):
    """Seen along the normal of each wedge: throat, rim and skirt at their distances and heights."""
    center = np.array([*dim.HUB_CENTER, 0.0])
    for i in range(6):
        angle = math.radians(60 * i)
        local = points(field.element(f"blue_hub_funnel_{i}")) - center
        distance = local[:, :2] @ [math.cos(angle), math.sin(angle)]
        section = {(round(float(r), 4), round(float(z), 4)) for r, z in zip(distance, local[:, 2], strict=True)}
        outer = dim.HUB_OPENING_APOTHEM + inches(1)
        expected = [
            (dim.HUB_THROAT_APOTHEM, 1.2),
            (dim.HUB_THROAT_APOTHEM, inches(56.5)),
            (inches(41.7) / 2, inches(72)),
            (outer, inches(71)),
            (outer, 1.2),
        ]
        assert section == {(round(r, 4), round(z, 4)) for r, z in expected}
    assert dim.HUB_THROAT_APOTHEM > 3 * 0.075


@pytest.mark.parametrize("alliance", ["blue", "red"])
def test_the_way_of_a_ball_is_free(field, alliance):
    """The square within the throat from above the hub down to the base, where the scoring zone is."""
    cx, cy = dim.HUB_CENTER if alliance == "blue" else FIELD.symmetry.flip_point(*dim.HUB_CENTER)
    half = dim.HUB_THROAT_CIRCUMRADIUS / 2
    assert is_free(field, (cx - half, cy - half, 1.2), (cx + half, cy + half, 3.0))
    assert not is_free(field, (cx - half, cy - half, 1.1), (cx + half, cy + half, 3.0))


def test_backboard_is_on_the_neutral_side(field):
    assert span(field, "blue_hub_backboard")[0][0] > dim.HUB_CENTER[0]
    assert span(field, "red_hub_backboard")[1][0] < dim.FIELD_LENGTH - dim.HUB_CENTER[0]
    assert span(field, "blue_hub_backboard")[1][2] == pytest.approx(3.0)


def test_bumps_fill_the_gap_between_hub_and_trench(field):
    hub, bump, leg = (span(field, f"blue_{name}") for name in ("hub_base", "bump_right", "trench_right_leg"))
    assert bump[1][1] == pytest.approx(hub[0][1], abs=2e-6)
    assert bump[0][1] == pytest.approx(leg[1][1], abs=2e-6)
    assert bump[1] - bump[0] == pytest.approx((inches(44.4), inches(73.0), inches(6.513)), abs=2e-6)
    ridge = points(field.element("blue_bump_right"))
    assert ridge[ridge[:, 2] > 0.01][:, 0] == pytest.approx([dim.BUMP_X] * 2, abs=1e-6)


@pytest.mark.parametrize("y", [0.0, dim.FIELD_WIDTH - dim.TRENCH_CLEAR_WIDTH])
@pytest.mark.parametrize("x", [dim.TRENCH_X, dim.FIELD_LENGTH - dim.TRENCH_X])
def test_portal_of_each_trench_is_free_and_no_larger(field, x, y):
    low, high = np.array([x - 1.0, y, 0.0]), np.array([x + 1.0, y + inches(50.34), inches(22.25)])
    shrink = np.array([0.0, 2e-6, 2e-6])
    assert is_free(field, low, high - shrink)
    assert not is_free(field, low, high + np.array([0.0, 0.0, 0.01]))  # the arm
    assert not is_free(field, low - np.array([0.0, 0.01, 0.0]), high)  # guardrail or leg
    assert not is_free(field, low, high + np.array([0.0, 0.01, 0.0]))


def test_trench_leg_is_what_other_sources_have():
    assert pytest.approx(inches(12.0), abs=1e-3) == dim.TRENCH_LEG_WIDTH
    middle = dim.TRENCH_CLEAR_WIDTH + dim.TRENCH_LEG_WIDTH / 2
    assert middle == pytest.approx(1.43113, abs=1e-3)  # MapleSim's trench wall


def test_tower(field):
    right, left = (span(field, f"blue_tower_upright_{side}") for side in ("right", "left"))
    assert left[0][1] - right[1][1] == pytest.approx(inches(32.25), abs=2e-6)
    assert right[1][2] == pytest.approx(inches(72.1), abs=1e-6)
    assert right[1][:2] - right[0][:2] == pytest.approx((inches(3.5), inches(1.5)), abs=2e-6)
    assert (right[0] + right[1])[:2] / 2 == pytest.approx((1.06204, 3.31524), abs=3e-3)  # MapleSim
    for name, height in (("low", 27), ("mid", 45), ("high", 63)):
        low, high = span(field, f"blue_tower_rung_{name}")
        assert (low + high)[2] / 2 == pytest.approx(inches(height), abs=1e-6)
        assert high[1] - left[1][1] == pytest.approx(inches(5.875), abs=2e-6)
    low, high = span(field, "blue_tower_base")
    assert high - low == pytest.approx((inches(45.18), inches(39.0), inches(0.25)), abs=2e-6)


def test_depot_holds_24_fuel_within_its_barriers(field):
    front, left, right = (span(field, f"blue_depot_barrier_{side}") for side in ("front", "left", "right"))
    assert left[1][1] - right[0][1] == pytest.approx(inches(42), abs=2e-6)
    assert front[1] == pytest.approx((inches(27), left[1][1], inches(1.125)), abs=2e-6)
    assert right[0][1] == pytest.approx(5.429, abs=2e-3)  # the reference's mesh
    assert left[0][1] - right[1][1] >= 6 * 0.15 and front[0][0] >= 4 * 0.15  # 4 x 6 balls of 0.15 m


def test_surfaces_go_by_the_names_of_groups():
    field = FieldGeometry.load(MODEL, surfaces={"*_hub_funnel_*": POLYCARBONATE, "guardrail_*": POLYCARBONATE})
    assert sum(element.surface is POLYCARBONATE for element in field.elements) == 2 * 6 + 2


def test_tags_of_the_official_layout_agree():
    """WPILib's AprilTags are on the faces of hub, trench and tower wall."""
    apriltag = pytest.importorskip("robotpy_apriltag")
    layout = apriltag.AprilTagFieldLayout.loadField(apriltag.AprilTagField.k2026RebuiltWelded)
    assert layout.getFieldLength() == pytest.approx(dim.FIELD_LENGTH)
    assert layout.getFieldWidth() == pytest.approx(dim.FIELD_WIDTH)
    tag = {i: layout.getTagPose(i).translation() for i in range(1, 33)}
    assert (tag[26].x + tag[20].x) / 2 == pytest.approx(dim.HUB_CENTER[0], abs=1e-3)
    assert tag[26].y == pytest.approx(dim.HUB_CENTER[1], abs=1e-3)
    assert (tag[17].x + tag[28].x) / 2 == pytest.approx(dim.TRENCH_X, abs=1e-3)
    assert tag[22].y == pytest.approx(dim.TRENCH_LEFT_Y, abs=0.01)
    assert tag[31].y == pytest.approx(dim.TOWER_Y, abs=1e-4)
    assert tag[29].y == pytest.approx(dim.OUTPOST_Y, abs=1e-3)
    assert FIELD.symmetry.flip_point(tag[26].x, tag[26].y) == pytest.approx((tag[10].x, tag[10].y), abs=1e-3)
