"""Which elements an upright box may meet, by their outlines from above."""

from __future__ import annotations

import math

import numpy as np

from simcore.geometry.rotation import IDENTITY
from simcore.physics.nearness import PlanOutlines
from simcore.physics.shapes import Box, Hull

WEDGE = Hull(np.array([[x, y, z] for x, y in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)) for z in (0.0, 0.5)]))


def outlines() -> PlanOutlines:
    found = PlanOutlines()
    found.add(Box((1.0, 1.0, 1.0)), (5.0, 5.0, 0.5), IDENTITY)
    found.add(WEDGE, (0.0, 0.0, 0.0), IDENTITY)
    return found


def test_a_box_meets_what_its_sides_and_height_reach():
    assert outlines().met(4.0, 5.0, 0.0, 0.6, 0.1, 0.0, 1.0).tolist() == [True, False]
    assert outlines().met(4.0, 5.0, 0.0, 0.4, 0.1, 0.0, 1.0).tolist() == [False, False]
    assert outlines().met(4.0, 5.0, 0.0, 0.6, 0.1, 1.2, 1.4).tolist() == [False, False]
    assert PlanOutlines().met(0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 1.0).tolist() == []


def test_a_box_along_a_slanting_side_is_not_met():
    """Its own axes part it from the wedge's long side, which the field's axes do not."""
    x = y = 0.5 + 0.3 / math.sqrt(2.0)
    assert outlines().met(x, y, math.pi / 4, 0.25, 0.8, 0.0, 1.0).tolist() == [False, False]
    assert outlines().met(x, y, math.pi / 4, 0.32, 0.8, 0.0, 1.0).tolist() == [False, True]
    assert outlines().met(x, y, 0.0, 0.8, 0.8, 0.0, 1.0)[1]
