"""A driver's course for a robot with any drivetrain, as a robot test: 5 m, fuel, the wall; writes what it measured."""

import json
import math
from pathlib import Path

import numpy as np


def test_course(sim):
    robot = sim.robot_sim
    pad = sim.joystick(0)

    heading = 0.0

    def push(ahead, left=0.0):
        yaw = math.remainder(sim.pose.rotation().radians() - heading, math.tau)
        pad.axis(1, -(ahead * math.cos(yaw) + left * math.sin(yaw)))
        pad.axis(0, -(left * math.cos(yaw) - ahead * math.sin(yaw)))
        pad.axis(4, 0.8 * min(max(yaw, -0.5), 0.5))

    def drive(seconds, ahead, left=0.0, until=lambda: False):
        for _ in range(round(seconds / 0.02)):
            push(ahead, left)
            sim.run(0.02)
            if until():
                return

    def way(pose, start):
        dx, dy = pose[0] - start[0], pose[1] - start[1]
        return math.cos(start[2]) * dx + math.sin(start[2]) * dy, math.cos(start[2]) * dy - math.sin(start[2]) * dx

    heading = 0.5 * math.pi
    sim.place(2.8, 1.2, heading)
    sim.teleop()
    drive(0.5, 0.0)
    start, believed = robot.chassis.pose, robot.estimated_pose
    drive(6.0, 0.9, until=lambda: way(robot.chassis.pose, start)[0] > 5.0)
    drive(0.6, 0.0)
    true, told = way(robot.chassis.pose, start), way(robot.estimated_pose or (0.0, 0.0, 0.0), believed or (0.0,) * 3)
    holonomic = robot.config.drivetrain.__class__.__name__ != "TankConfig"
    before = sim.match.piece_positions()["Fuel"].copy()
    heading = 0.0
    sim.place(6.3, 4.0, heading)
    drive(0.4, 0.0)
    drive(2.5, 0.8)
    after = sim.match.piece_positions()["Fuel"]
    pushed = int((np.linalg.norm(after - before[: len(after)], axis=1) > 0.02).sum())
    sim.place(14.0, 1.2, 0.0)
    drive(0.4, 0.0)
    drive(3.0, 0.8)
    stopped = robot.chassis.pose[0]
    drive(1.0, 0.8)
    facts = {
        "true": true,
        "told": told,
        "turned": math.remainder(robot.chassis.pose[2], math.tau),
        "pushed": pushed,
        "at_wall": 16.541 - robot.chassis.pose[0] - 0.5 * robot.chassis.config.bumper_length,
        "speed_at_wall": robot.chassis.pose[0] - stopped,
        "holonomic": holonomic,
        "digest": sim.digest,
    }
    if holonomic:
        sim.place(3.0, 1.0, 0.0)
        drive(0.4, 0.0)
        start, believed = robot.chassis.pose, robot.estimated_pose
        drive(2.0, 0.0, 0.5)
        drive(0.5, 0.0)
        facts["true_left"] = way(robot.chassis.pose, start)
        facts["told_left"] = way(robot.estimated_pose, believed) if believed else None
    facts["warned"] = [text for text in sim.warnings if "does not hold" in text]
    Path("facts.json").write_text(json.dumps(facts))
