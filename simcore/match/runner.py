"""Headless runs of autos and matches at full speed, with a report in JSON or in tables.

This module reads the wall clock only for the report. The simulation does not depend on the wall clock.
"""

from __future__ import annotations

import gc
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, is_dataclass
from time import perf_counter
from typing import Any

import numpy as np
from rich import box
from rich.console import Console
from rich.markup import escape
from rich.panel import Panel
from rich.table import Table

from simcore.errors import NonFiniteError
from simcore.match.game import Auto, Game, RobotEntry
from simcore.match.match import Match
from simcore.match.run_record import TickTimes
from simcore.match.scoring import Alliance
from simcore.quantities import DURATION, require
from simcore.robot.robot_config import RobotConfig
from simcore.telemetry.snapshot import Snapshot, TelemetrySink, key_in_words
from simcore.typing import FloatArray, alliance_in
from simcore.units import TICK

__all__ = ["NOTHING", "AutoRun", "RunReport", "Spread", "play_auto", "play_robots", "print_report", "split_level"]

NOTHING = ("", "None")
"""Texts that stand for an empty value in `RunReport.match_state`, omitted from the printed report."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Mean and maximum of a count over all ticks."""

    mean: float
    max: int

    @classmethod
    def of(cls, counts: Sequence[int]) -> Spread:
        """Compute mean and maximum from the counts of all ticks; without ticks, mean and maximum are 0."""
        return cls(mean=float(np.mean(counts or [0])), max=max(counts, default=0))


class RunReport:
    """Results of a run of an auto or match. Each attribute is a field of the `--json` output.

    Args:
        match: Match after the last tick, not closed yet.
        name: Name of the auto, or `match` for a whole match.
        players: Alliance and player of each robot of a whole match.
        startup_seconds: Wall time from the start to the first tick, without imports [s].
        ticks: Wall time [s], number of engine steps and number of awake pieces of each tick.
        wall_seconds: Wall time of all ticks [s].
    """

    def __init__(
        self,
        match: Match,
        name: str,
        *,
        players: Sequence[str] = (),
        startup_seconds: float,
        wall_seconds: float,
        ticks: Sequence[tuple[float, int, int]],
    ) -> None:
        record, battery = match.record, match.record.robots[0].battery
        self.game = match.game.name
        self.auto = name
        self.alliance = match.alliances[0]
        """Alliance of the first robot."""
        self.players = tuple(players)
        self.seed = match.seed
        self.scatter = match.scatter.text
        """Scatter of the match in the format of `Scatter.parse`; `0` without scatter."""
        self.engine = match.world.engine_name
        self.sim_seconds = match.time
        self.startup_seconds = startup_seconds
        self.wall_seconds = wall_seconds
        self.realtime_factor = match.time / max(wall_seconds, 1e-9)
        """Ratio of simulated time to wall time [-]."""
        self.ticks = match.ticks
        self.score = match.score
        self.match_state = _match_state(match.snapshot())
        """Values of the match channels after the last tick, by telemetry key without the prefix `Sim/Match/`."""
        self.pieces = match.count
        """Number of pieces by status, all kinds together."""
        self.piece_name = " and ".join(supply.kind.name.lower() for supply in match.game.pieces) or "pieces"
        """Names of the kinds of pieces in lower case, joined by "and"."""
        self.breakdown = match.breakdown()
        """Number of scored pieces by zone, points of human players' throws, and other parts of the score."""
        self.placed = dict(match.pieces.places.totals())
        """Number of placed pieces by level, in a game with resting places."""
        self.fouls = tuple(f"{foul.time:.2f} s: {foul}" for foul in match.tracker.fouls)
        """Time and description of each foul, oldest first."""
        self.shots = len(record.shots)
        self.hits = record.hits
        self.taken_in = len(record.taken_in)
        """Number of pieces taken in by all robots."""
        self.shortfalls = tuple(record.shortfalls)
        """Sentences about robots that took in or shot no pieces, or about errors in a pose estimate."""
        self.distance_m = record.robots[0].distance
        """Distance driven by the first robot, excluding moves by the drive team [m]."""
        self.tick_ms = TickTimes.of([seconds for seconds, _, _ in ticks])
        self.substeps = Spread.of([substeps for _, substeps, _ in ticks])
        self.awake = Spread.of([awake for _, _, awake in ticks])
        self.min_battery_v = battery.min_voltage
        """Lowest battery voltage of the first robot [V]."""
        self.brownouts = battery.brownouts
        """Number of brownouts, in which the first robot's roboRIO switched off the motors."""
        self.resets = battery.resets
        """Number of resets of the first robot's roboRIO due to low voltage."""
        self.digest = match.digest.hexdigest()
        """SHA-256 digest of the states in all ticks, in hexadecimal digits."""
        self.outputs: Mapping[str, str] = {}
        """Path of each output file, by kind of output, e.g. `log` or `page`."""

    def to_json(self) -> str:
        """Return the report as a JSON object on one line.

        Raises:
            NonFiniteError: If a value is NaN or infinite, which JSON cannot represent; the message names the field.
        """
        return json.dumps(_plain("report", vars(self)), allow_nan=False)


