"""What drivers do, from buttons to points."""


def test_a_driver_scores_on_the_branch_and_level_that_they_choose(sim):
    sim.place(5.7, 5.7, -2.09)  # before branches I and J; cameras tell the robot where it is
    pad = sim.xbox(0)
    sim.teleop()
    pad.left_bumper = True  # one level down: 3
    sim.run(0.1)
    pad.a = True  # rollers: the preload goes into the claw
    sim.run(0.5)
    pad.y = True  # on the right branch
    sim.run_until(lambda: sim.score.blue == 4, timeout=8.0)


def test_the_robot_hangs_on_a_cage_without_power(sim):
    sim.place(8.87, 6.17, 0.0)
    pad = sim.xbox(0)
    sim.teleop()
    pad.pov(0)
    sim.run(3.0)
    pad.pov(180)
    sim.run(3.0)
    sim.disable(seconds=3.0)
    assert sim.robot_sim.climbers[0].rung is not None
    assert sim.robot_sim.chassis.pos[2] > 0.05  # m above the carpet
