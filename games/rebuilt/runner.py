"""Plays a scripted auto headless, as fast as the machine can, and reports what came of it.

This is the edge where the wall clock is read: the simulation itself never does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from games.rebuilt.autos import Auto
from games.rebuilt.scripted import ScriptedRobot
from games.rebuilt.sim import DT, RebuiltConfig, RebuiltSim, RobotEntry
from simcore.errors import ConfigError
from simcore.scoring.tracker import Alliance
from simcore.sim.recorder import TickTimer
from simcore.sim.report import RunReport
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

    Returns:
        The run; a Ctrl-C ends it early and cleanly, with everything up to there.

    Raises:
        ConfigError: `seconds` is not a positive finite number.
    """
    if not (math.isfinite(seconds) and seconds > 0.0):
        raise ConfigError(f"seconds must be finite and > 0, got {seconds}")
    base = config or RebuiltConfig()
    entry = RobotEntry(alliance=alliance, pose=auto.start, preload=auto.preload)
    from dataclasses import replace

    wall_start = perf_counter()
    sim = RebuiltSim(replace(base, seed=seed, robots=(entry,)), sinks=sinks)
    code = ScriptedRobot(auto.script, alliance=alliance, held=lambda number: len(sim.pieces.held(number)))
    sim.set_robot_code(0, code)
    fuel_at_start = sim.pieces.state.pos[sim.pieces.on_field()].copy()
    timer = TickTimer()
    path, substeps, awake = [], [], []
    min_volts = math.inf
    interrupted = False
    ticks = max(1, round(seconds / DT))
    run_start = perf_counter()
    try:
        for _ in range(ticks):
            start = perf_counter()
            sim.tick()
            elapsed = perf_counter() - start
            sim.last_tick_ms = 1e3 * elapsed
            timer.add(elapsed)
            path.append(sim.robots[0].chassis.pose)
            substeps.append(sim.substeps)
            awake.append(len(sim.pieces.awake))
            min_volts = min(min_volts, sim.robots[0].battery.voltage)
            if on_tick is not None:
                on_tick(sim)
    except KeyboardInterrupt:
        interrupted = True
    wall = perf_counter() - run_start
    track = np.array(path).reshape(-1, 3)
    report = RunReport(
        auto=auto.name,
        alliance=alliance,
        seed=seed,
        sim_seconds=sim.time,
        startup_seconds=run_start - wall_start,
        wall_seconds=wall,
        ticks=sim.ticks,
        score_red=sim.tracker.totals["red"],
        score_blue=sim.tracker.totals["blue"],
        fuel_staged=sim.fuel.staged,
        fuel_on_field=sim.fuel.on_field,
        fuel_in_flight=sim.fuel.in_flight,
        fuel_held=sim.fuel.held,
        fuel_scored=sim.fuel.scored,
        fuel_outside=sim.fuel.outside,
        shots=len(sim.shots),
        hits=sim.hits,
        distance_m=float(np.linalg.norm(np.diff(track[:, :2], axis=0), axis=1).sum()),
        tick_ms=timer.summary(),
        substeps_mean=float(np.mean(substeps)) if substeps else 0.0,
        substeps_max=max(substeps, default=0),
        awake_mean=float(np.mean(awake)) if awake else 0.0,
        awake_max=max(awake, default=0),
        min_battery_v=min_volts if math.isfinite(min_volts) else sim.robots[0].battery.voltage,
        digest=sim.digest.hexdigest(),
    )
    return AutoRun(report, sim, track, fuel_at_start, interrupted)
