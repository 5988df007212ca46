"""Plays a scripted auto headless, as fast as the machine can, and reports what came of it.

This is the edge where the wall clock is read: the simulation itself never does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from games.rebuilt.autos import Auto
from games.rebuilt.scripted import ScriptedRobot
from games.rebuilt.sim import DT, RebuiltConfig, RebuiltSim, RobotEntry
from simcore.errors import ConfigError
from simcore.match.digest import TickTimer
from simcore.match.report import RunReport, Score, Spread
from simcore.match.scoring import Alliance
from simcore.telemetry.snapshot import TelemetrySink
from simcore.typing import FloatArray

__all__ = ["AutoRun", "play_auto"]


@dataclass(slots=True)
class AutoRun:
    """One played auto: the report, and the simulation at its end for pictures and questions. Close `sim` after use."""

    report: RunReport
    sim: RebuiltSim
    path: FloatArray
    """Of the robot, a row a tick: x, y, yaw [m, m, rad]."""
    fuel_at_start: FloatArray
    """Places of all fuel on the field [m], shape (n, 3)."""
    was_interrupted: bool


def play_auto(
    auto: Auto,
    *,
    alliance: Alliance = "blue",
    seconds: float = 20.0,
    config: RebuiltConfig | None = None,
    seed: int = 0,
    sinks: Sequence[TelemetrySink] = (),
    on_tick: Callable[[RebuiltSim], None] | None = None,
    should_stop: Callable[[], bool] = lambda: False,
) -> AutoRun:
    """Play an auto.

    Args:
        auto: What the robot does.
        alliance: Whose robot; a red one does the same, turned by 180 degrees.
        seconds: How long, simulated [s].
        config: Field, fuel, limits; its robots and seed are replaced.
        seed: Of everything left to chance.
        sinks: Who wants telemetry.
        on_tick: Called after each tick, e.g. for a progress bar.
        should_stop: Asked before each tick; True ends the run early, with everything up to there.

    Returns:
        The run.

    Raises:
        ConfigError: `seconds` is not a positive finite number.
    """
    if not (math.isfinite(seconds) and seconds > 0.0):
        raise ConfigError(f"seconds must be finite and > 0, got {seconds}")
    base = config or RebuiltConfig()
    entry = RobotEntry(alliance=alliance, pose=auto.start, preload=auto.preload)
    wall_start = perf_counter()
    try:
        sim = RebuiltSim(replace(base, seed=seed, robots=(entry,)), sinks=sinks)
    except BaseException:
        for sink in sinks:
            sink.close()
        raise
    try:
        return _play(sim, auto, alliance, seed, seconds, wall_start, on_tick, should_stop)
    except BaseException:  # a script's own error passes through, with the log up to it on the disk
        sim.close()
        raise


def _play(
    sim: RebuiltSim,
    auto: Auto,
    alliance: Alliance,
    seed: int,
    seconds: float,
    wall_start: float,
    on_tick: Callable[[RebuiltSim], None] | None,
    should_stop: Callable[[], bool],
) -> AutoRun:
    code = ScriptedRobot(
        auto.script,
        alliance=alliance,
        held=lambda number: len(sim.pieces.held(number)),
        fuel_places=lambda: sim.pieces.state.pos[sim.pieces.on_field()],
    )
    sim.set_robot_code(0, code)
    fuel_at_start = sim.pieces.state.pos[sim.pieces.on_field()].copy()
    timer = TickTimer()
    path, substeps, awake = [], [], []
    interrupted = False
    ticks = max(1, round(seconds / DT))
    run_start = perf_counter()
    for _ in range(ticks):
        if should_stop():
            interrupted = True
            break
        start = perf_counter()
        sim.tick()
        elapsed = perf_counter() - start
        sim.last_tick_ms = 1e3 * elapsed
        timer.add(elapsed)
        path.append(sim.robots[0].chassis.pose)
        substeps.append(sim.substeps)
        awake.append(len(sim.pieces.awake))
        if on_tick is not None:
            on_tick(sim)
    wall = perf_counter() - run_start
    track = np.array(path).reshape(-1, 3)
    blue, red = sim.tracker.totals["blue"], sim.tracker.totals["red"]
    report = RunReport(
        auto=auto.name,
        alliance=alliance,
        seed=seed,
        sim_seconds=sim.time,
        startup_seconds=run_start - wall_start,
        wall_seconds=wall,
        realtime_factor=sim.time / wall,
        ticks=sim.ticks,
        score=Score(red=red, blue=blue, total=red + blue),
        fuel=sim.fuel,
        shots=len(sim.shots),
        hits=sim.hits,
        distance_m=float(np.linalg.norm(np.diff(track[:, :2], axis=0), axis=1).sum()),
        tick_ms=timer.times(),
        substeps=Spread(mean=float(np.mean(substeps or [0])), max=max(substeps, default=0)),
        awake=Spread(mean=float(np.mean(awake or [0])), max=max(awake, default=0)),
        min_battery_v=sim.robots[0].battery.min_voltage,
        digest=sim.digest.hexdigest(),
    )
    return AutoRun(report, sim, track, fuel_at_start, interrupted)