def _plain(name: str, value: Any) -> Any:
    if is_dataclass(value) and not isinstance(value, type):
        value = asdict(value)
    if isinstance(value, Mapping):
        return {str(key): _plain(f"{name}.{key}", item) for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(f"{name}[{number}]", item) for number, item in enumerate(value)]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        raise NonFiniteError(f"{name} must be finite, got {value}")
    return value if isinstance(value, (str, int, float, bool)) else str(value)


def print_report(report: RunReport, console: Console, *, verbose: bool = False) -> None:
    """Print the report in tables of at most 80 columns, with ASCII lines if the console's encoding is not UTF-8.

    Args:
        report: Report of the run.
        console: Console to print on.
        verbose: Whether to add seed, scatter, engine, tick times, substeps, awake pieces and digest.
    """
    ascii_only = not console.encoding.lower().replace("-", "").startswith("utf")
    style = box.ASCII if ascii_only else box.ROUNDED
    score, pieces, tick = report.score, report.pieces, report.tick_ms

    headline = f"[bold]{score.total}[/bold] points   [red]red {score.red}[/red]   [blue]blue {score.blue}[/blue]"
    if report.shots:
        headline += f"   {report.hits} of {report.shots} shots scored ({report.hits / report.shots:.0%})"
    what = "match" if report.players else f"auto '{escape(report.auto)}'"
    title = f"{report.game}, {what}, {report.sim_seconds:g} s"
    console.print(Panel(headline, title=title, box=style, width=_width(console), padding=(0, 1)))

    kinds = f"{report.piece_name.capitalize()}: where all {pieces.staged} of them are"
    where = Table(title=kinds, box=style, title_justify="left", width=_width(console))
    found = {
        "on the field": pieces.on_field,
        "in the air": pieces.in_flight,
        "in robots": pieces.held,
        "placed": pieces.placed,
        "scored": pieces.scored,
        "not in play yet": pieces.off_field,
    }
    if not pieces.placed:
        del found["placed"]
    counts = tuple(found.values())
    for name in found:
        where.add_column(name, justify="right")
    where.add_row(*(str(count) for count in counts))
    console.print(where)
    if not pieces.is_conserved:
        lost = f"{sum(counts)} of {pieces.staged} pieces accounted for: this is a bug"
        console.print(f"[bold red]{lost}[/bold red]")

    if pieces.placed:
        console.print(_placed(report.placed, style, _width(console)))

    if report.players:
        console.print(_score_sheet(report, style, _width(console)))

    run = Table(title="Run", box=style, title_justify="left", show_header=False, width=_width(console))
    run.add_column(ratio=2)
    run.add_column(ratio=5, overflow="fold")
    for what, value in _clock(report.match_state).items():
        run.add_row(what, value)
    for foul in report.fouls:
        run.add_row("foul", escape(foul))
    for shortfall in report.shortfalls:
        run.add_row("fell short", escape(shortfall))
    if report.taken_in:
        run.add_row("pieces taken in", str(report.taken_in))
    run.add_row("distance driven", f"{report.distance_m:.1f} m")
    off = f"; {report.brownouts} brownouts" if report.brownouts else ""
    off += f", {report.resets} resets of the roboRIO" if report.resets else ""
    run.add_row("lowest battery voltage", f"{report.min_battery_v:.2f} V{off}")
    times = f"{report.wall_seconds:.1f} s, {report.realtime_factor:.1f} times as fast as a real match"
    run.add_row("time to compute it", times)
    if verbose:
        run.add_row("seed", str(report.seed))
        run.add_row(
            "scatter", "none" if report.scatter == "0" else report.scatter.removeprefix("0,").replace(",", ", ")
        )
        run.add_row("physics engine", report.engine)
        ticks = (
            f"{report.ticks}; median {tick.median:.2f}, p95 {tick.p95:.2f}, p99 {tick.p99:.2f}, max {tick.max:.2f} ms"
        )
        run.add_row("ticks of 20 ms", ticks)
        run.add_row("sub-steps a tick", f"mean {report.substeps.mean:.1f}, max {report.substeps.max}")
        run.add_row("awake pieces", f"mean {report.awake.mean:.1f}, max {report.awake.max}")
        run.add_row("digest", report.digest[:16])
    for kind, path in report.outputs.items():
        # the path may contain characters that this terminal cannot print
        shown = path.encode(console.encoding, "replace").decode(console.encoding)
        run.add_row(escape(kind), escape(shown))
    console.print(run)


