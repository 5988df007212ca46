"""What a team tests before it drives to an event, in simulated time: `python -m robotpy test`."""

import pytest


@pytest.mark.parametrize(
    ("auto", "color", "at_least"), [("depot", "blue", 8), ("depot", "red", 8), ("neutral (PathPlanner)", "blue", 30)]
)
def test_the_auto_scores(sim, auto, color, at_least):
    if "PathPlanner" in auto:
        pytest.importorskip("pathplannerlib", reason="needs PathPlanner: pip install robotpy-pathplannerlib")
    sim.alliance(color)
    sim.autonomous(auto, seconds=20)
    assert getattr(sim.score, color) >= at_least
    assert sim.score.total == getattr(sim.score, color)
    assert sim.battery.min_voltage > 7.0


def test_the_auto_that_was_chosen_is_the_one_that_plays(sim):
    sim.start()
    before = sim.pose
    sim.autonomous("nothing", seconds=2)
    assert sim.pieces.held == 8
    assert sim.pose.translation().distance(before.translation()) < 0.01


def test_a_driver_drives_takes_in_and_shoots(sim):
    pad = sim.xbox(0)
    sim.teleop()
    start = sim.pose
    pad.left_y = -0.5  # forward, away from the driver
    sim.run(1.0)
    pad.left_y = 0.0
    sim.run(1.0)
    assert sim.pose.X() - start.X() > 0.7
    pad.y = True  # aim and shoot
    sim.run_until(lambda: sim.pieces.held == 0, timeout=8.0)


def test_odometry_follows_the_robot(sim):
    sim.autonomous("depot", seconds=6)
    believed = sim.robot.container.drivetrain.get_state().pose
    assert believed.translation().distance(sim.pose.translation()) < 0.2


def test_disabled_it_stays_where_it_is(control, robot):
    """Pyfrc's own fixtures."""
    with control.run_robot():
        control.step_timing(seconds=2.0, autonomous=False, enabled=False)
        before = robot.container.drivetrain.get_state().pose
        control.step_timing(seconds=2.0, autonomous=False, enabled=False)
        after = robot.container.drivetrain.get_state().pose
        assert before.translation().distance(after.translation()) < 0.05  # cameras go on correcting odometry
