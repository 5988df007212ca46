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


def test_a_driver_takes_a_cage_into_the_bay_and_hangs_there_without_power(sim):
    sim.place(8.0, 6.17, 3.14)  # its back to the middle cage
    pad = sim.xbox(0)
    sim.teleop()
    pad.start = True  # this way is ahead
    pad.pov(0)  # hook up
    sim.run(4.0)
    pad.left_y = 0.15
    sim.run_until(lambda: sim.pose.x > 8.74, timeout=3.0)
    pad.left_y = 0.0
    pad.pov(180)  # hook down
    sim.run(4.5)
    robot = sim.robot_sim
    assert robot.climbers[0].rung is not None
    height = robot.chassis.pos[2]
    assert height > 0.3  # m above the carpet
    sim.disable(seconds=3.0)
    assert abs(robot.chassis.pos[2] - height) < 0.003, "friction of the winch holds it"
