"""Where the cameras of the view stand: the corners of the field, projected by hand, are in the window and fill it."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from simcore.show.view_cameras import COVERED, default_stations, station_eye, whole_field

SIZE = (16.541, 8.069)


def on_screen(points, eye, target, aspect: float, fov: float) -> np.ndarray:
    """Right and up from the middle of the window, the window's edges at +-1, shape (n, 2)."""
    ahead = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(ahead, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    x, y, depth = ((np.asarray(points) - eye) @ np.array([right, np.cross(right, ahead), ahead]).T).T
    half = math.tan(0.5 * fov)
    return np.column_stack((x / (depth * half * aspect), y / (depth * half)))


@pytest.mark.parametrize("aspect", [0.35, 0.49, 0.8, 1.2, 1.55, 2.4])
@pytest.mark.parametrize("covered", [0.0, COVERED])
@pytest.mark.parametrize("fov", [0.5, 0.85, 1.4])
def test_the_whole_field_is_in_any_window_and_fills_it(aspect, covered, fov) -> None:
    """Two opposite edges of what is free of the window are reached to the margin of 5 %."""
    eye, target = whole_field(SIZE, aspect, fov=fov, covered=covered)
    corners = list(itertools.product((0.0, SIZE[0]), (0.0, SIZE[1]), (0.0, 2.0)))
    x, y = on_screen(corners, eye, target, aspect, fov).T
    low = -1.0 + 2.0 * covered
    assert abs(x).max() <= 0.95 + 1e-9 and y.max() <= 0.95 + 1e-9 and y.min() >= 0.95 * low - 1e-9
    assert abs(x).max() > 0.949 or (y.max() > 0.949 and y.min() < 0.95 * low + 1e-3)
    assert x.max() == pytest.approx(-x.min()) and target[2] == pytest.approx(0.0), (
        "in the middle, turned about the carpet"
    )


def test_a_wide_window_looks_from_the_side_and_a_narrow_one_along_the_field() -> None:
    wide, narrow = (eye - target for eye, target in (whole_field(SIZE, 1.6), whole_field(SIZE, 0.5)))
    assert abs(wide[0]) < 1e-9 > wide[1] and abs(narrow[1]) < 1e-9 > narrow[0]


def test_drivers_see_the_field_from_their_wall_without_its_glass() -> None:
    for number, station in enumerate(default_stations(SIZE)):
        eye, target = station_eye(SIZE, station)
        assert 0.0 < (eye[0] if number < 3 else SIZE[0] - eye[0]) < 0.1
        assert 1.5 < eye[2] < 1.64 and eye[1] == station[1]
        ((x, y),) = on_screen([(SIZE[0] / 2, SIZE[1] / 2, 0.0)], eye, target, 1.4, 0.85)
        assert abs(x) < 0.3 and abs(y) < 0.3
