"""A robot of WPILib devices, stepped as fast as the machine can: what `robotpy test` does, in one process, twice alike.

Arguments: the project's folder.
"""

from __future__ import annotations

import json
import math
import os
import shutil
import sys
import threading
import time
from importlib import import_module
from pathlib import Path

import hal
import hal.simulation
import ntcore
from pyfrc.physics.core import PhysicsInterface
from wpilib import DriverStation
from wpilib.simulation import DriverStationSim, pauseTiming, restartTiming, stepTiming


def main() -> None:
    folder = Path.cwd() / "project"
    shutil.copytree(Path(sys.argv[1]), folder, ignore=shutil.ignore_patterns("__pycache__"))
    sys.path.insert(0, str(folder))
    hal.initialize(500, 0)
    ntcore.NetworkTableInstance.getDefault().startLocal()
    pauseTiming()
    restartTiming()
    interface, robot_class = PhysicsInterface._create_and_attach(import_module("robot").Robot, folder)
    robot = robot_class()
    thread = threading.Thread(target=robot.startCompetition, daemon=True)
    thread.start()
    while interface.engine is None:
        assert thread.is_alive(), "the robot program has ended"
        time.sleep(0.01)
    hal.simulation.waitForProgramStart()
    physics = interface.engine
    chassis = physics.robot_sim.chassis

    def run(seconds: float, goal=(0.0, 0.0, 0.0)) -> None:
        robot.goal = goal
        for _ in range(round(seconds / 0.02)):
            DriverStationSim.notifyNewData()
            stepTiming(0.02)

    begin = time.perf_counter()
    DriverStationSim.setDsAttached(True)
    DriverStationSim.notifyNewData()
    run(0.5)
    DriverStationSim.setEnabled(True)
    run(0.1)
    start, before = chassis.pose, robot.odometry.getPose()
    side = (0.0, 2.0, 0.0) if sys.argv[2] == "swerve" else (2.0, 0.0, 0.0)
    run(2.5, side)
    run(0.5)
    end, after = chassis.pose, robot.odometry.getPose()
    turned = chassis.pose[2]
    run(0.8, (0.0, 0.0, 2.0))
    run(0.3)
    turned = math.remainder(chassis.pose[2] - turned, math.tau)
    believed = math.remainder(robot.odometry.getPose().rotation().radians() - after.rotation().radians(), math.tau)
    run(0.3, (1.0, 0.0, 0.0))
    DriverStationSim.setEnabled(False)
    run(1.0, (1.0, 0.0, 0.0))
    speed_disabled = chassis.speed
    told = [DriverStation.getGameSpecificMessage()]
    for autonomous in (True, False):
        DriverStationSim.setAutonomous(autonomous)
        DriverStationSim.setEnabled(True)
        run(0.1)
        told.append(DriverStation.getGameSpecificMessage())
    print(
        json.dumps(
            {
                "messages": told,
                "first_inactive": physics.match.rules.hubs.first_inactive,
                "true_way": math.dist(end[:2], start[:2]),
                "odometry_way": after.translation().distance(before.translation()),
                "turned": turned,
                "believed_turn": believed,
                "speed_disabled": speed_disabled,
                "digest": physics.match.digest.hexdigest(),
                "simulated": physics.match.time,
                "wall": time.perf_counter() - begin,
                "lateness_ms": 0.0,
            }
        ),
        flush=True,
    )
    os._exit(0)


if __name__ == "__main__":
    main()
