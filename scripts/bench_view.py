"""What it costs to be watched: `python scripts/bench_view.py [--seconds S] [publish|log|view ...]`.

publish: all keys of a tick to NetworkTables, with a client that takes them all, and to a log; 504 fuel, all rolling.
log: a whole match of 160 s, driven without a pause: how large its log is, and how long the replay takes to open it.
view: a frame of the browser view with 504 fuel, all moved: our time, and what goes to each browser.
"""

from __future__ import annotations

import argparse
import math
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter, sleep
from typing import Any

import ntcore
import numpy as np
import viser

from games.rebuilt import REBUILT, RebuiltSim
from games.rebuilt.fuel import FUEL
from games.rebuilt.staging import Staging
from simcore.match.game import RobotEntry
from simcore.match.scripted import ScriptedRobot, Steps
from simcore.pieces.pool import PieceStatus
from simcore.show.replay import smooth_snapshot
from simcore.show.view_models import load_models
from simcore.show.view_page import ViewPage
from simcore.telemetry.networktables_sink import NetworkTablesSink, start_local_server
from simcore.telemetry.snapshot import Snapshot
from simcore.telemetry.wpilog import WpilogSink, read_log
from simcore.units import TICK

_WARM_UP = 25  # ticks

_CLIENT = """
import sys, time, ntcore
inst = ntcore.NetworkTableInstance.create()
everything = ntcore.MultiSubscriber(inst, ["/"], ntcore.PubSubOptions(sendAll=True, periodic=0.02))
inst.startClient4("bench")
inst.setServer("127.0.0.1", int(sys.argv[1]))
time.sleep(1000)
"""

_READER = """
import sys, threading
from websockets.sync.client import connect
counts = [0, 0]
def read():
    with connect(sys.argv[1], subprotocols=[f"viser-v{sys.argv[2]}"], max_size=None, compression=None) as socket:
        for message in socket:
            counts[0] += 1
            counts[1] += len(message)
threading.Thread(target=read, daemon=True).start()
sys.stdin.readline()
before = list(counts)
sys.stdin.readline()
print(counts[0] - before[0], counts[1] - before[1])
"""


def rolling(seconds: float) -> Iterator[Snapshot]:
    """Snapshots of 504 fuel on the carpet, all kicked once a second so that none stands."""
    staging = Staging(neutral=408, depot=24, chute=24, preload_per_robot=0, robots=1)
    rng = np.random.default_rng(3)
    entry = RobotEntry(preload=0)
    with RebuiltSim(seed=1, robots=(entry,), staging=staging, never_sleep=True) as match:
        outside = np.nonzero(match.pieces.state.status == PieceStatus.STAGED)[0]  # in the chutes: out with it
        places = [(12.5 + 0.25 * (i % 8), 2.0 + 0.25 * (i // 8), FUEL.rest_height) for i in range(len(outside))]
        match.pieces.release(outside, np.array(places))
        for number in range(round(seconds / TICK)):
            if number % 50 == 0:
                slots = match.pieces.on_field()
                angle = rng.uniform(0.0, math.tau, len(slots))
                match.pieces.push(slots, np.column_stack((np.cos(angle), np.sin(angle), np.zeros(len(slots)))))
            match.tick()
            yield match.snapshot()


def spread(times: list[float]) -> dict[str, float]:
    """Milliseconds."""
    values = (1e3 * np.percentile(times[_WARM_UP:], (50, 95, 99))).round(3).tolist()
    return dict(zip(("median", "p95", "p99"), values, strict=True))


def publish(seconds: float) -> dict[str, Any]:
    """The two sinks together."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    server = ntcore.NetworkTableInstance.create()
    start_local_server(server, port=port)
    client = subprocess.Popen([sys.executable, "-c", _CLIENT, str(port)])
    times, fuel = [], 0
    try:
        with tempfile.TemporaryDirectory() as folder:
            with WpilogSink(Path(folder) / "bench.wpilog") as log:
                tables = NetworkTablesSink(server)
                for snapshot in rolling(seconds):
                    start = perf_counter()
                    tables.write(snapshot)
                    log.write(snapshot)
                    times.append(perf_counter() - start)
                    fuel = len(snapshot.pose_arrays["Sim/GamePieces/Fuel"])
    finally:
        client.kill()
        server.stopServer()
    return {"ms a tick": spread(times), "fuel": fuel}


def _lanes(robot: ScriptedRobot) -> Steps:
    """Back and forth through the neutral zone at 3 m/s."""
    while True:
        for y in (2.2, 3.4, 4.6, 5.8):
            yield from robot.drive_through([(5.9, y), (10.6, y)], 0.0, speed=3.0, timeout=4.0)
            yield from robot.drive_through([(10.6, y), (5.9, y)], 0.0, speed=3.0, timeout=4.0)


def log(_seconds: float) -> dict[str, Any]:
    """Always 160 simulated seconds."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "match.wpilog"
        entry = RobotEntry(start=(6.0, 2.2, 0.0))
        with RebuiltSim(seed=1, robots=(entry,), sinks=[WpilogSink(path)]) as match:
            match.play(160.0, controllers=[ScriptedRobot(_lanes, match, "blue")])
        start = perf_counter()
        read = read_log(path)
        opened = perf_counter() - start
        start = perf_counter()
        for i in range(200):
            smooth_snapshot(read, 0.8 * i)
        seek = (perf_counter() - start) / 200
        return {
            "MB": round(path.stat().st_size / 1e6, 1),
            "seconds to open": round(opened, 2),
            "ms to seek": round(1e3 * seek, 2),
            "values": sum(len(column) for column in read.columns.values()),
        }


def view(seconds: float) -> dict[str, Any]:
    """Thirty frames a second to one reader, who counts what comes; what a browser makes of it is its own work."""
    times: list[float] = []
    with ViewPage(load_models(REBUILT.models)) as page:
        command = [sys.executable, "-c", _READER, page.url.replace("http", "ws"), viser.__version__]
        reader = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        snapshots = list(rolling(seconds))
        assert reader.stdin is not None
        start_all = perf_counter()
        for number, snapshot in enumerate(snapshots):
            start = perf_counter()
            page.show(snapshot)
            times.append(perf_counter() - start)
            if number == _WARM_UP:
                reader.stdin.write("count\n")
                reader.stdin.flush()
            sleep(max(0.0, start_all + (number + 1) / 30.0 - perf_counter()))
        wall = perf_counter() - start_all
        out, _ = reader.communicate("stop\n")
    messages, size = (int(word) for word in out.split())
    frames = len(times) - _WARM_UP
    return {
        "ms a frame": spread(times),
        "frames a second": round(len(times) / wall, 1),
        "websocket messages a frame": round(messages / frames, 2),
        "kB a frame": round(size / frames / 1e3, 1),
    }


SCENARIOS = {"publish": publish, "log": log, "view": view}


def main() -> int:
    """Print one line for each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", nargs="*", choices=[[], *SCENARIOS], help="default: all")
    parser.add_argument("--seconds", type=float, default=8.0, help="simulated time of publish and view (default: 8)")
    options = parser.parse_args()
    for name in options.scenario or SCENARIOS:
        print(f"{name}: {SCENARIOS[name](options.seconds)}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