def split_level(name: str) -> tuple[str, str]:
    """Split the name of a level of resting places into alliance, or an empty string, and the rest of the name.

    >>> split_level("BlueL4"), split_level("Shelf")
    (('blue', 'L4'), ('', 'Shelf'))
    """
    whose = alliance_in(name) or ""
    return (whose, name[len(whose) :]) if len(name) > len(whose) else ("", name)


def _placed(levels: Mapping[str, int], style: box.Box, width: int) -> Table:
    """Return a table of the placed pieces, with a row for each alliance and a column for each level."""
    counts = {split_level(name): count for name, count in levels.items()}
    labels = list(dict.fromkeys(label for _, label in counts))
    table = Table(title="Placed, by level", box=style, title_justify="left", width=width)
    table.add_column("")
    for label in labels:
        table.add_column(escape(label), justify="right")
    for whose in dict.fromkeys(whose for whose, _ in counts):
        table.add_row(whose, *(str(counts.get((whose, label), "")) for label in labels))
    return table


def _score_sheet(report: RunReport, style: box.Box, width: int) -> Table:
    """Return a table of players and score breakdown by alliance, without rows that are 0 for both alliances."""
    table = Table(title="Score sheet", box=style, title_justify="left", width=width)
    table.add_column("")
    for side in ("red", "blue"):
        table.add_column(side, justify="right")
    seats = {
        side: ", ".join(p.removeprefix(side).strip() for p in report.players if p.startswith(side))
        for side in ("red", "blue")
    }
    table.add_row("players", *seats.values())
    names = dict.fromkeys(name.partition("/")[2] for name in report.breakdown if name.startswith(("Red/", "Blue/")))
    for name in names:
        red, blue = (report.breakdown.get(f"{side}/{name}", 0) for side in ("Red", "Blue"))
        if red or blue:
            table.add_row(escape(name), str(red), str(blue))
    return table


def _clock(state: Mapping[str, float | int | bool | str]) -> dict[str, str]:
    """Return the table rows for match clock, period and non-empty match state of the game: text by label."""
    rest = dict(state)
    for told_elsewhere in ("Game", "LastFoul"):
        rest.pop(told_elsewhere, None)
    time, left, period = rest.pop("Time"), rest.pop("TimeLeft"), rest.pop("Period")
    can_move = "robots may move" if rest.pop("Enabled") else "robots are disabled"
    rows = {"match clock": f"{time:.1f} s, {left:.1f} s left", "period": f"{escape(str(period))}; {can_move}"}
    for name, value in rest.items():
        if value in NOTHING:
            continue
        rows[key_in_words(name)] = ("yes" if value else "no") if isinstance(value, bool) else escape(str(value))
    return rows


def _width(console: Console) -> int:
    return min(console.width, 80)


