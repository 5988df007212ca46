"""Measure the time of a tick: `python scripts/bench.py [--json] [--seconds S] [--against COMMIT] [scenario ...]`.

Each scenario is played on a fixed seed; a check next to each figure shows that the work was done. For games with pieces
that are not balls, the time inside the engine's step is measured, too.

With `--against`, a commit's package is measured as well, in turns with this one and in separate processes. The shortest
time of each tick over all turns counts, because a busy machine only adds time.
"""

from __future__ import annotations

import argparse
import io
import json
import math
import os
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from time import perf_counter
from typing import Any

import ntcore
import numpy as np
from rich.console import Console
from rich.table import Table

from games.rebuilt import REBUILT, RebuiltSim
from games.rebuilt.robot import rebuilt_robot
from games.rebuilt.staging import Staging
from games.reefscape import REEFSCAPE
from simcore.match.game import RobotEntry
from simcore.match.match import Match
from simcore.match.players.lineup import entries, lineup, take_seats
from simcore.match.scripted import ScriptedRobot, Steps
from simcore.pieces.pool import PieceStatus
from simcore.robotcode.networktables.limelight_table import CameraTables
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import TelemetrySink
from simcore.telemetry.wpilog import WpilogSink
from simcore.typing import FloatArray
from simcore.units import TICK
from simcore.vision.camera import CameraConfig, CameraMount, PiecePipeline, limelight_type
from simcore.world.engine_choice import add_engine_option, make_engine

JAVA_MS = {"real-use": 1.26, "churn": 1.81, "rest": 0.82, "shooting": 6.8}
"""Tick medians of the Java original on this class of machine, quiet [ms]."""

_WARM_UP = 25  # ticks before the measurement
ROOT = Path(__file__).resolve().parents[1]

CAMERAS = (
    CameraConfig(
        name="limelight-two",
        type=limelight_type("LL4"),
        mount=CameraMount(x=0.28, y=-0.24, z=0.35, pitch_deg=-20.0, yaw_deg=-15.0),
    ),
    CameraConfig(
        name="limelight-five",
        type=limelight_type("LL3"),
        mount=CameraMount(x=0.28, y=0.24, z=0.35, pitch_deg=-20.0, yaw_deg=15.0),
    ),
    CameraConfig(
        name="limelight-one",
        type=limelight_type("LL3"),
        mount=CameraMount(x=-0.30, z=0.48, pitch_deg=25.0, yaw_deg=180.0),
        pipelines=(PiecePipeline(near=0.2, far=4.0),),
        frame_rate=5.0,
    ),
)
"""Cameras of the example robot."""


ENGINE: list[str | None] = [None]
"""Name of the measured engine."""


class TimedEngine:
    """Engine that measures the time of its steps."""

    def __init__(self) -> None:
        self._engine = make_engine(ENGINE[0])
        self.stepping = 0.0
        self._clock = perf_counter
        for name in dir(self._engine):  # bound once: lookups at each call cost 2 % of a tick
            if not name.startswith("_") and name != "step":
                setattr(self, name, getattr(self._engine, name))

    def step(self, h: float) -> None:
        """Advance, and add the time taken."""
        start = self._clock()
        self._engine.step(h)
        self.stepping += self._clock() - start


def _lanes(robot: ScriptedRobot) -> Steps:
    """Drive back and forth through the neutral zone at 3 m/s."""
    while True:
        for y in (2.2, 3.4, 4.6, 5.8):
            yield from robot.drive_through([(5.9, y), (10.6, y)], 0.0, speed=3.0, timeout=4.0)
            yield from robot.drive_through([(10.6, y), (5.9, y)], 0.0, speed=3.0, timeout=4.0)


def _match(
    engine: TimedEngine,
    pose: tuple[float, float, float] = (6.0, 2.2, 0.0),
    script: Any = None,
    never_sleep: bool = False,
    cameras: tuple[CameraConfig, ...] = (),
    network: Any = None,
) -> Match:
    entry = RobotEntry(start=pose, preload=0, config=replace(rebuilt_robot(), cameras=cameras))
    staging = Staging(neutral=360, depot=24, chute=0, preload_per_robot=0, robots=1)
    match = RebuiltSim(
        seed=1, robots=(entry,), staging=staging, never_sleep=never_sleep, engine=engine, network=network
    )
    if script is not None:
        match.set_controller(0, ScriptedRobot(script, match, "blue"))
    return match


