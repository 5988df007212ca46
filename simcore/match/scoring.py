"""Who scored what, when: zones that pieces cross, and the events and totals that come of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from simcore.errors import ConfigError
from simcore.pieces.shot_opening import ShotOpening
from simcore.quantities import Quantity, require_fields
from simcore.typing import Alliance, BoolArray, FloatArray, IntArray
from simcore.world.zones import Zone

__all__ = ["Alliance", "FoulEvent", "Score", "ScoreEvent", "ScoringTracker", "ScoringZone", "other_alliance"]


_ROUNDING = 1e-9  # [m]; a zone's own test may see what just touches it


def other_alliance(alliance: Alliance) -> Alliance:
    """The opponent."""
    return "red" if alliance == "blue" else "blue"


@dataclass(frozen=True, slots=True, kw_only=True)
class ScoringZone:
    """A place where pieces score."""

    name: str
    """Also the key of its breakdown."""
    alliance: Alliance
    """Who gets the points, whoever shot."""
    zone: Zone
    points: int = 1
    """Points of one piece while the zone is worth anything."""
    downward: bool = True
    """Whether only pieces on their way down count."""
    kinds: tuple[str, ...] = ()
    """Kinds of pieces that score in it; none named: all."""
    opening: ShotOpening | None = None
    """What shots have to fall through to score in it; None: nobody shoots at it."""

    def __post_init__(self) -> None:
        require_fields(self, f"ScoringZone {self.name!r}", points=Quantity("points", -1000, 1000, is_whole=True))


@dataclass(frozen=True, slots=True)
class ScoreEvent:
    """One piece in one zone."""

    time: float
    """Simulated time at the end of the tick [s]."""
    zone: str
    alliance: Alliance
    points: int
    """0 where the zone was worth nothing at the time."""
    slot: int
    """The piece."""


@dataclass(frozen=True, slots=True)
class FoulEvent:
    """A rule that a robot has broken."""

    time: float
    """Simulated time at the end of the tick [s]."""
    rule: str
    """As the game's manual numbers it."""
    robot: int
    alliance: Alliance
    """Of that robot."""
    points: int
    """That the other alliance gets."""
    text: str
    """What it did, as people read it."""

    @property
    def gains(self) -> Alliance:
        """Who gets the points."""
        return other_alliance(self.alliance)

    def __str__(self) -> str:
        return f"{self.rule}, {self.alliance} robot {self.robot} {self.text}: {self.gains} {self.points:+d}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """Points by alliance."""

    red: int
    blue: int
    total: int

    def __gt__(self, other: object) -> bool:
        """Refuse to compare two numbers with one, and name both."""
        raise ConfigError(
            f"a score has points of red and of blue, got {other!r}: did you mean score.blue or score.red?"
        )

    __ge__ = __lt__ = __le__ = __gt__


class ScoringTracker:
    """Counts pieces through zones, each piece once until it is let in again by its owner."""

    def __init__(
        self,
        zones: Iterable[ScoringZone],
        *,
        worth: Callable[[ScoringZone], int] | None = None,
        kinds: Sequence[str] = (),
    ) -> None:
        """Make a tracker.

        Args:
            zones: Where pieces score; names must differ.
            worth: Points of a piece in a zone now; None: always `zone.points`.
            kinds: Kind of the piece of each slot; needed if a zone names kinds.
        """
        self.zones = tuple(zones)
        names = [zone.name for zone in self.zones]
        if len(set(names)) != len(names):
            raise ConfigError(f"ScoringTracker: zone names must differ, got {names}")
        boxes = np.array([zone.zone.box for zone in self.zones]).reshape(-1, 2, 3)
        self._low, self._high = boxes[:, 0] - _ROUNDING, boxes[:, 1] + _ROUNDING
        self._bottom = float(self._low[:, 2].min(initial=math.inf))
        self._worth = worth or (lambda zone: zone.points)
        self._takes = [self._mask(zone, kinds) for zone in self.zones]
        self.reset()

    def reset(self) -> None:
        """Begin at zero."""
        self.events: list[ScoreEvent] = []
        """All events so far, in order."""
        self.fouls: list[FoulEvent] = []
        """All fouls so far, in order."""
        self.totals: dict[Alliance, int] = {"blue": 0, "red": 0}
        """Points by alliance."""
        self.pieces: dict[str, int] = dict.fromkeys((zone.name for zone in self.zones), 0)
        """Pieces by zone, whatever they were worth."""

    def add(self, alliance: Alliance, points: int) -> None:
        """Give points that no piece brings: for a climb, a parked robot."""
        self.totals[alliance] += points

    def foul(self, event: FoulEvent) -> None:
        """Note a foul, and give its points to the other alliance."""
        self.fouls.append(event)
        self.totals[event.gains] += event.points

    @staticmethod
    def _mask(zone: ScoringZone, kinds: Sequence[str]) -> BoolArray | None:
        """Which slots may score in a zone, shape (n,); None: all."""
        if not zone.kinds:
            return None
        unknown = set(zone.kinds) - set(kinds)
        if unknown:
            raise ConfigError(f"ScoringZone {zone.name!r}: no piece of kind {sorted(unknown)} in this game")
        return np.isin(np.array(kinds), zone.kinds)

    def update(self, time: float, slots: IntArray, start: FloatArray, end: FloatArray) -> list[ScoreEvent]:
        """Sweep pieces from where they were to where they are.

        Args:
            time: At the end of the tick [s].
            slots: The pieces that moved, shape (n,).
            start: Where they were, shape (n, 3) [m].
            end: Where they are, shape (n, 3) [m].

        Returns:
            The new events; the caller takes those pieces off the field.
        """
        if not len(slots):
            return []
        high = np.maximum(start[:, 2], end[:, 2]) >= self._bottom  # most pieces roll on the carpet, far below
        if not np.count_nonzero(high):
            return []
        slots, start, end = slots[high], start[high], end[high]
        found: list[ScoreEvent] = []
        left: BoolArray = np.ones(len(slots), dtype=bool)
        falling = end[:, 2] < start[:, 2]
        # few zones have a piece near: 102 -> 29 us a tick of a match of six
        low, top = np.minimum(start, end)[:, None], np.maximum(start, end)[:, None]
        near = np.any(np.all((top >= self._low) & (low <= self._high), axis=2), axis=0)
        for row in np.nonzero(near)[0].tolist():
            zone, takes = self.zones[row], self._takes[row]
            mine = left if takes is None else left & takes[slots]
            if not np.count_nonzero(mine):
                continue
            hit = zone.zone.crossed(start, end) & mine
            if zone.downward:
                hit &= falling
            left &= ~hit
            for slot in slots[hit].tolist():
                points = self._worth(zone)
                found.append(ScoreEvent(time, zone.name, zone.alliance, points, slot))
                self.totals[zone.alliance] += points
                self.pieces[zone.name] += 1
        self.events += found
        return found
