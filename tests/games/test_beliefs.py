"""Warning about a robot whose estimated start pose differs from the true pose, in scripted matches."""

from __future__ import annotations

import logging

import pytest

from games.rebuilt import REBUILT
from simcore import Match


@pytest.mark.parametrize(
    ("believed", "words"),
    [
        (None, ""),
        ((0.45, 0.0, 0.15), ""),
        ((0.6, 0.0, 0.0), "0.60 m and 0 deg apart"),
        ((0.0, 0.0, -0.3), "0.00 m and 17 deg apart"),
    ],
)
def test_a_single_warning_names_the_estimated_and_the_true_pose(caplog, believed, words):
    with Match(REBUILT, seed=1) as match:
        robot = match.robots[0]
        if believed is not None:
            robot.estimated_pose = tuple(a + b for a, b in zip(robot.chassis.pose, believed, strict=True))
        match.play(1.0)
        said = [r.getMessage() for r in caplog.records if r.levelno >= logging.WARNING]
        assert len(said) == bool(words), said
        if words:
            assert words in said[0] and "robot 0 believes it is at" in said[0] and "but it is at" in said[0]