def _play(match: Match, engine: TimedEngine, seconds: float, before: Callable[[int], None]) -> dict[str, Any]:
    ticks, steps, awake, substeps = [], [], [], []
    start_pos = match.pieces.state.pos.copy()
    for number in range(round(seconds / TICK)):
        before(number)
        engine.stepping = 0.0
        start = perf_counter()
        match.tick()
        elapsed = perf_counter() - start
        if number >= _WARM_UP:
            ticks.append(1e3 * elapsed)
            steps.append(1e3 * engine.stepping)
            awake.append(len(match.pieces.awake))
            substeps.append(match.substeps)
    moved = np.linalg.norm(match.pieces.state.pos - start_pos, axis=1) > 0.1
    robot = match.robots[0]
    tick, step = np.array(ticks), np.array(steps)
    return {
        "tick_ms": _spread(tick),
        "engine_ms": _spread(step),
        "ticks_ms": ticks,
        "substeps_mean": round(float(np.mean(substeps)), 2),
        "awake": {"mean": round(float(np.mean(awake)), 1), "max": max(awake)},
        "check": {
            "pieces_moved": int(moved.sum()),
            "robot_height_mm": round(1e3 * robot.chassis.pos[2], 1),
            "pieces_below_carpet": int((match.pieces.state.pos[match.pieces.on_field(), 2] < 0.05).sum()),
            "recovered": match.pieces.recovered,
            "conserved": match.count.is_conserved,
        },
    }


def _spread(milliseconds: FloatArray) -> dict[str, float]:
    values = np.percentile(milliseconds, (50, 95, 99, 100)).round(3).tolist()
    return dict(zip(("median", "p95", "p99", "max"), values, strict=True))


def real_use(seconds: float) -> dict[str, Any]:
    """Drive a robot through the neutral zone at 3 m/s, with 408 fuel."""
    engine = TimedEngine()
    with _match(engine, script=_lanes) as match:
        path: list[float] = []
        return _play(match, engine, seconds, lambda number: path.append(match.robots[0].chassis.speed)) | {
            "robot_speed_mean": round(float(np.mean(path)), 2)
        }


def churn(seconds: float) -> dict[str, Any]:
    """Keep all 408 fuel awake, each kicked with 2 m/s every second."""
    engine = TimedEngine()
    rng = np.random.default_rng(2)
    with _match(engine, pose=(2.5, 2.5, 0.0), never_sleep=True) as match:  # without sleep

        def kick(number: int) -> None:
            if number % 50 == 0:
                slots = match.pieces.on_field()
                angle = rng.uniform(0.0, math.tau, len(slots))
                match.pieces.push(slots, 2.0 * np.column_stack((np.cos(angle), np.sin(angle), np.zeros(len(slots)))))

        return _play(match, engine, seconds, kick)


def rest(seconds: float) -> dict[str, Any]:
    """Leave 408 fuel asleep and a robot at rest."""
    engine = TimedEngine()
    with _match(engine, pose=(2.5, 2.5, 0.0)) as match:
        return _play(match, engine, seconds, lambda number: None)


