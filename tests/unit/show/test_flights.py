"""Trails: pieces without names are followed by their parabolas."""

from __future__ import annotations

import numpy as np
import pytest

from simcore.show.flights import Trails

DT = 0.02


def flight(start: tuple[float, float, float], velocity: tuple[float, float, float], times: np.ndarray) -> np.ndarray:
    points = np.array(start) + times[:, None] * np.array(velocity)
    points[:, 2] -= 0.5 * 9.80665 * times**2
    return points


def test_two_barrels_side_by_side_keep_apart_whatever_the_order() -> None:
    """Eight shots a second from two barrels 16 cm apart: every trail stays in its own plane."""
    trails = Trails()
    rng = np.random.default_rng(3)
    for tick in range(60):
        points = []
        for shot in range(8):
            age = tick * DT - shot * 0.125
            if age >= 0.0:
                for y in (-0.08, 0.08):
                    points.append(flight((0.0, y, 0.5), (6.0, 0.0, 7.0), np.array([age]))[0])
        trails.update(tick * DT, rng.permutation(np.array(points).reshape(-1, 3)))
    segments = trails.segments(59 * DT)
    assert len(segments) > 200
    np.testing.assert_allclose(segments[:, 0, 1], segments[:, 1, 1])
    steps = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
    assert steps.max() < 10.0 * DT, "no line from one piece to another"


def test_a_trail_stays_for_a_while_after_its_piece_has_gone() -> None:
    trails = Trails(keep=0.5)
    points = flight((0.0, 0.0, 1.0), (5.0, 0.0, 3.0), np.arange(10) * DT)
    for i, point in enumerate(points):
        trails.update(i * DT, point[None, :])
    trails.update(10 * DT, np.zeros((0, 3)))
    assert len(trails.segments(10 * DT)) == 9
    trails.update(10 * DT, np.zeros((0, 3)))
    assert len(trails.segments(0.18 + 0.47)) > 0
    assert len(trails.segments(0.18 + 0.51)) == 0


@pytest.mark.parametrize("later", [-1.0, 5.0])
def test_a_jump_in_time_starts_anew(later: float) -> None:
    trails = Trails()
    for i in range(5):
        trails.update(2.0 + i * DT, np.array([[i * 0.1, 0.0, 1.0]]))
    trails.update(2.0 + later, np.array([[0.5, 0.0, 1.0]]))
    assert trails.segments(2.0 + later).shape == (0, 2, 3)


def test_a_far_piece_is_another_one() -> None:
    trails = Trails()
    trails.update(0.0, np.array([[0.0, 0.0, 1.0]]))
    trails.update(DT, np.array([[5.0, 0.0, 1.0]]))
    assert len(trails.segments(DT)) == 0
