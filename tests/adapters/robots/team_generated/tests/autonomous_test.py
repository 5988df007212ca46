import pytest


def test_autonomous_drives_the_path_of_the_chooser_and_a_routine_of_sysid_runs(sim):
    sim.autonomous("Ahead", seconds=4.0)
    assert (sim.pose.X(), sim.pose.Y()) == pytest.approx((3.0, 2.6), abs=0.05)
    pad = sim.xbox(0)
    sim.teleop()
    pad.back = pad.y = True
    sim.run(0.4)
    assert sim.pose.X() > 3.1  # a step of 4 V, straight ahead