def shooting(seconds: float) -> dict[str, Any]:
    """Shoot 16 fuel per second at 12 m/s from a robot that drives through the neutral zone."""
    engine = TimedEngine()
    shots = 0
    with _match(engine, script=_lanes) as match:

        def shoot(number: int) -> None:
            nonlocal shots
            if number % 25 not in (0, 6, 12, 18):  # 8 events per second with two fuel each
                return
            scored = np.nonzero(match.pieces.state.status == PieceStatus.SCORED)[0]
            supply = scored if len(scored) >= 2 else match.pieces.on_field()[-2:]
            match.pieces.hold(supply[:2], 0)
            robot = match.robots[0]
            x, y, yaw = robot.chassis.pose
            # at the blue hub, at 12 m/s
            toward = math.atan2(4.03 - y, 4.63 - x)
            for side in (0.08, -0.08):
                at = (
                    x + 0.168 * math.cos(yaw) - side * math.sin(yaw),
                    y + 0.168 * math.sin(yaw) + side * math.cos(yaw),
                )
                level, up = 12.0 * math.cos(math.radians(50.0)), 12.0 * math.sin(math.radians(50.0))
                match.pieces.launch(0, (*at, 0.65), (level * math.cos(toward), level * math.sin(toward), up))
                shots += 1

        result = _play(match, engine, seconds, shoot)
        result["check"]["shots"] = shots
        return result


def cameras(seconds: float) -> dict[str, Any]:
    """Play `real_use` with three publishing cameras (60, 30 and 5 frames/s), and a heading sent every tick."""
    engine = TimedEngine()
    tables = ntcore.NetworkTableInstance.create()
    tables.startLocal()
    sends = [tables.getDoubleArrayTopic(f"/{c.name}/robot_orientation_set").publish() for c in CAMERAS[:2]]
    with _match(engine, script=_lanes, cameras=CAMERAS, network=CameraTables(tables)) as match:
        spent: list[float] = []
        frames: list[int] = []
        tags = 0

        def timed(name: str) -> None:
            inner = getattr(match.cameras, name)

            def call(time: float) -> None:
                start = perf_counter()
                inner(time)
                spent[-1] += 1e3 * (perf_counter() - start)

            setattr(match.cameras, name, call)

        timed("listen")
        timed("expose" if hasattr(match.cameras, "expose") else "look")

        def send(number: int) -> None:
            nonlocal tags
            spent.append(0.0)
            for topic in sends:
                topic.set([math.degrees(match.robots[0].gyro.yaw), 0.0, 0.0, 0.0, 0.0, 0.0])
            seen = [camera.last for camera in match.cameras.cameras.values() if camera.last is not None]
            frames.append(sum(frame.number for frame in seen))
            tags += sum(len(frame.tags) for frame in seen)

        result = _play(match, engine, seconds, send)
        cost = np.array(spent[_WARM_UP:])
        result["vision_ms"] = {"mean": round(float(cost.mean()), 3)} | _spread(cost)
        result["check"] |= {
            "vision_ms": result["vision_ms"],
            "frames_a_tick": round((frames[-1] - frames[0]) / len(frames), 2),
            "tags_in_sight": round(tags / len(frames), 1),
            "pieces_seen": len(match.cameras.camera(CAMERAS[2].name).last.pieces),  # type: ignore[union-attr]
        }
    ntcore.NetworkTableInstance.destroy(tables)
    return result


def reefscape_rest(seconds: float) -> dict[str, Any]:
    """Leave all pieces of REEFSCAPE and a robot at rest."""
    engine = TimedEngine()
    with Match(REEFSCAPE, robots=[RobotEntry(start=(2.5, 2.5, 0.0))], seed=1, engine=engine) as match:
        return _play(match, engine, seconds, lambda number: None)


def reefscape_auto(_seconds: float) -> dict[str, Any]:
    """Play REEFSCAPE's first auto: three coral on level 4 within its 15 s."""
    engine, auto = TimedEngine(), REEFSCAPE.auto(None)
    with Match(REEFSCAPE, robots=[RobotEntry(start=auto.start)], seed=1, engine=engine) as match:
        match.set_controller(0, auto.controller(match, "blue"))
        result = _play(match, engine, 15.0, lambda number: None)
        result["check"]["points"] = match.score.total
        return result


