"""Play teleop of programs/ports.py with a gamepad and print the true state: `play_ports.py FILE.toml COMMAND ...`."""

import json
import sys
from pathlib import Path

from simcore.bridge.robot_process import RobotProcess
from simcore.bridge.served_robot import ServedRobot
from simcore.season import ntcore, wpilib_simulation

ntcore.NetworkTableInstance.get_default().start_local()
with (
    RobotProcess(sys.argv[2:], patience=60.0, hang=20.0) as process,
    ServedRobot(process, Path(sys.argv[1])) as sim,
):
    sim.alliance("red", 2)
    sim.game_data("LRL")
    pad = sim.xbox()
    pad.left_x, pad.a = -0.5, True
    sim.teleop(seconds=2.0)
    truth = {name: m.position for name, m in sim.robot_sim.mechanisms.items()}
    truth |= {"heading": sim.robot_sim.gyro.yaw, "battery": sim.battery.voltage, "warnings": sim.warnings}
    truth |= {"lamp": wpilib_simulation.DIOSim(5).getValue(), "kicks": sim.robot_sim.mechanisms["kicker"].velocity}
    print("TRUTH", json.dumps(truth))
