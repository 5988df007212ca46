"""A robot that meets pieces after a long time without any motion."""

from __future__ import annotations

import numpy as np
import pytest

from games.rebuilt import REBUILT
from simcore.match.game import RobotEntry
from simcore.match.match import Match

pytestmark = pytest.mark.engines("bullet")


@pytest.mark.parametrize("carried", [False, True])
def test_a_robot_pushes_sleeping_pieces_equally_after_a_long_rest(carried):
    """The robot waits for 2 s, in place or elsewhere, and then drives through the fuel of the neutral zone."""
    far, near = (2.5, 6.5, 0.0), (6.4, 4.0, 0.0)
    moved = []
    for wait in (0, 100):
        with Match(REBUILT, robots=[RobotEntry(start=far if carried else near)], seed=1) as match:
            for _ in range(50 + wait):
                match.tick()
            match.carry_to(0, near)
            start = match.pieces.state.pos.copy()
            for _ in range(50):
                match.robots[0].drive.set_chassis_speeds(2.0, 0.0, 0.0)
                match.tick()
            moved.append(np.linalg.norm(match.pieces.state.pos - start, axis=1) > 0.05)
    assert moved[0].sum() > 10
    assert moved[1].sum() == pytest.approx(moved[0].sum(), rel=0.2)
