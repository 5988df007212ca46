"""Play an auto of a program over the bridge and print the result: `play.py FILE.toml SECONDS COMMAND ...`."""

import json
import sys
import time
from pathlib import Path

from simcore.bridge.robot_process import RobotProcess
from simcore.bridge.served_robot import ServedRobot
from simcore.season import ntcore

ntcore.NetworkTableInstance.get_default().start_local()
file, seconds, command = Path(sys.argv[1]), float(sys.argv[2]), sys.argv[3:]
with RobotProcess(command, patience=60.0, hang=20.0) as process, ServedRobot(process, file) as sim:
    sim.start()
    begin = time.perf_counter()
    sim.autonomous(seconds=seconds)
    wall = time.perf_counter() - begin
    places = {name: m.position for name, m in sim.robot_sim.mechanisms.items()}
    print(json.dumps({"digest": sim.digest, "pose": sim.robot_sim.chassis.pose, "wall": wall, **places}))
