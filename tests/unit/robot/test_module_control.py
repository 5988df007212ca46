"""Kinematics of the on-board loops."""

from __future__ import annotations

import math

import pytest

from simcore.loop.robots import optimize
from simcore.robot.swerve_drive import desaturate, module_targets


def test_optimize_turns_at_most_a_quarter():
    assert optimize(2.0, 3.0, 0.0) == pytest.approx((-2.0 * math.cos(3.0 - math.pi), 3.0 - math.pi))
    assert optimize(2.0, 0.3, 4 * math.pi) == pytest.approx((2.0 * math.cos(0.3), 0.3))


def test_desaturate_keeps_ratios():
    assert desaturate([4.0, -8.0], 4.0) == [2.0, -4.0]
    assert desaturate([1.0], 4.0) == [1.0]


def test_turning_on_the_spot():
    positions = [(0.3, 0.3), (-0.3, 0.3)]
    speeds, angles = module_targets(positions, 0.0, 0.0, 2.0, 5.0, [0.0, 0.0])
    assert speeds == pytest.approx([0.6 * math.sqrt(2)] * 2)
    assert angles == pytest.approx([math.radians(135), math.radians(-135)])


def test_no_wish_keeps_the_angles():
    assert module_targets([(0.3, 0.3)], 0.0, 0.0, 0.0, 5.0, [1.2]) == ([0.0], [1.2])
