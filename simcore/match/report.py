"""The report of a run: one JSON object for programs, tables for people."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from rich import box
from rich.console import Console
from rich.markup import escape
from rich.panel import Panel
from rich.table import Table

from simcore.errors import NonFiniteError
from simcore.match.run_record import TickTimes
from simcore.pieces.piece_manager import GamePieceManager
from simcore.pieces.pool import PieceStatus
from simcore.telemetry.snapshot import key_in_words
from simcore.typing import alliance_in

__all__ = ["NOTHING", "PieceCount", "RunReport", "Score", "Spread", "print_report", "split_level"]

NOTHING = ("", "None")
"""Words of a match's state that say that there is nothing, the second by the score API."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """Points by alliance."""

    red: int
    blue: int
    total: int


@dataclass(frozen=True, slots=True, kw_only=True)
class PieceCount:
    """Where all pieces are; everything but `staged` adds up to it."""

    staged: int
    """How many have come into the match, preloads included."""
    on_field: int
    in_flight: int
    held: int
    scored: int
    placed: int = 0
    """At rest in a place where they count; `on_field` is without them."""
    off_field: int
    """Not on the field yet: e.g. with a human player."""

    @classmethod
    def of(cls, pieces: GamePieceManager) -> PieceCount:
        """Where all pieces of a match are now."""
        count = pieces.count
        return cls(
            staged=pieces.total,
            on_field=count(PieceStatus.ASLEEP) + count(PieceStatus.AWAKE),
            in_flight=count(PieceStatus.IN_FLIGHT),
            held=count(PieceStatus.HELD),
            scored=count(PieceStatus.SCORED),
            placed=count(PieceStatus.PLACED),
            off_field=count(PieceStatus.STAGED),
        )

    @property
    def is_conserved(self) -> bool:
        """Whether every piece is accounted for."""
        somewhere = self.on_field + self.in_flight + self.held + self.scored + self.placed + self.off_field
        return somewhere == self.staged


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Mean and largest of a count over the ticks."""

    mean: float
    max: int


@dataclass(frozen=True, slots=True, kw_only=True)
class RunReport:
    """Everything there is to say about a run, field by field as in `--json`."""

    game: str
    auto: str
    """Name of the auto, or `match` for a whole one."""
    alliance: str
    """Of the first robot."""
    players: tuple[str, ...] = ()
    """Who played each robot of a whole match, with its alliance."""
    seed: int
    scatter: str = "0"
    """The line that `Scatter.parse` makes the match's scatter of; 0 is none."""
    engine: str
    """Name of the physics engine."""
    sim_seconds: float
    startup_seconds: float
    """Wall time from nothing to the first tick, imports left out [s]."""
    wall_seconds: float
    """Wall time of all ticks [s]."""
    realtime_factor: float
    """Simulated over real time."""
    ticks: int
    score: Score
    match_state: Mapping[str, float | int | bool | str]
    """The match clock, its period and what counts, at the end: by the names of the keys `Sim/Match/...`."""
    pieces: PieceCount
    """Of all kinds."""
    piece_name: str
    """What people call them."""
    breakdown: Mapping[str, int]
    """Pieces by zone, and what else the score is made of."""
    placed: Mapping[str, int] = field(default_factory=dict)
    """Pieces by level, of a game with resting places."""
    fouls: tuple[str, ...] = ()
    """Each with its time, in order."""
    shots: int
    hits: int
    taken_in: int
    """Pieces that all robots together have taken."""
    distance_m: float
    """How far the first robot drove; not how far it was carried [m]."""
    tick_ms: TickTimes
    substeps: Spread
    awake: Spread
    min_battery_v: float
    """Lowest battery voltage [V]."""
    brownouts: int
    """How many times the battery's voltage switched the first robot's motors off."""
    resets: int
    """How many times it switched that robot's roboRIO off."""
    digest: str
    """SHA-256 over the state trajectory."""
    outputs: Mapping[str, str] = field(default_factory=dict)
    """Path of each file written, by kind: log, picture."""

    def to_json(self) -> str:
        """One JSON object on one line, in plain types.

        Raises:
            NonFiniteError: A NaN or an infinity, which JSON does not know; names the field.
        """
        return json.dumps(_plain("report", asdict(self)), allow_nan=False)


def _plain(name: str, value: Any) -> Any:
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
    """Print the report as tables for 80 columns; plain ASCII where the terminal cannot show more (Windows cp1252).

    Args:
        report: Of the run.
        console: Where to.
        verbose: Also what only those ask who compare runs: seed, engine, times of ticks, digest.
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
    if report.taken_in:
        run.add_row("pieces taken in", str(report.taken_in))
    run.add_row("way driven", f"{report.distance_m:.1f} m")
    off = f"; {report.brownouts} brown-outs" if report.brownouts else ""
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
        # A path may hold letters that this terminal cannot print
        shown = path.encode(console.encoding, "replace").decode(console.encoding)
        run.add_row(escape(kind), escape(shown))
    console.print(run)


def split_level(name: str) -> tuple[str, str]:
    """Whose a level of resting places is, and what it is called beside that.

    >>> split_level("BlueL4"), split_level("Shelf")
    (('blue', 'L4'), ('', 'Shelf'))
    """
    whose = alliance_in(name) or ""
    return (whose, name[len(whose) :]) if len(name) > len(whose) else ("", name)


def _placed(levels: Mapping[str, int], style: box.Box, width: int) -> Table:
    """A row an alliance and a column a level."""
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
    """What the score of a whole match is made of, by alliance; what is 0 on both sides is left out."""
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
    """Match clock and period, and what the game adds to them, as people read them."""
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
