"""Trails: each piece has its own, by its id, whatever the order of the rows."""

from __future__ import annotations

import numpy as np
import pytest
from simcore.show.view_trails import Trails

DT = 0.02


def place(shot: int, time: float) -> tuple[float, float, float]:
    """Of one of two barrels 16 cm apart that shoot every 0.1 s."""
    age = time - 0.1 * (shot // 2)
    return 6.0 * age, 0.16 * (shot % 2) - 0.08, 0.5 + 7.0 * age - 0.5 * 9.80665 * age**2


def test_trails_stay_apart_last_a_while_and_start_where_their_piece_did() -> None:
    trails, rng = Trails(), np.random.default_rng(3)
    for tick in range(60):
        now = tick * DT
        flying = rng.permutation([shot for shot in range(16) if 0.1 * (shot // 2) <= now])
        trails.update(now, flying.tolist(), np.array([place(shot, now) for shot in flying]))
    segments = trails.segments()
    assert len(segments) > 600 and segments[:, 0, 0].min() == 0.0
    np.testing.assert_allclose(segments[:, 0, 1], segments[:, 1, 1])
    assert np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1).max() < 10.0 * DT, "no line between two pieces"
    landed = 59 * DT
    trails.update(landed + 0.2, [], np.zeros((0, 3)))
    assert len(trails.segments()) == len(segments), "the oldest is 1.4 s old"
    for later in (0.6, 1.0, 1.4, 1.6):
        trails.update(landed + later, [], np.zeros((0, 3)))
    assert len(trails.segments()) == 0


@pytest.mark.parametrize("later", [-1.0, 5.0])
def test_a_jump_in_time_starts_anew(later: float) -> None:
    trails = Trails()
    for i in range(5):
        trails.update(2.0 + i * DT, [4], np.array([[i * 0.1, 0.0, 1.0]]))
    assert len(trails.segments()) == 4
    trails.update(2.0 + later, [4], np.array([[0.5, 0.0, 1.0]]))
    assert trails.segments().shape == (0, 2, 3)
