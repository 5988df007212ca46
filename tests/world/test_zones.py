"""Zones: edges, corners, and pieces too fast to be inside at the end of a tick."""

import math

import numpy as np
import pytest
from each_case import each

from simcore.errors import ConfigError
from simcore.world.zones import BoxZone, CapsuleZone, CylinderZone

BOX = BoxZone((1.0, 2.0, 0.0), (2.0, 4.0, 1.0))
TUBE = CylinderZone(center=(5.0, 5.0), radius=0.3, bottom=1.2, top=1.435)


def row(*point: float) -> np.ndarray:
    return np.array([point])


@each(
    ("point", "inside"),
    [
        ((1.5, 3.0, 0.5), True),
        ((1.0, 2.0, 0.0), True),  # the corner belongs to the box
        ((0.999, 3.0, 0.5), False),
        ((1.5, 4.001, 0.5), False),
        ((1.5, 3.0, -0.001), False),
        ((math.nan, 3.0, 0.5), False),
    ],
)
def test_a_box_contains_its_faces_and_nothing_beyond_them(point, inside):
    assert bool(BOX.contains(row(*point))[0]) is inside


@each(
    ("point", "inside"),
    [((5.0, 5.0, 1.3), True), ((5.3, 5.0, 1.2), True), ((5.22, 5.22, 1.3), False), ((5.0, 5.0, 1.436), False)],
)
def test_a_cylinder_is_round_and_contains_its_surface(point, inside):
    assert bool(TUBE.contains(row(*point))[0]) is inside


def test_a_path_that_ends_on_a_face_of_a_box_touches_the_box():
    assert BOX.crossed(row(0.5, 3.0, 0.5), row(1.0, 3.0, 0.5))[0]


@pytest.mark.parametrize("zone", [BOX, TUBE])
def test_zones_accept_empty_arrays_and_contain_no_piece_at_nan(zone):
    none = np.zeros((0, 3))
    assert zone.contains(none).shape == zone.crossed(none, none).shape == (0,)
    nan = row(math.nan, math.nan, math.nan)
    assert not zone.crossed(nan, nan)[0]


def test_zones_with_invalid_dimensions_are_refused():
    with pytest.raises(ConfigError, match="low must be below high"):
        BoxZone((0.0, 0.0, 1.0), (1.0, 1.0, 1.0))
    with pytest.raises(ConfigError, match=r"low\[0\] must be a number from -100 to 100 m, got nan"):
        BoxZone((math.nan, 0.0, 0.0), (1.0, 1.0, 1.0))
    with pytest.raises(ConfigError, match="radius"):
        CylinderZone((0.0, 0.0), -1.0, 0.0, 1.0)
    with pytest.raises(ConfigError, match="bottom must be below top"):
        CylinderZone((0.0, 0.0), 1.0, 2.0, 1.0)


def test_a_capsule_contains_the_points_near_its_line():
    """The results agree with distances between many points on both lines."""
    capsule = CapsuleZone((1.0, 1.0, 1.0), (1.3, 1.0, 1.4), 0.1)
    line = np.array(capsule.start) + np.linspace(0.0, 1.0, 400)[:, None] * np.subtract(capsule.end, capsule.start)
    rng = np.random.default_rng(1)
    start, end = rng.uniform(0.7, 1.7, (2, 200, 3))
    end[:20] = start[:20]  # pieces that stand still
    way = start[:, None] + np.linspace(0.0, 1.0, 400)[None, :, None] * (end - start)[:, None]
    apart = np.array([np.linalg.norm(one[:, None] - line[None], axis=2).min() for one in way])
    clear = np.abs(apart - capsule.radius) > 0.003
    assert np.array_equal(capsule.crossed(start, end)[clear], (apart <= capsule.radius)[clear])
    near = np.linalg.norm(start[:, None] - line[None], axis=2).min(axis=1)
    assert np.array_equal(
        capsule.contains(start)[np.abs(near - 0.1) > 0.002], (near <= 0.1)[np.abs(near - 0.1) > 0.002]
    )
    assert 10 < capsule.crossed(start, end).sum() < 190
    bar = CapsuleZone((0.0, 0.0, 1.0), (1.0, 0.0, 1.0), 0.1)
    for beyond, is_near in ((0.13, True), (0.15, False)):  # past an end at 45 degrees: 92 and 106 mm away
        for x in (-beyond, 1.0 + beyond):
            assert bar.crossed(row(x - 1.0, -1.0, 1.0), row(x + 1.0, 1.0, 1.0))[0] == is_near
    assert np.array(capsule.box) == pytest.approx(np.array([(0.9, 0.9, 0.9), (1.4, 1.1, 1.5)]))
    with pytest.raises(ConfigError, match="start and end must differ"):
        CapsuleZone((1.0, 1.0, 1.0), (1.0, 1.0, 1.0), 0.1)


@pytest.mark.parametrize(
    "zone",
    [
        BoxZone((0.9, 0.8, 0.7), (1.2, 1.1, 1.3)),
        CylinderZone((1.0, 1.1), 0.2, 0.8, 1.2),
        CapsuleZone((1.0, 1.0, 1.2), (1.3, 0.9, 1.0), 0.1),
    ],
)
def test_the_box_of_a_zone_is_its_smallest_bounding_box(zone):
    """Each face is as near to the zone as the points of a grid in the box are to each other."""
    low, high = map(np.array, zone.box)
    start, end = np.random.default_rng(2).uniform(0.6, 1.5, (2, 4000, 3))
    hit = zone.crossed(start, end)
    assert 100 < hit.sum() < 3900
    near = (np.maximum(start, end) >= low - 1e-9) & (np.minimum(start, end) <= high + 1e-9)
    assert near[hit].all()
    steps, apart = 60, (high - low) / 60
    axes = [np.linspace(a, b, steps + 1) for a, b in zip(low, high, strict=True)]
    grid = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)
    inside = grid[zone.contains(grid)]
    assert (inside.min(axis=0) - low <= apart + 1e-9).all()
    assert (high - inside.max(axis=0) <= apart + 1e-9).all()
