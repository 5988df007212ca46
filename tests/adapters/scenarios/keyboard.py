"""The example in its window on a virtual screen, driven by keys, and the effect of each key on the field.

Argument: the project's folder. The keys go through X, the window's keyboard joystick and the driver station.
"""

from __future__ import annotations

import ctypes
import json
import math
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

from hal import AllianceStationID
from phoenix6 import unmanaged
from robotpy.main import main as robotpy_main
from wpilib.simulation import DriverStationSim

import simcore.robotcode.makers.phoenix6.swerve  # noqa: F401  - as a physics.py does, before the robot is built
from simcore.robotcode.sim.robot_physics import RobotPhysics

running: list[RobotPhysics] = []


def screen() -> str:
    """Start a virtual screen, which ends with this process."""
    read, write = os.pipe()
    subprocess.Popen(
        ["Xvfb", "-displayfd", str(write), "-screen", "0", "1300x740x24"],
        pass_fds=[write],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        preexec_fn=_die_with_parent,
    )
    return f":{os.read(read, 8).decode().strip()}"


def _die_with_parent() -> None:
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG


def xdotool(*words: str) -> str:
    return subprocess.run(["xdotool", *words], capture_output=True, text=True, check=False).stdout.strip()


def look() -> dict[str, float]:
    physics = running[-1]
    robot, (x, y, yaw) = physics.robot_sim, physics.robot_sim.chassis.pose
    return {
        "x": x,
        "y": y,
        "yaw": yaw,
        "hood_deg": math.degrees(robot.mechanisms["hood"].position),
        "intake": robot.mechanisms["intake_deploy"].extended_fraction,
        "shots": len(physics.match.record.shots),
    }


def drive() -> None:
    give_up = time.monotonic() + 40.0
    while not (running and (window := xdotool("search", "--name", "Robot Simulation").split())):
        if time.monotonic() > give_up:
            os._exit(3)
        time.sleep(0.3)
    time.sleep(2.0)
    DriverStationSim.setDsAttached(True)
    DriverStationSim.setEnabled(True)
    DriverStationSim.notifyNewData()
    time.sleep(1.0)
    xdotool("windowfocus", window[0])
    time.sleep(0.3)
    did = {}
    for key, seconds in (
        *(("w", 0.4), ("s", 0.4), ("a", 0.4), ("d", 0.4), ("q", 0.4), ("e", 0.4)),
        *(("period", 0.5), ("comma", 0.3), ("m", 0.2), ("slash", 3.0)),
    ):
        before = look()
        xdotool("keydown", key)
        time.sleep(seconds)
        xdotool("keyup", key)
        time.sleep(0.9)
        did[key] = {name: value - before[name] for name, value in look().items()}
    print(json.dumps({"lateness_ms": 0.0, "did": did, "hits": running[-1].match.record.hits}), flush=True)
    os._exit(0)


def main() -> None:
    folder = Path.cwd() / "project"
    shutil.copytree(sys.argv[1], folder, ignore=shutil.ignore_patterns("ctre_sim", "__pycache__", "networktables*"))
    os.chdir(folder)
    os.environ.update(DISPLAY=screen(), LIBGL_ALWAYS_SOFTWARE="1")
    unmanaged.set_phoenix_diagnostics_start_time(-1)
    DriverStationSim.setAllianceStationId(AllianceStationID.kBlue2)
    DriverStationSim.notifyNewData()
    RobotPhysics.after_tick = lambda physics: running.append(physics) if not running else None
    threading.Thread(target=drive, daemon=True).start()
    sys.argv = ["robotpy", "sim"]
    robotpy_main()


if __name__ == "__main__":
    main()
