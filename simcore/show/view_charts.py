"""Charts of chosen signals on the page: any number that a run publishes, over its last seconds."""

from __future__ import annotations

import re
from collections import deque
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from simcore.show.pacing import FrameRate
from simcore.telemetry.snapshot import Snapshot
from simcore.typing import FloatArray

if TYPE_CHECKING:
    import viser

    from simcore.telemetry.wpilog import TelemetryLog

__all__ = ["LogSignals", "RecentSignals", "Signals", "ViewCharts", "unit_of"]

WINDOW = 20.0
"""How much of a run a chart shows [s]."""
_NONE = "none"
_FIRST = ("Sim/Debug/BatteryVoltage", "Sim/Debug/BatteryCurrent")
_COLORS = ("#1e54b7", "#b3470a")  # blue and orange, which all eyes tell apart; each has its own chart besides
_POINTS = 400  # in a chart at most
_UNITS = (
    (r"(Voltage|VoltageIn|Volts)", "V"),
    (r"(Current|CurrentA|Amps)", "A"),
    (r"VelocityRPS(Setpoint)?", "turns/s"),
    (r"PositionRot(Setpoint)?", "turns"),
    (r"\w*Deg", "\u00b0"),
    (r"\w*Pct", "%"),
    (r"(\w*HeightM|GroundClearance)", "m"),
    (r"WheelSlip", "m/s"),
    (r"\w*Ms", "ms"),
    (r"(Time|TimeLeft)", "s"),
    (r"RealTimeFactor", "x"),
)


def unit_of(key: str) -> str:
    """What a key's numbers are in, by its name; empty for counts, flags and unknown ones.

    >>> unit_of("Sim/Debug/ShooterVelocityRPS"), unit_of("Sim/Debug/HeldCount")
    ('turns/s', '')
    """
    name = key.rsplit("/", 1)[-1]
    return next((unit for pattern, unit in _UNITS if re.search(f"{pattern}$", name)), "")


class Signals(Protocol):
    """Numbers over time."""

    def names(self) -> list[str]:
        """Keys that have numbers, sorted."""
        ...

    def recent(self, key: str) -> tuple[FloatArray, FloatArray]:
        """Times [s] and values of the last `WINDOW`, shape (n,) each."""
        ...


class RecentSignals:
    """The last seconds of a run as it happens."""

    def __init__(self) -> None:
        self._rows: deque[tuple[float, dict[str, float]]] = deque()

    def note(self, snapshot: Snapshot) -> None:
        """Take the numbers of a snapshot; an earlier one than the last begins anew."""
        if self._rows and snapshot.time < self._rows[-1][0]:
            self._rows.clear()
        self._rows.append((snapshot.time, {**snapshot.doubles, **snapshot.integers, **snapshot.booleans}))
        while self._rows[0][0] < snapshot.time - WINDOW:
            self._rows.popleft()

    def names(self) -> list[str]:
        """Keys that have numbers, sorted."""
        return sorted(self._rows[-1][1]) if self._rows else []

    def recent(self, key: str) -> tuple[FloatArray, FloatArray]:
        """Times [s] and values of the last `WINDOW`, shape (n,) each."""
        found = [(time, row[key]) for time, row in list(self._rows) if key in row]
        return np.array([time for time, _ in found]), np.array([float(value) for _, value in found])


class LogSignals:
    """A log, up to the time that is shown."""

    def __init__(self, log: TelemetryLog) -> None:
        self._log = log
        numbers = [key for key, column in log.columns.items() if column.type in ("double", "int64", "boolean")]
        self._names = sorted(numbers, key=lambda key: (not key.startswith("Sim/"), key))
        self._series: dict[str, tuple[FloatArray, FloatArray]] = {}
        self.time = log.span[0]
        """Shown now, on the log's own clock [s]."""

    def names(self) -> list[str]:
        """Keys that have numbers, sorted."""
        return self._names

    def recent(self, key: str) -> tuple[FloatArray, FloatArray]:
        """Times since its start [s] and values of the last `WINDOW`, shape (n,) each; each holds until the next."""
        if key not in self._series:
            self._series[key] = self._log.series(key)
        times, values = self._series[key]
        start = self.time - WINDOW
        first = max(0, int(np.searchsorted(times, start, side="right")) - 1)
        last = int(np.searchsorted(times, self.time, side="right"))
        if last <= first:
            return np.zeros(0), np.zeros(0)
        shown = np.maximum(times[first:last], start)
        held = np.append(np.repeat(shown, 2)[1:], self.time)  # a log has no value again while it does not change
        return held - self._log.span[0], np.repeat(values[first:last], 2)


class ViewCharts:
    """Two charts, each with a choice of its signal.

    Args:
        server: Whose page.
        signals: What can be chosen.
        order: Where on the page.
    """

    def __init__(self, server: viser.ViserServer, signals: Signals, *, order: float) -> None:
        self._signals = signals
        self._rate = FrameRate(4.0)
        self._charts: list[tuple[Any, Any]] = []
        with server.gui.add_folder("charts", order=order, expand_by_default=False):
            for number in range(len(_FIRST)):
                choice = server.gui.add_dropdown(f"signal {number + 1}", (_NONE,))
                empty = np.zeros(1)
                chart = server.gui.add_uplot(
                    (empty, empty),
                    ({}, {"label": _NONE, "stroke": _COLORS[number], "width": 2}),
                    scales={"x": {"time": False}},
                    axes=({"label": "time [s]", "labelSize": 18, "size": 32}, {"size": 52}),
                    legend={"show": False},
                    height=150,
                    visible=False,
                )
                choice.on_update(lambda _, number=number: self._choose(number))
                self._charts.append((choice, chart))

    def update(self, *, now: bool = False) -> None:
        """Draw what is new, some four times a second, or at once."""
        if not (now or self._rate.due()):
            return
        self._rate.take()
        names = tuple(key.removeprefix("Sim/") for key in self._signals.names())
        for number, (choice, chart) in enumerate(self._charts):
            if names and choice.options != (_NONE, *names):
                chosen = choice.value if choice.value in names else _FIRST[number].removeprefix("Sim/")
                choice.options = (_NONE, *names)
                choice.value = chosen if chosen in names else _NONE
                self._choose(number)
            if chart.visible:
                self._draw(choice.value, chart)

    def _choose(self, number: int) -> None:
        choice, chart = self._charts[number]
        chart.visible = choice.value != _NONE
        if chart.visible:
            unit = unit_of(choice.value)
            label = f"{choice.value.rsplit('/', 1)[-1]}{f' [{unit}]' if unit else ''}"
            chart.title = label
            chart.series = ({}, {"label": label, "stroke": _COLORS[number], "width": 2})
            self._draw(choice.value, chart)

    def _draw(self, name: str, chart: Any) -> None:
        key = name if name in self._signals.names() else f"Sim/{name}"
        times, values = self._signals.recent(key)
        every = max(1, len(times) // _POINTS)
        if len(times):
            chart.data = (times[::every], values[::every])
