"""What a team tests before it drives to an event: the auto scores, with `robotpy test`.

It takes as long as it does on the field: Phoenix 6 lives on the wall clock, and physics keeps to it.
"""

import hal
import ntcore
import pytest
from wpilib.simulation import DriverStationSim


@pytest.mark.parametrize(("auto", "at_least"), [("depot", 8), ("neutral (PathPlanner)", 30)])
def test_the_auto_scores(control, robot, auto, at_least):
    if "PathPlanner" in auto:
        pytest.importorskip("pathplannerlib", reason="needs PathPlanner: pip install robotpy-pathplannerlib")
    tables = ntcore.NetworkTableInstance.getDefault()
    DriverStationSim.setAllianceStationId(hal.AllianceStationID.kBlue1)
    with control.run_robot():
        control.step_timing(seconds=0.5, autonomous=True, enabled=False)
        tables.getEntry("/SmartDashboard/Auto/selected").setString(auto)
        control.step_timing(seconds=0.5, autonomous=True, enabled=False)
        control.step_timing(seconds=20.0, autonomous=True, enabled=True)
        assert tables.getEntry("/Sim/Score/Blue").getInteger(0) >= at_least


def test_disabled_it_stays_where_it_is(control, robot):
    with control.run_robot():
        control.step_timing(seconds=2.0, autonomous=False, enabled=False)
        before = robot.container.drivetrain.get_state().pose
        control.step_timing(seconds=2.0, autonomous=False, enabled=False)
        after = robot.container.drivetrain.get_state().pose
        assert before.translation().distance(after.translation()) < 0.01
