"""Phases of the match, and the periods in which fuel counts (game manual, MATCH PERIODS and HUB status).

The manual does not state all times. The other times are from Cheesy Arena, a field management system for events
(`game/hub.go`, `field/arena.go`). Fuel counts when the sensors below a hub's opening detect the fuel. Fuel detected
before teleop is auto fuel. For 3 s after a phase with an active hub, fuel still counts in this phase.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

from simcore.match.clock import MatchClock, Phase
from simcore.match.scoring import Alliance
from simcore.quantities import COUNT, Quantity, require_fields

__all__ = ["ALLIANCES", "ASSESSMENT", "MATCH", "UNCOUNTED", "EventSettings", "HubCount"]

ALLIANCES: tuple[Alliance, Alliance] = ("blue", "red")

MATCH = MatchClock(
    [
        Phase("auto", 20.0, "auto"),
        Phase("pause", 3.0, "disabled"),  # the scoring delay between auto and teleop
        Phase("transition", 10.0),
        Phase("shift 1", 25.0),
        Phase("shift 2", 25.0),
        Phase("shift 3", 25.0),
        Phase("shift 4", 25.0),
        Phase("end game", 30.0),
    ]
)
"""Match clock of 2:43: 20 s auto, 3 s pause, 2:20 teleop."""

ASSESSMENT = 3.0
"""Time after the match in which fuel still counts and robots must stay on the tower [s]."""

UNCOUNTED = "uncounted"
"""Name of the period of fuel that does not count because the hub is inactive."""

_GRACE = 3.0  # [s]; time for which fuel still counts after a hub becomes inactive
_PULSING = 3.0  # [s]; time for which the lights pulse before a hub becomes inactive, manual table 5-3
_PERIODS = {"auto": "auto", "pause": "auto", "transition": "transition", "end game": "endgame"}
_PERIODS |= {f"shift {number}": f"shift{number}" for number in range(1, 5)}
_TELEOP = tuple(period for period in dict.fromkeys(_PERIODS.values()) if period != "auto")
_EPS = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class EventSettings:
    """Settings that differ between events; the defaults are the manual's values for regional and district events."""

    energized: int = 100
    """Fuel count for the ranking point ENERGIZED; 240 at district championships, 360 at the FIRST Championship."""
    supercharged: int = 360
    """Fuel count for the ranking point SUPERCHARGED; 500 at the FIRST Championship."""
    traversal: int = 50
    """Tower points for the ranking point TRAVERSAL."""
    sensor_delay: float = 0.25
    """Travel time of a fuel from a hub's throat to the sensors [s]. The value is an estimate (0.1 to 0.5 s), because no
    figure is published."""

    def __post_init__(self) -> None:
        require_fields(
            self, energized=COUNT, supercharged=COUNT, traversal=COUNT, sensor_delay=Quantity("s", 0.0, 10.0)
        )


class HubCount:
    """Counts of fuel in both hubs, by the period in which the fuel counts.

    Args:
        coin: Alliance whose hub is inactive first after a tie in auto.
        practice: Whether both hubs are always active, for practice.
    """

    def __init__(self, coin: Alliance, *, practice: bool = False) -> None:
        self._coin: Alliance = coin
        self.practice = practice
        self.fuel: dict[Alliance, Counter[str]] = {alliance: Counter() for alliance in ALLIANCES}
        """Number of fuel by alliance and period."""

    @property
    def first_inactive(self) -> Alliance:
        """Alliance whose hub is inactive in shifts 1 and 3: the alliance with more auto fuel, or `coin` after a tie."""
        blue, red = (self.fuel[alliance]["auto"] for alliance in ALLIANCES)
        return self._coin if blue == red else "blue" if blue > red else "red"

    def is_on(self, alliance: Alliance, time: float) -> bool:
        """Return whether a hub is active at a match time [s]; in practice, always True."""
        if self.practice:
            return True
        name = MATCH.phase(time).name
        if name in ("shift 1", "shift 3"):
            return alliance != self.first_inactive
        if name in ("shift 2", "shift 4"):
            return alliance == self.first_inactive
        return time < MATCH.duration

    def period(self, alliance: Alliance, sensed: float) -> str:
        """Return the period of a fuel that the sensors detect at a match time [s], `UNCOUNTED` for an inactive hub."""
        before = sensed - _GRACE + _EPS
        if before >= MATCH.start("transition") and self.is_on(alliance, before):
            return _PERIODS[MATCH.phase(before).name]
        return _PERIODS[MATCH.phase(sensed).name] if self.is_on(alliance, sensed) else UNCOUNTED

    def count(self, alliance: Alliance, sensed: float) -> str:
        """Count a fuel that a hub's sensors detect at a match time [s], and return the period of the fuel."""
        period = self.period(alliance, sensed)
        self.fuel[alliance][period] += 1
        return period

    def light(self, alliance: Alliance, time: float) -> str:
        """Return the state of a hub's lights at a match time [s].

        Returns:
            `on`, `pulsing` (before the hub becomes inactive), `off` or `purple` (after the match).
        """
        if time >= MATCH.duration + ASSESSMENT and not self.practice:
            return "purple"
        if not self.is_on(alliance, time):
            return "off"
        return "on" if self.is_on(alliance, time + _PULSING) else "pulsing"

    def counted(self, alliance: Alliance) -> int:
        """Return the number of an alliance's fuel that counts for points and ranking points."""
        fuel = self.fuel[alliance]
        return fuel.total() - fuel[UNCOUNTED]

    def hub_score(self, alliance: Alliance) -> Mapping[str, int]:
        """Return the values of `hubScore` in FIRST's score API for an alliance, with one point per counted fuel."""
        fuel = self.fuel[alliance]
        rows: dict[str, int] = {}
        teleop = self.counted(alliance) - fuel["auto"]
        counts = {"auto": fuel["auto"], **{period: fuel[period] for period in _TELEOP}}
        for name, number in {**counts, "teleop": teleop, "total": self.counted(alliance)}.items():
            rows |= {f"{name}Count": number, f"{name}Points": number}
        return {**rows, UNCOUNTED: fuel[UNCOUNTED]}
