"""Phases of the match, and when fuel counts in which of them (game manual, MATCH PERIODS and HUB status).

Two sentences of the manual leave times open; those of Cheesy Arena, a field management system for events, apply
(`game/hub.go`, `field/arena.go`): fuel counts when the sensors below a hub's opening see it; until teleop begins it is
auto fuel; after a phase in which a hub was active, its fuel counts in that phase for 3 s.
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
"""Match of 2:43: 20 s auto, 3 s pause, 2:20 teleop."""

ASSESSMENT = 3.0
"""Time after the match in which fuel still counts and robots have to stay on the tower [s]."""

UNCOUNTED = "uncounted"
"""Period of fuel in an inactive hub."""

_GRACE = 3.0  # [s] for which fuel still counts after a hub went inactive
_PULSING = 3.0  # [s] before that, in which the hub's lights pulse; manual table 5-3
_PERIODS = {"auto": "auto", "pause": "auto", "transition": "transition", "end game": "endgame"}
_PERIODS |= {f"shift {number}": f"shift{number}" for number in range(1, 5)}
_TELEOP = tuple(period for period in dict.fromkeys(_PERIODS.values()) if period != "auto")
_EPS = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class EventSettings:
    """Settings that differ between events. The defaults are the manual's for regional and district events."""

    energized: int = 100
    """Counted fuel for the ranking point ENERGIZED; 240 at district championships, 360 at the championship."""
    supercharged: int = 360
    """Counted fuel for the ranking point SUPERCHARGED; 500 at the championship."""
    traversal: int = 50
    """Tower points for the ranking point TRAVERSAL."""
    sensor_delay: float = 0.25
    """Time of a fuel from a hub's throat to its sensors [s]; estimate, 0.1 to 0.5: no published figure."""

    def __post_init__(self) -> None:
        require_fields(
            self, energized=COUNT, supercharged=COUNT, traversal=COUNT, sensor_delay=Quantity("s", 0.0, 10.0)
        )


class HubCount:
    """Fuel in both hubs by the period in which it counts; rules only, without a match.

    Args:
        coin: Alliance whose hub is inactive first after a tie in auto.
        practice: Whether both hubs always count.
    """

    def __init__(self, coin: Alliance, *, practice: bool = False) -> None:
        self._coin: Alliance = coin
        self.practice = practice
        self.fuel: dict[Alliance, Counter[str]] = {alliance: Counter() for alliance in ALLIANCES}
        """Number of fuel by alliance and period."""

    @property
    def first_inactive(self) -> Alliance:
        """Alliance whose hub is inactive in shifts 1 and 3: the one with more auto fuel; in a tie that of the coin."""
        blue, red = (self.fuel[alliance]["auto"] for alliance in ALLIANCES)
        return self._coin if blue == red else "blue" if blue > red else "red"

    def is_on(self, alliance: Alliance, time: float) -> bool:
        """Return whether a hub is active at a time of the match [s], as its lights say."""
        if self.practice:
            return True
        name = MATCH.phase(time).name
        if name in ("shift 1", "shift 3"):
            return alliance != self.first_inactive
        if name in ("shift 2", "shift 4"):
            return alliance == self.first_inactive
        return time < MATCH.duration

    def period(self, alliance: Alliance, sensed: float) -> str:
        """Return the period in which a fuel counts that a hub's sensors see at a time [s]; `UNCOUNTED`: it does not."""
        before = sensed - _GRACE + _EPS
        if before >= MATCH.start("transition") and self.is_on(alliance, before):
            return _PERIODS[MATCH.phase(before).name]
        return _PERIODS[MATCH.phase(sensed).name] if self.is_on(alliance, sensed) else UNCOUNTED

    def count(self, alliance: Alliance, sensed: float) -> str:
        """Count a fuel that the sensors of a hub see at a time [s]; return its period."""
        period = self.period(alliance, sensed)
        self.fuel[alliance][period] += 1
        return period

    def light(self, alliance: Alliance, time: float) -> str:
        """Return a hub's lights: `on`, `pulsing` before it goes inactive, `off`, `purple` after the match."""
        if time >= MATCH.duration + ASSESSMENT and not self.practice:
            return "purple"
        if not self.is_on(alliance, time):
            return "off"
        return "on" if self.is_on(alliance, time + _PULSING) else "pulsing"

    def counted(self, alliance: Alliance) -> int:
        """Return the number of fuel that counts for points and ranking points."""
        fuel = self.fuel[alliance]
        return fuel.total() - fuel[UNCOUNTED]

    def hub_score(self, alliance: Alliance) -> Mapping[str, int]:
        """Return the rows of `hubScore` in FIRST's score API. A fuel that counts is worth one point."""
        fuel = self.fuel[alliance]
        rows: dict[str, int] = {}
        teleop = self.counted(alliance) - fuel["auto"]
        counts = {"auto": fuel["auto"], **{period: fuel[period] for period in _TELEOP}}
        for name, number in {**counts, "teleop": teleop, "total": self.counted(alliance)}.items():
            rows |= {f"{name}Count": number, f"{name}Points": number}
        return {**rows, UNCOUNTED: fuel[UNCOUNTED]}