@dataclass(slots=True)
class AutoRun:
    """Result of a headless run; the caller must close `match`."""

    report: RunReport
    match: Match
    path: FloatArray
    """Path of the first robot, one row of x, y, yaw per tick, field frame [m, m, rad], shape (n, 3)."""
    pieces_at_start: FloatArray
    """Positions of all pieces on the field before the first tick, field frame [m], shape (n, 3)."""
    was_interrupted: bool


def play_auto(
    game: Game,
    auto: Auto | str | None = None,
    *,
    alliance: Alliance = "blue",
    seconds: float | None = None,
    robot: RobotConfig | None = None,
    **settings: Any,
) -> AutoRun:
    """Run an auto of a game headless, with one robot.

    Args:
        game: Game of the auto.
        auto: Auto, or the name of an auto; None for the game's first auto.
        alliance: Alliance of the robot; a red robot plays the auto on the corresponding red side of the field.
        seconds: Simulated time to play [s]; None for the game's autonomous period.
        robot: Config of the robot; None for the game's default robot.
        settings: Further arguments of `play_robots` and `Match`, e.g. `seed` and `sinks`.

    Returns:
        Result of the run, with the match still open.

    Raises:
        ConfigError: If `seconds` is not a positive finite number or the match is invalid.
        UnknownNameError: If the game has no auto of this name.
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
    """Run a match headless with any number of robots, and report the results.

    Args:
        game: Game to play.
        robots: Robots of the match.
        set_controllers: Function that sets the robots' controllers, called with the match before the first tick.
        name: Name of the run in the report.
        seconds: Simulated time to play [s].
        players: Alliance and player of each robot for the report; empty unless the run is a whole match.
        sinks: Receivers of telemetry, closed if the match cannot be built or an error ends the run.
        on_tick: Function called after each tick, e.g. for a progress bar.
        should_stop: Function called before each tick; a return value of True ends the run, and the report covers the
            ticks so far.
        settings: Further arguments of `Match`.

    Returns:
        Result of the run, with the match still open.
    """
    start = perf_counter()
    try:
        match = Match(game, robots=robots, sinks=sinks, **settings)
    except BaseException:
        for sink in sinks:
            sink.close()
        raise
    gc.freeze()  # otherwise each full garbage collection traverses the field and all modules: 40 ms
    try:
        set_controllers(match)
        pieces_at_start = match.pieces.state.pos[match.pieces.on_field()].copy()
        path, ticks, was_interrupted = [], [], False
        run_start = perf_counter()
        for _ in range(max(1, round(seconds / TICK))):
            if was_interrupted := should_stop():
                break
            tick_start = perf_counter()
            match.tick()
            elapsed = perf_counter() - tick_start
            match.last_tick_ms = 1e3 * elapsed
            path.append(match.robots[0].chassis.pose)
            ticks.append((elapsed, match.substeps, len(match.pieces.awake)))
            if on_tick is not None:
                on_tick(match)
        wall = perf_counter() - run_start
        report = RunReport(
            match, name, players=players, startup_seconds=run_start - start, wall_seconds=wall, ticks=ticks
        )
        return AutoRun(report, match, np.array(path).reshape(-1, 3), pieces_at_start, was_interrupted)
    except BaseException:  # an error in a script passes through, after the log up to that point is written
        match.close()
        raise
    finally:
        gc.unfreeze()


def auto_seconds(game: Game) -> float:
    """Return the duration of a game's first auto phase [s], or of the whole match if the clock has no auto phase."""
    for phase in game.clock.phases:
        if phase.mode == "auto":
            return phase.duration
    return game.clock.duration


def _match_state(snapshot: Snapshot) -> dict[str, float | int | bool | str]:
    """Return the values in a snapshot whose keys begin with `Sim/Match/`, by key without this prefix."""
    prefix = "Sim/Match/"
    values: dict[str, float | int | bool | str] = {}
    for kind in (snapshot.doubles, snapshot.integers, snapshot.booleans, snapshot.strings):
        values.update(kind)
    return {key.removeprefix(prefix): value for key, value in values.items() if key.startswith(prefix)}
