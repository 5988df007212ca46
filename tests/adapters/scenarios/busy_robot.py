"""Runs the robot of a folder under `robotpy sim --simcore --nogui` beside busy processes, and tells of its physics.

Arguments: the folder; how many processes compute beside it.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time

COMPUTE = "import time\nend = time.time() + 160\nwhile time.time() < end: pass"
SLOW = 50  # number of the robot's loop that takes 2.5 s; 125 more follow at once to make up for it
LOOPS = 250  # that are waited for
LAST = 150.0  # [s]


def main() -> None:
    os.chdir(sys.argv[1])
    others = [subprocess.Popen([sys.executable, "-c", COMPUTE]) for _ in range(int(sys.argv[2]))]
    threading.Thread(target=watch, args=(others,), daemon=True).start()
    sys.argv = ["robotpy", "sim", "--simcore", "--nogui"]
    sys.path.insert(0, os.getcwd())
    from robotpy.main import main as robotpy_main

    robotpy_main()


def watch(others: list[subprocess.Popen[bytes]]) -> None:
    from simcore.robotpy.robot_physics import latest_physics

    ticks: list[int] = []
    ticks_before = 0
    begin, physics = time.monotonic(), None
    while time.monotonic() - begin < LAST and (physics is None or getattr(physics.robot, "loops", 0) < LOOPS):
        time.sleep(0.25)
        physics = latest_physics()
        if physics is not None:
            ticks.append(physics.times.ticks)
            if getattr(physics.robot, "loops", 0) <= SLOW:
                ticks_before = ticks[-1]
    for other in others:
        other.kill()
    result = {
        "ticks": ticks[-1] if ticks else 0,
        "ticks_after": ticks[-1] - ticks_before if ticks else 0,
        "stalls": max((k for k in range(len(ticks)) if len(ticks) > k and ticks[-1 - k] == ticks[-1]), default=0),
        "skipped": physics.times.skipped,
        "has_cameras": hasattr(physics, "cameras"),
        "loops": getattr(physics.robot, "loops", 0),
        "lateness_ms": 0.0,
    }
    print("\n" + json.dumps(result), flush=True)
    os._exit(0)


if __name__ == "__main__":
    main()