def six_robots(seconds: float) -> dict[str, Any]:
    """Drive six robots back and forth through 360 fuel in the neutral zone, each in its lane."""
    engine = TimedEngine()

    def lane(y: float) -> Callable[[ScriptedRobot], Steps]:
        def script(robot: ScriptedRobot) -> Steps:
            while True:
                yield from robot.drive_through([(5.9, y), (10.6, y)], 0.0, speed=3.0, timeout=4.0)
                yield from robot.drive_through([(10.6, y), (5.9, y)], 0.0, speed=3.0, timeout=4.0)

        return script

    lanes = [1.2 + 1.13 * k for k in range(6)]
    robots = [RobotEntry(start=(5.9, y, 0.0), preload=0, alliance="blue" if y < 4.0 else "red") for y in lanes]
    staging = Staging(neutral=360, depot=24, chute=0, preload_per_robot=0, robots=6)
    with RebuiltSim(seed=1, robots=robots, staging=staging, engine=engine) as match:
        for number, y in enumerate(lanes):
            match.set_controller(number, ScriptedRobot(lane(y), match, "blue"))
        return _play(match, engine, seconds, lambda number: None)


def whole_match(seconds: float, sinks: Sequence[TelemetrySink] = ()) -> dict[str, Any]:
    """Play the first seconds of a match of six scripted players."""
    engine = TimedEngine()
    seats = lineup(REBUILT, red="collector:3,collector:2,defender", blue="collector:3,shuttle,climber")
    options = [option.name for option in REBUILT.options if option.in_matches]
    with Match(REBUILT, robots=entries(REBUILT, seats), seed=4, options=options, engine=engine, sinks=sinks) as match:
        take_seats(match, seats)
        result = _play(match, engine, seconds, lambda number: None)
        result["check"] |= {"points": match.score.total, "taken_in": len(match.record.taken_in)}
        return result


def recorded_match(seconds: float) -> dict[str, Any]:
    """Play `whole_match` with a log and a recording, like `simcore play`."""
    with tempfile.TemporaryDirectory(prefix="simcore-bench-") as folder:
        log, recording = WpilogSink(Path(folder, "match.wpilog")), Recording()
        result = whole_match(seconds, [log, recording])
        result["check"] |= {"log_bytes": log.path.stat().st_size, "rows": len(recording)}
        return result


def start_up(_seconds: float) -> dict[str, Any]:
    """Start new interpreters and measure up to the end of the first tick, imports included."""
    code = "from games.rebuilt import RebuiltSim; s = RebuiltSim(); s.tick(); print(s.count.staged)"
    times = []
    for _ in range(3):
        start = perf_counter()
        out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        times.append(perf_counter() - start)
        assert out.stdout.strip() == "504"
    return {"seconds": {"median": round(float(np.median(times)), 3), "max": round(max(times), 3)}}


def robot_test(_seconds: float) -> dict[str, Any]:
    """Run all tests of the example robot, as its team does."""
    if find_spec("phoenix6") is None or find_spec("wpilib") is None:
        return {"check": "needs phoenix6: pip install .[phoenix6,robotpy]"}
    command = [sys.executable, "-m", "robotpy", "test", "--", "-q", "-p", "no:cacheprovider"]
    start = perf_counter()
    out = subprocess.run(command, cwd=ROOT / "examples/rebuilt_robot", capture_output=True, text=True, check=True)
    words = next(line for line in out.stdout.splitlines() if " passed" in line)
    return {"seconds": {"median": round(perf_counter() - start, 2)}, "check": words}


def on_mujoco(scenario: Callable[[float], dict[str, Any]]) -> Callable[[float], dict[str, Any]]:
    """Return a scenario that plays on MuJoCo."""

    def play(seconds: float) -> dict[str, Any]:
        before, ENGINE[0] = ENGINE[0], "mujoco"
        try:
            return scenario(seconds)
        finally:
            ENGINE[0] = before

    return play


SCENARIOS: dict[str, Callable[[float], dict[str, Any]]] = {
    "real-use": real_use,
    "churn": churn,
    "rest": rest,
    "shooting": shooting,
    "cameras": cameras,
    "reefscape-rest": reefscape_rest,
    "reefscape-auto": reefscape_auto,
    "six-robots": six_robots,
    "match": whole_match,
    "recorded-match": recorded_match,
    "mujoco-reefscape-auto": on_mujoco(reefscape_auto),
    "robot-test": robot_test,
    "start-up": start_up,
}


