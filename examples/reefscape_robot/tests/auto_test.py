"""What a team tests before it drives to an event, in simulated time: `python -m robotpy test`."""

import pytest


@pytest.mark.parametrize("color", ["blue", "red"])
def test_the_auto_scores_two_coral_on_level_4(sim, color):
    sim.alliance(color)
    sim.autonomous("two coral", seconds=15)
    assert getattr(sim.score, color) >= 2 * 7
    assert sim.pieces.placed == 2


# 0.3 m and 2 degrees off: MegaTag 2 tells the place, the heading stays what the gyro says; from 3 degrees on the coral
# falls beside the branch.
def test_a_robot_that_was_put_down_beside_its_mark_finds_the_branch_with_its_cameras(sim):
    sim.autonomous("two coral", seconds=5, start=(7.0, 6.1, -2.06))
    assert sim.score.blue == 7


def test_a_second_auto_begins_like_the_first(sim):
    for _ in range(2):
        sim.autonomous("two coral", seconds=4.5)
        assert sim.score.blue == 7
        sim.disable(seconds=0.5)
