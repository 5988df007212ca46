"""The committed 2025 field: what the script generates, symmetric, convex, and with the published figures."""

import importlib.util
import math
from pathlib import Path

import numpy as np
import pytest
import trimesh
from mesh_checks import is_free, points, span

from games.reefscape import dimensions as dim
from games.reefscape.field import FIELD
from games.reefscape.places import branch_ends
from games.reefscape.staging import mark_places, reef_algae_places
from simcore.physics.obj import read_obj
from simcore.physics.shapes import Box, Hull
from simcore.units import inches

ROOT = Path(__file__).resolve().parents[2]
MODEL = ROOT / "models" / "reefscape" / "field_collision.obj"


@pytest.fixture(scope="module")
def field():
    return FIELD.load()


def test_committed_file_is_what_the_script_generates():
    spec = importlib.util.spec_from_file_location("generate", ROOT / "scripts" / "generate_reefscape_field.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    assert MODEL.read_bytes() == script.generate().encode(), "run: python scripts/generate_reefscape_field.py"


def test_every_group_is_one_closed_convex_body(field):
    groups = read_obj(MODEL)
    assert all(isinstance(element.shape, Box | Hull) for element in field.elements)
    assert len(field.elements) == len(groups)
    assert sum(len(group.triangles()) for group in groups) < 5000
    for group in groups:
        mesh = trimesh.Trimesh(group.vertices, group.triangles())
        assert mesh.is_watertight and mesh.is_winding_consistent and mesh.volume > 0.0, group.name


def test_red_is_blue_turned_by_180_degrees(field):
    for element in field.elements:
        other = element.name.replace("blue", "x").replace("red", "blue").replace("x", "red")
        turned = points(field.element(other)) * [-1, -1, 1] + [dim.FIELD_LENGTH, dim.FIELD_WIDTH, 0.0]
        turned = turned[np.lexsort(np.round(turned, 5).T)]
        assert turned == pytest.approx(points(element), abs=3e-6), element.name


def test_walls_are_where_the_field_ends(field):
    assert span(field, "blue_alliance_wall")[1][0] == pytest.approx(0.0, abs=1e-6)
    assert span(field, "red_alliance_wall")[0][0] == pytest.approx(17.548, abs=1e-6)
    assert span(field, "blue_guardrail_far")[1][1:] == pytest.approx((0.0, inches(20)), abs=1e-6)
    assert span(field, "red_guardrail_far")[0][1] == pytest.approx(8.052, abs=1e-6)


def test_reef_faces_and_trough(field):
    """Faces at 144 in and 5.3210 m; the edge of the trough is 18 in high, its floor 0.14 m lower at the inner wall."""
    assert span(field, "blue_reef_trough_0")[0][0] == pytest.approx(inches(144), abs=2e-4)
    assert span(field, "blue_reef_trough_3")[1][0] == pytest.approx(5.3210, abs=3e-4)
    corners = points(field.element("blue_reef_trough_3"))
    edge = corners[np.abs(corners[:, 0] - corners[:, 0].max()) < 1e-5]
    assert np.ptp(edge[:, 1]) == pytest.approx(inches(37.82), abs=1e-3)
    assert edge[:, 2].max() == pytest.approx(inches(18), abs=1e-6)
    assert corners[corners[:, 0] < edge[:, 0].max() - 0.1][:, 2].max() == pytest.approx(0.3172, abs=1e-4)


@pytest.mark.parametrize(("level", "height"), [(2, 0.7966), (3, 1.1967), (4, 1.8288)])
def test_branch_tips(field, level, height):
    """In the table of 6328: 30.738 in out from the center and 6.469 in to both sides of each face's middle."""
    ends = {number: np.array(branch_ends(number, level)) for number in range(12)}
    for number, yaw_deg in ((0, 180), (1, 180), (2, 240), (7, 0), (11, 120)):
        yaw, side = math.radians(yaw_deg), -1.0 if number % 2 == 0 else 1.0
        c, s, out, aside = math.cos(yaw), math.sin(yaw), 0.7807, side * 0.1643
        want = (4.4893 + out * c - aside * s, 4.0259 + out * s + aside * c, height)
        assert ends[number][1] == pytest.approx(want, abs=3e-4)
    element = points(field.element(f"blue_reef_branch_l{level}_0_left"))
    ring = element[np.argsort(np.linalg.norm(element - ends[0][1], axis=1))[:8]]
    assert ring.mean(axis=0) == pytest.approx(ends[0][1], abs=1e-5)
    assert np.linalg.norm(ring - ends[0][1], axis=1) == pytest.approx(0.02222, abs=2e-5)  # area of the round pipe
    way = ends[0][1] - ends[0][0]
    slope = math.degrees(math.atan2(way[2], math.hypot(way[0], way[1])))
    assert slope == pytest.approx(90.0 if level == 4 else 35.0, abs=1e-6)


def test_stations(field):
    """Tag 12 is in the middle of the face; the opening is 76 x 7 in with its bottom at 37.5 in."""
    normal = np.array([math.cos(math.radians(54)), math.sin(math.radians(54)), 0.0])
    along = np.array([-normal[1], normal[0], 0.0])
    face = np.array([0.851154, 0.65532, 0.0])
    lip, roof = (points(field.element(f"blue_station_right_{name}")) - face for name in ("lip", "roof"))
    front = lip[lip @ normal > -1e-5]
    assert front[:, 2].max() == pytest.approx(inches(37.5), abs=1e-5)
    assert np.ptp(front @ along) == pytest.approx(inches(76), abs=1e-5)
    assert roof[roof @ normal > -1e-5][:, 2].min() == pytest.approx(inches(44.5), abs=1e-5)
    assert (lip @ normal).max() == pytest.approx(0.0, abs=1e-5)
    left = points(field.element("blue_station_left_lip"))
    assert left[:, 1].min() == pytest.approx(8.052 - (lip + face)[:, 1].max(), abs=1e-5)


def test_processor_and_net(field):
    low = (dim.PROCESSOR_X - inches(14), -0.3, inches(7))
    high = (dim.PROCESSOR_X + inches(14), 0.1, inches(27))
    shrink = np.array([2e-6, 0.0, 2e-6])
    assert is_free(field, low + shrink, high - shrink)
    for grow in ((0.01, 0.0, 0.0), (0.0, 0.0, 0.01)):
        assert not is_free(field, low, np.add(high, grow))
        assert not is_free(field, np.subtract(low, grow), high)
    assert span(field, "blue_net_near")[1][2] == pytest.approx(inches(88), abs=1e-6)
    assert span(field, "blue_net_floor")[1][2] == pytest.approx(inches(76), abs=1e-6)
    assert span(field, "blue_net_near")[0][1] > dim.FIELD_WIDTH / 2 > span(field, "red_net_near")[1][1]


def test_what_must_be_free_is_free(field):
    """Starts, marks, the way under the barge between post and guardrail, and the insides of the nets."""
    assert is_free(field, (5.4, 0.0, 0.0), (12.1, 3.8, inches(62) - 1e-5))
    for x, y in mark_places():
        assert is_free(field, (x - 0.25, y - 0.25, 0.0), (x + 0.25, y + 0.25, 1.0))
    for alliance, y in (("blue", dim.NET_Y), ("red", dim.FIELD_WIDTH - dim.NET_Y)):
        assert is_free(field, (8.4, y - 1.7, inches(76) + 1e-5), (9.1, y + 1.7, 4.0)), alliance


def test_algae_fit_between_the_pipes_and_touch_four_of_them(field):
    """Where they are staged: at the heights that teams measured, within 3 mm of two risers and two branches."""
    from scipy.optimize import lsq_linear
    from scipy.spatial import ConvexHull

    places = reef_algae_places()
    assert sorted(places[:, 2].round(2)) == [0.91] * 3 + [1.31] * 3
    for face, place in enumerate(places):
        gaps = []
        for element in field.elements:
            if f"_{face}_" in element.name and element.name.startswith("blue_reef_"):
                corners = points(element)[ConvexHull(points(element)).vertices]
                weight = 1e3  # the nearest point of a convex body: weights of its corners that add up to one
                a = np.vstack([(corners - place).T, np.full(len(corners), weight)])
                share = lsq_linear(a, np.array([0.0, 0.0, 0.0, weight]), bounds=(0.0, 1.0)).x
                gaps.append(float(np.linalg.norm((corners - place).T @ share)) - dim.ALGAE_DIAMETER / 2)
        assert sorted(gaps)[:4] == pytest.approx([0.0] * 4, abs=0.003)
        assert sorted(gaps)[4] > 0.005


def test_tags_of_the_official_layout_agree():
    """WPILib's AprilTags are on the faces of reef, stations and processors."""
    apriltag = pytest.importorskip("robotpy_apriltag")
    layout = apriltag.AprilTagFieldLayout.loadField(apriltag.AprilTagField.k2025ReefscapeWelded)
    assert (layout.getFieldLength(), layout.getFieldWidth()) == pytest.approx((dim.FIELD_LENGTH, dim.FIELD_WIDTH))
    tag = {i: layout.getTagPose(i).translation() for i in range(1, 23)}
    assert (tag[18].x + tag[21].x) / 2 == pytest.approx(dim.REEF_CENTER[0], abs=1e-4)
    for number, yaw_deg in zip((18, 19, 20, 21, 22, 17), dim.REEF_FACE_YAWS_DEG, strict=True):
        yaw = math.radians(yaw_deg)
        dx, dy = tag[number].x - dim.REEF_CENTER[0], tag[number].y - dim.REEF_CENTER[1]
        assert math.cos(yaw) * dx + math.sin(yaw) * dy == pytest.approx(dim.REEF_APOTHEM, abs=1.2e-3)
        assert math.cos(yaw) * dy - math.sin(yaw) * dx == pytest.approx(0.0, abs=3e-4)
    assert (tag[12].x, tag[12].y) == pytest.approx(dim.STATION_FACE_CENTER, abs=1e-5)
    assert tag[16].x == pytest.approx(dim.PROCESSOR_X, abs=1e-5)
    assert (tag[14].y, tag[4].x - tag[14].x) == pytest.approx((dim.NET_Y, dim.NET_WIDTH), abs=5e-3)
    assert FIELD.symmetry.flip_point(tag[12].x, tag[12].y) == pytest.approx((tag[2].x, tag[2].y), abs=1e-3)