def compare(
    commit: str, names: list[str], seconds: float, rounds: int, engine: str | None
) -> dict[str, dict[str, Any]]:
    """Compare the ticks of this package with those of a commit, by scenario: medians and means [ms], and their ratios.

    Raises:
        SystemExit: If there is no such commit.
    """
    best: dict[tuple[str, str], FloatArray] = {}
    with tempfile.TemporaryDirectory(prefix="simcore-bench-") as folder:
        packed = subprocess.run(["git", "archive", commit], cwd=ROOT, capture_output=True, check=False)
        if packed.returncode:
            raise SystemExit(f"no commit {commit!r} to compare with: {packed.stderr.decode().strip()}")
        with tarfile.open(fileobj=io.BytesIO(packed.stdout)) as tar:
            tar.extractall(folder, filter="data") if hasattr(tarfile, "data_filter") else tar.extractall(folder)
        for _ in range(rounds):
            for side, root in (("before", folder), ("now", str(ROOT))):
                environment = {**os.environ, "PYTHONPATH": root} | ({"SIMCORE_ENGINE": engine} if engine else {})
                script = str(Path(root, "scripts", "bench.py"))  # each side has its own
                command = [sys.executable, script, "--json", "--seconds", str(seconds), *names]
                out = subprocess.run(command, cwd=root, env=environment, capture_output=True, text=True, check=False)
                if out.returncode:
                    raise SystemExit(f"the scenarios do not run {side}:\n{out.stderr[-1500:]}")
                for name, result in json.loads(out.stdout).items():
                    ticks = np.array(result.get("ticks_ms") or [1e3 * result["seconds"]["median"]])
                    best[name, side] = np.minimum(best.get((name, side), np.inf), ticks)
    return {name: _compared(best[name, "before"], best[name, "now"]) for name in names}


def _compared(before: FloatArray, now: FloatArray) -> dict[str, Any]:
    medians, means = ([round(float(of(side)), 3) for side in (before, now)] for of in (np.median, np.mean))
    return {
        "median_ms": medians,
        "mean_ms": means,
        "ratio": round(medians[1] / medians[0], 3),
        "ratio_of_means": round(means[1] / means[0], 3),
    }


def main() -> int:
    """Run the scenarios and print a table, or JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", nargs="*", help="default: all")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--seconds", type=float, default=12.0, help="simulated time of each (default: 12)")
    parser.add_argument("--against", metavar="COMMIT", help="measure that commit as well, in turns, and print ratios")
    parser.add_argument("--rounds", type=int, default=3, help="turns with --against (default: 3)")
    add_engine_option(parser)
    options = parser.parse_args()
    ENGINE[0] = options.engine
    if options.against is not None:
        names = options.scenario or ["real-use", "churn", "rest", "six-robots", "match"]
        ratios = compare(options.against, names, options.seconds, options.rounds, options.engine)
        for name, r in ratios.items():
            print(json.dumps({name: r}) if options.json else f"{name:18} {r}")
        return 0
    results = {name: SCENARIOS[name](options.seconds) for name in options.scenario or SCENARIOS}
    if options.json:
        print(json.dumps(results))
        return 0
    for r in results.values():
        r.pop("ticks_ms", None)
    table = Table(title="Tick of 20 ms, in milliseconds", title_justify="left")
    for column in ("scenario", "median", "p95", "p99", "max", "engine", "awake", "sub-steps", "Java"):
        table.add_column(column, justify="left" if column == "scenario" else "right")
    for name, r in results.items():
        if "tick_ms" not in r:
            continue
        t, java = r["tick_ms"], JAVA_MS.get(name)
        table.add_row(
            name, *(f"{t[k]:.2f}" for k in ("median", "p95", "p99", "max")), f"{r['engine_ms']['median']:.2f}",
            f"{r['awake']['mean']:.0f}", f"{r['substeps_mean']:.1f}",
            "" if java is None else f"{java:.2f}",
        )  # fmt: skip
    console = Console(width=None if sys.stdout.isatty() else 110)
    console.print(table)
    for name, r in results.items():
        console.print(f"{name}: {r.get('check', r)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
