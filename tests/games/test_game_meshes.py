"""Committed field meshes: equal to the scripts' output, closed, symmetric, with the published dimensions."""

from __future__ import annotations

import importlib.util
import math
from pathlib import Path

import numpy as np
import pytest
import trimesh
from mesh_checks import is_free, points, span
from scipy.optimize import lsq_linear
from scipy.spatial import ConvexHull

from games.rebuilt import REBUILT
from games.rebuilt import dimensions as rebuilt
from games.reefscape import REEFSCAPE
from games.reefscape import dimensions as reefscape
from games.reefscape.places import branch_ends
from games.reefscape.staging import mark_places, reef_algae_places
from simcore.units import inches
from simcore.world.obj import read_obj
from simcore.world.shapes import Box, Hull

ROOT = Path(__file__).resolve().parents[2]
FIELDS = {game.name: game.field.load() for game in (REBUILT, REEFSCAPE)}
both = pytest.mark.parametrize("name", FIELDS)


@both
def test_the_committed_field_is_the_output_of_its_script(name):
    spec = importlib.util.spec_from_file_location("generate", ROOT / "scripts" / f"generate_{name}_field.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    committed = (ROOT / "models" / name / "field_collision.obj").read_bytes()
    assert committed == script.generate().encode(), f"run: python scripts/generate_{name}_field.py"


@both
def test_every_group_is_a_closed_convex_body_with_few_faces(name):
    groups = read_obj(ROOT / "models" / name / "field_collision.obj")
    assert all(isinstance(element.shape, Box | Hull) for element in FIELDS[name].elements)
    assert len(FIELDS[name].elements) == len(groups)
    assert sum(len(group.triangles()) for group in groups) < {"rebuilt": 800, "reefscape": 5000}[name]
    for group in groups:
        mesh = trimesh.Trimesh(group.vertices, group.triangles())
        assert mesh.is_watertight and mesh.is_winding_consistent and mesh.volume > 0.0, group.name


@both
def test_red_elements_are_blue_elements_turned_by_180_degrees(name):
    size = {"rebuilt": REBUILT, "reefscape": REEFSCAPE}[name].field.size
    for element in FIELDS[name].elements:
        sides = ("left", "right") if element.name.startswith("guardrail") else ("blue", "red")
        other = element.name.replace(sides[0], "x").replace(sides[1], sides[0]).replace("x", sides[1])
        turned = points(FIELDS[name].element(other)) * [-1, -1, 1] + [*size, 0.0]
        turned = turned[np.lexsort(np.round(turned, 5).T)]
        assert turned == pytest.approx(points(element), abs=3e-6), element.name
        assert type(FIELDS[name].element(other).shape) is type(element.shape)


PRINTED = {
    "rebuilt": [
        ("guardrail_right", "high", 2, inches(20), 1e-6),
        ("guardrail_left", "low", 1, 8.069, 1e-6),
        ("blue_alliance_wall", "high", 0, 0.0, 1e-6),
        ("red_alliance_wall", "low", 0, 16.541, 1e-6),
        ("blue_hub_base", "low", 0, inches(158.6), 1e-6),
        *(("blue_hub_base", "size", axis, inches(47), 2e-6) for axis in (0, 1)),
        ("blue_hub_base", "high", 2, 1.2, 1e-6),
        ("blue_hub_backboard", "high", 2, 3.0, 1e-6),
        *(("blue_bump_right", "size", axis, inches(n), 2e-6) for axis, n in enumerate((44.4, 73.0, 6.513))),
        ("blue_tower_upright_right", "high", 2, inches(72.1), 1e-6),
        *(("blue_tower_upright_right", "size", axis, inches(n), 2e-6) for axis, n in enumerate((3.5, 1.5))),
        ("blue_tower_upright_right", "middle", 0, 1.06204, 3e-3),  # source: MapleSim
        *(
            (f"blue_tower_rung_{at}", "middle", 2, inches(n), 1e-6)
            for at, n in (("low", 27), ("mid", 45), ("high", 63))
        ),
        *(("blue_tower_base", "size", axis, inches(n), 2e-6) for axis, n in enumerate((45.18, 39.0, 0.25))),
        ("blue_depot_barrier_front", "high", 0, inches(27), 2e-6),
        ("blue_depot_barrier_front", "high", 2, inches(1.125), 2e-6),
        ("blue_depot_barrier_right", "low", 1, 5.429, 2e-3),  # source: mesh of the Java simulator
    ],
    "reefscape": [
        ("blue_alliance_wall", "high", 0, 0.0, 1e-6),
        ("red_alliance_wall", "low", 0, 17.548, 1e-6),
        ("blue_guardrail_far", "high", 2, inches(20), 1e-6),
        ("red_guardrail_far", "low", 1, 8.052, 1e-6),
        ("blue_reef_trough_0", "low", 0, inches(144), 2e-4),
        ("blue_reef_trough_3", "high", 0, 5.3210, 3e-4),
        ("blue_reef_trough_3", "high", 2, inches(18), 1e-6),
        ("blue_net_near", "high", 2, inches(88), 1e-6),
        ("blue_net_floor", "high", 2, inches(76), 1e-6),
    ],
}
"""Element, corner, axis, value in a manual or another source [m], and tolerance [m]."""


@both
def test_elements_have_the_sizes_and_positions_in_the_manual(name):
    wrong = []
    for element, corner, axis, printed, within in PRINTED[name]:
        low, high = span(FIELDS[name], element)
        found = {"low": low, "high": high, "size": high - low, "middle": (low + high) / 2}[corner][axis]
        if abs(found - printed) > within:
            wrong.append(f"{element}, {corner} {'xyz'[axis]}: {found}, printed {printed}")
    assert wrong == []


# --- REBUILT ----------------------------------------------------------------------------------------------------------


def test_the_hub_funnel_has_the_dimensions_in_the_manual():
    """The section of each wedge along its normal gives distances and heights of throat, rim and skirt."""
    center, throat, outer = (
        np.array([*rebuilt.HUB_CENTER, 0.0]),
        rebuilt.HUB_THROAT_APOTHEM,
        rebuilt.HUB_OPENING_APOTHEM + inches(1),
    )
    wanted = ((throat, 1.2), (throat, inches(56.5)), (inches(41.7) / 2, inches(72)), (outer, inches(71)), (outer, 1.2))
    for i in range(6):
        angle = math.radians(60 * i)
        local = points(FIELDS["rebuilt"].element(f"blue_hub_funnel_{i}")) - center
        distance = local[:, :2] @ [math.cos(angle), math.sin(angle)]
        section = {(round(float(r), 4), round(float(z), 4)) for r, z in zip(distance, local[:, 2], strict=True)}
        assert section == {(round(r, 4), round(z, 4)) for r, z in wanted}


@pytest.mark.parametrize("alliance", ["blue", "red"])
def test_nothing_blocks_the_path_of_a_ball_through_a_hub(alliance):
    """The free space is the inner square from above the hub down to the base, where the scoring zone is."""
    field, half = FIELDS["rebuilt"], rebuilt.HUB_THROAT_CIRCUMRADIUS / 2
    cx, cy = rebuilt.HUB_CENTER if alliance == "blue" else REBUILT.field.symmetry.flip_point(*rebuilt.HUB_CENTER)
    assert is_free(field, (cx - half, cy - half, 1.2), (cx + half, cy + half, 3.0))
    assert not is_free(field, (cx - half, cy - half, 1.1), (cx + half, cy + half, 3.0))


@pytest.mark.parametrize("y", [0.0, rebuilt.FIELD_WIDTH - rebuilt.TRENCH_CLEAR_WIDTH])
@pytest.mark.parametrize("x", [rebuilt.TRENCH_X, rebuilt.FIELD_LENGTH - rebuilt.TRENCH_X])
def test_each_trench_opening_is_free_and_no_larger_than_in_the_manual(x, y):
    field = FIELDS["rebuilt"]
    low, high = np.array([x - 1.0, y, 0.0]), np.array([x + 1.0, y + inches(50.34), inches(22.25)])
    assert is_free(field, low, np.subtract(high, (0.0, 2e-6, 2e-6)))
    assert not is_free(field, low, np.add(high, (0.0, 0.0, 0.01)))  # the trench arm
    assert not is_free(field, np.subtract(low, (0.0, 0.01, 0.0)), high)  # guardrail or leg
    assert not is_free(field, low, np.add(high, (0.0, 0.01, 0.0)))


# --- REEFSCAPE --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("level", "height"), [(2, 0.7966), (3, 1.1967), (4, 1.8288)])
def test_branch_tips_are_at_the_published_positions(level, height):
    """Source: 6328's table, 30.738 in outward from the center and 6.469 in to both sides of the middle of each face."""
    ends = {number: np.array(branch_ends(number, level)) for number in range(12)}
    for number, yaw_deg in ((0, 180), (1, 180), (2, 240), (7, 0), (11, 120)):
        yaw, side = math.radians(yaw_deg), -1.0 if number % 2 == 0 else 1.0
        c, s, out, aside = math.cos(yaw), math.sin(yaw), 0.7807, side * 0.1643
        want = (4.4893 + out * c - aside * s, 4.0259 + out * s + aside * c, height)
        assert ends[number][1] == pytest.approx(want, abs=3e-4)
    element = points(FIELDS["reefscape"].element(f"blue_reef_branch_l{level}_0_left"))
    ring = element[np.argsort(np.linalg.norm(element - ends[0][1], axis=1))[:8]]
    assert ring.mean(axis=0) == pytest.approx(ends[0][1], abs=1e-5)
    assert np.linalg.norm(ring - ends[0][1], axis=1) == pytest.approx(0.02222, abs=2e-5)  # same area as the round pipe


def test_a_coral_station_has_the_opening_in_the_manual():
    """Tag 12 is in the middle of the face; the opening is 76 x 7 in and begins at 37.5 in."""
    normal = np.array([math.cos(math.radians(54)), math.sin(math.radians(54)), 0.0])
    along, face = np.array([-normal[1], normal[0], 0.0]), np.array([0.851154, 0.65532, 0.0])
    parts = (FIELDS["reefscape"].element(f"blue_station_right_{name}") for name in ("lip", "roof"))
    lip, roof = (points(part) - face for part in parts)
    front = lip[lip @ normal > -1e-5]
    assert front[:, 2].max() == pytest.approx(inches(37.5), abs=1e-5)
    assert np.ptp(front @ along) == pytest.approx(inches(76), abs=1e-5)
    assert roof[roof @ normal > -1e-5][:, 2].min() == pytest.approx(inches(44.5), abs=1e-5)


def test_the_processor_opening_is_free_and_no_larger_than_in_the_manual():
    field = FIELDS["reefscape"]
    low = (reefscape.PROCESSOR_X - inches(14), -0.3, inches(7))
    high = (reefscape.PROCESSOR_X + inches(14), 0.1, inches(27))
    shrink = np.array([2e-6, 0.0, 2e-6])
    assert is_free(field, low + shrink, high - shrink)
    for grow in ((0.01, 0.0, 0.0), (0.0, 0.0, 0.01)):
        assert not is_free(field, low, np.add(high, grow))
        assert not is_free(field, np.subtract(low, grow), high)


def test_the_reefscape_field_has_the_required_clearances():
    """Staging marks, the passage between the barge's post and the guardrail, and the insides of the nets are free."""
    field = FIELDS["reefscape"]
    assert is_free(field, (5.4, 0.0, 0.0), (12.1, 3.8, inches(62) - 1e-5))
    for x, y in mark_places():
        assert is_free(field, (x - 0.25, y - 0.25, 0.0), (x + 0.25, y + 0.25, 1.0))
    for y in (reefscape.NET_Y, reefscape.FIELD_WIDTH - reefscape.NET_Y):
        assert is_free(field, (8.4, y - 1.7, inches(76) + 1e-5), (9.1, y + 1.7, 4.0))


def test_staged_algae_fit_between_the_pipes_and_touch_four_of_them():
    """At the heights that teams measured, each algae is within 3 mm of two risers and two branches."""
    places = reef_algae_places()
    assert sorted(places[:, 2].round(2)) == [0.91] * 3 + [1.31] * 3
    for face, place in enumerate(places):
        gaps = []
        for element in FIELDS["reefscape"].elements:
            if f"_{face}_" in element.name and element.name.startswith("blue_reef_"):
                corners = points(element)[ConvexHull(points(element)).vertices]
                weight = 1e3  # nearest point of a convex body: a convex combination of its corners
                a = np.vstack([(corners - place).T, np.full(len(corners), weight)])
                share = lsq_linear(a, np.array([0.0, 0.0, 0.0, weight]), bounds=(0.0, 1.0)).x
                gaps.append(float(np.linalg.norm((corners - place).T @ share)) - reefscape.ALGAE_DIAMETER / 2)
        assert sorted(gaps)[:4] == pytest.approx([0.0] * 4, abs=0.003)
        assert sorted(gaps)[4] > 0.005


# --- AprilTags --------------------------------------------------------------------------------------------------------


def test_tags_of_2026_are_on_hubs_trenches_towers_and_outposts():
    """Tags of 2025 are in test_reefscape_tags.py."""
    apriltag, dim = pytest.importorskip("robotpy_apriltag"), rebuilt
    layout = apriltag.AprilTagFieldLayout.loadField(apriltag.AprilTagField.k2026RebuiltWelded)
    assert (layout.getFieldLength(), layout.getFieldWidth()) == pytest.approx((dim.FIELD_LENGTH, dim.FIELD_WIDTH))
    tag = {one.ID: one.pose.translation() for one in layout.getTags()}
    assert (tag[26].x + tag[20].x) / 2 == pytest.approx(dim.HUB_CENTER[0], abs=1e-3)
    assert tag[26].y == pytest.approx(dim.HUB_CENTER[1], abs=1e-3)
    assert (tag[17].x + tag[28].x) / 2 == pytest.approx(dim.TRENCH_X, abs=1e-3)
    assert tag[22].y == pytest.approx(dim.TRENCH_LEFT_Y, abs=0.01)
    assert tag[31].y == pytest.approx(dim.TOWER_Y, abs=1e-4)
    assert tag[29].y == pytest.approx(dim.OUTPOST_Y, abs=1e-3)
    assert REBUILT.field.symmetry.flip_point(tag[26].x, tag[26].y) == pytest.approx((tag[10].x, tag[10].y), abs=1e-3)
