"""Plays an auto headless, as fast as the machine can, and reports what came of it.

The wall clock is read here, for the figures of the report; no time of it reaches the simulation.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from simcore.match.game import Auto, Game, RobotEntry
from simcore.match.match import Match
from simcore.match.report import RunReport, Spread
from simcore.match.run_record import TickTimer
from simcore.match.scoring import Alliance
from simcore.quantities import DURATION, require
from simcore.robot.robot_config import RobotConfig
from simcore.telemetry.snapshot import Snapshot, TelemetrySink
from simcore.typing import FloatArray
from simcore.units import TICK

__all__ = ["AutoRun", "play_auto", "play_robots"]


@dataclass(slots=True)
class AutoRun:
    """One played auto: the report, and the match at its end for pictures and questions. Close `match` after use."""

    report: RunReport
    match: Match
    path: FloatArray
    """Of the robot, a row a tick: x, y, yaw [m, m, rad]."""
    pieces_at_start: FloatArray
    """Places of all pieces on the field [m], shape (n, 3)."""
    was_interrupted: bool


def play_auto(
    game: Game,
    auto: Auto | str | None = None,
    *,
    alliance: Alliance = "blue",
    seconds: float | None = None,
    seed: int = 0,
    robot: RobotConfig | None = None,
    options: Iterable[str] = (),
    field_mesh: Path | None = None,
    sinks: Sequence[TelemetrySink] = (),
    on_tick: Callable[[Match], None] | None = None,
    should_stop: Callable[[], bool] = lambda: False,
    **settings: Any,
) -> AutoRun:
    """Play an auto.

    Args:
        game: Of which.
        auto: What the robot does, or its name; None: the game's first.
        alliance: Whose robot; a red one does the same under the field's symmetry.
        seconds: How long, simulated [s]; None: as long as the game's auto.
        seed: Of everything left to chance.
        robot: In place of the game's own.
        options: Of the game that are on.
        field_mesh: An OBJ of the field in place of the game's own.
        sinks: Who wants telemetry.
        on_tick: Called after each tick, e.g. for a progress bar.
        should_stop: Asked before each tick; True ends the run early, with everything up to there.
        settings: Further arguments of `Match`.

    Returns:
        The run.

    Raises:
        ConfigError: `seconds` is not a positive finite number, or the match cannot be.
        UnknownNameError: No auto of that name.
    """
    chosen = auto if isinstance(auto, Auto) else game.auto(auto)
    length = seconds if seconds is not None else auto_seconds(game)
    require("an auto", "seconds", length, DURATION)
    entry = RobotEntry(alliance=alliance, start=chosen.start, preload=chosen.preload, config=robot)
    return play_robots(
        game,
        (entry,),
        lambda match: match.set_controller(0, chosen.controller(match, alliance)),
        name=chosen.name,
        seconds=length,
        seed=seed,
        options=options,
        field_mesh=field_mesh,
        sinks=sinks,
        on_tick=on_tick,
        should_stop=should_stop,
        **settings,
    )


def play_robots(
    game: Game,
    robots: Sequence[RobotEntry],
    set_controllers: Callable[[Match], None],
    *,
    name: str,
    seconds: float,
    players: Sequence[str] = (),
    sinks: Sequence[TelemetrySink] = (),
    on_tick: Callable[[Match], None] | None = None,
    should_stop: Callable[[], bool] = lambda: False,
    **settings: Any,
) -> AutoRun:
    """Play with robots, as `play_auto` does with one.

    Args:
        game: Which.
        robots: Who plays.
        set_controllers: Told of the match before its first tick, to say what commands its robots.
        name: Of the run, in its report.
        seconds: How long, simulated [s].
        players: Who plays each robot of a whole match, for the report.
        sinks: As in `play_auto`.
        on_tick: The same.
        should_stop: The same.
        settings: Further arguments of `Match`.
    """
    start = perf_counter()
    try:
        match = Match(game, robots=robots, sinks=sinks, **settings)
    except BaseException:
        for sink in sinks:
            sink.close()
        raise
    gc.freeze()  # else each full collection within the run looks through the field and all modules: 40 ms
    try:
        set_controllers(match)
        return _play(match, name, seconds, players, start, on_tick, should_stop)
    except BaseException:  # a script's own error passes through, with the log up to it on the disk
        match.close()
        raise
    finally:
        gc.unfreeze()


def auto_seconds(game: Game) -> float:
    """How long a game's autonomous period is [s]."""
    for phase in game.clock.phases:
        if phase.mode == "auto":
            return phase.duration
    return game.clock.duration


def _play(
    match: Match,
    name: str,
    seconds: float,
    players: Sequence[str],
    wall_start: float,
    on_tick: Callable[[Match], None] | None,
    should_stop: Callable[[], bool],
) -> AutoRun:
    pieces_at_start = match.pieces.state.pos[match.pieces.on_field()].copy()
    timer = TickTimer()
    path, substeps, awake = [], [], []
    interrupted = False
    run_start = perf_counter()
    for _ in range(max(1, round(seconds / TICK))):
        if should_stop():
            interrupted = True
            break
        start = perf_counter()
        match.tick()
        elapsed = perf_counter() - start
        match.last_tick_ms = 1e3 * elapsed
        timer.add(elapsed)
        path.append(match.robots[0].chassis.pose)
        substeps.append(match.substeps)
        awake.append(len(match.pieces.awake))
        if on_tick is not None:
            on_tick(match)
    wall = perf_counter() - run_start
    track, own = np.array(path).reshape(-1, 3), match.record.robots[0]
    report = RunReport(
        game=match.game.name,
        auto=name,
        players=tuple(players),
        alliance=match.alliances[0],
        seed=match.seed,
        scatter=match.scatter.text,
        engine=match.world.engine.name,
        sim_seconds=match.time,
        startup_seconds=run_start - wall_start,
        wall_seconds=wall,
        realtime_factor=match.time / max(wall, 1e-9),
        ticks=match.ticks,
        score=match.score,
        match_state=_match_state(match.snapshot()),
        pieces=match.count,
        piece_name=" and ".join(supply.kind.name.lower() for supply in match.game.pieces) or "pieces",
        breakdown={**match.tracker.pieces, **match.rules.breakdown()},
        placed=dict(match.pieces.places.totals()),
        fouls=tuple(f"{foul.time:.2f} s: {foul}" for foul in match.tracker.fouls),
        shots=len(match.record.shots),
        hits=match.record.hits,
        taken_in=len(match.record.taken_in),
        distance_m=own.distance,
        tick_ms=timer.times(),
        substeps=Spread(mean=float(np.mean(substeps or [0])), max=max(substeps, default=0)),
        awake=Spread(mean=float(np.mean(awake or [0])), max=max(awake, default=0)),
        min_battery_v=own.battery.min_voltage,
        brownouts=own.battery.brownouts,
        resets=own.battery.resets,
        digest=match.digest.hexdigest(),
    )
    return AutoRun(report, match, track, pieces_at_start, interrupted)


def _match_state(snapshot: Snapshot) -> dict[str, float | int | bool | str]:
    """What the keys `Sim/Match/...` say, by the rest of their names."""
    prefix = "Sim/Match/"
    values: dict[str, float | int | bool | str] = {}
    for kind in (snapshot.doubles, snapshot.integers, snapshot.booleans, snapshot.strings):
        values.update(kind)
    return {key.removeprefix(prefix): value for key, value in values.items() if key.startswith(prefix)}
