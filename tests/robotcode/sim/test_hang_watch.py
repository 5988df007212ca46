"""The hang watch counts the time in which a program works or waits, but no delay by a busy computer."""

from __future__ import annotations

import io

import pytest

pytest.importorskip("wpilib", reason="needs wpilib")

from simcore.robotcode.sim.hang_watch import HangWatch


@pytest.mark.parametrize(
    ("wall", "work", "passed"),
    [
        (0.25, 0.25, 0.25),  # the program works all the time
        (0.25, 0.001, 0.25),  # it waits
        (0.25, 0.05, 0.05),  # it works with a fifth of a processor, all that other programs leave
        (3.0, 0.002, 0.25),  # it has waited for a processor: the check itself came late
        (0.25, 0.9, 0.25),  # it works on four processors
    ],
)
def test_a_check_counts_either_the_work_time_or_the_waiting_time(wall, work, passed):
    watch = HangWatch(9.0, lambda: "robot.py:3 in robotInit", io.StringIO())
    watch._count(wall, work)
    assert watch._taken == passed


@pytest.mark.parametrize(("place", "looks"), [("robot.py:3 in robotInit", 36), ("", 360)])
def test_code_outside_the_program_may_take_ten_times_as_long(place, looks):
    watch = HangWatch(9.0, lambda: place, io.StringIO())
    for k in range(looks):
        assert not watch._is_over(), k
        watch._count(0.25, 0.0)
    assert watch._is_over()
