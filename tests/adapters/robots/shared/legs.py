"""Driver's legs for a robot with any drivetrain, as a robot test; writes true and estimated motion."""

import json
import math
from pathlib import Path

HOLONOMIC = {"ahead": {"left_y": -0.4}, "left": {"left_x": -0.5}, "turn": {"right_x": -0.6}}
TANK = {"ahead": {"left_y": -0.3}, "turn": {"right_x": -0.3}, "curve": {"left_y": 0.3, "right_x": -0.25}}


def drive(sim, legs):
    """Drive each leg for 1.2 s and coast; write distance, estimated distance and turn of each leg to facts.json."""
    pad, found = sim.xbox(0), {}
    sim.place(1.5, 2.2)
    sim.teleop(seconds=0.3)
    robot = sim.robot_sim
    for name, sticks in legs.items():
        true, told, turned = robot.chassis.pose, robot.estimated_pose, 0.0
        for tenth in range(18):
            for stick, value in sticks.items():
                setattr(pad, stick, value if tenth < 12 else 0.0)
            heading = robot.chassis.pose[2]
            sim.run(0.1)
            turned += math.remainder(robot.chassis.pose[2] - heading, math.tau)
        now, new = robot.chassis.pose, robot.estimated_pose
        found[name] = math.dist(true[:2], now[:2]), math.dist(told[:2], new[:2]), turned
    facts = {"legs": found, "warnings": sim.warnings, "digest": sim.digest}
    Path("facts.json").write_text(json.dumps(facts))
