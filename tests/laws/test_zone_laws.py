"""Swept zone tests agree with fine samples of the path."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simcore.world.zones import BoxZone, CylinderZone

pytestmark = pytest.mark.engines("bullet")

SAMPLES = 1001
coordinate = st.floats(-3.0, 3.0)
point = st.tuples(coordinate, coordinate, coordinate)

ZONES = {
    "box": lambda grow: BoxZone((-0.5 - grow, -1.0 - grow, 0.2 - grow), (0.6 + grow, 0.3 + grow, 0.8 + grow)),
    "cylinder": lambda grow: CylinderZone((0.3, -0.2), 0.5 + grow, 0.2 - grow, 0.8 + grow),
}


@pytest.mark.parametrize("kind", ZONES)
@given(start=point, end=point)
def test_zone_crossings_agree_with_fine_samples(kind, start, end):
    """A sampled point inside implies a crossing; a crossing implies a sample within half a spacing of the zone."""
    a, b = np.array([start]), np.array([end])
    path = a + np.linspace(0.0, 1.0, SAMPLES)[:, None] * (b - a)
    spacing = float(np.linalg.norm(b - a)) / (SAMPLES - 1)
    crossed = bool(ZONES[kind](0.0).crossed(a, b)[0])
    if ZONES[kind](-1e-9).contains(path).any():
        assert crossed
    if crossed:
        assert ZONES[kind](0.5 * spacing + 1e-9).contains(path).any()


@pytest.mark.parametrize("kind", ZONES)
@given(start=point, middle=point, end=point)
def test_the_ticks_of_a_path_are_tested_independently_for_zone_crossings(kind, start, middle, end):
    """Rows are independent; a point inside at the end of a tick crosses in that tick and in the next."""
    zone = ZONES[kind](0.0)
    a, b, c = np.array([start]), np.array([middle]), np.array([end])
    both = zone.crossed(np.vstack((a, b)), np.vstack((b, c)))
    assert both.tolist() == [zone.crossed(a, b)[0], zone.crossed(b, c)[0]]
    if zone.contains(b)[0]:
        assert both.all()
