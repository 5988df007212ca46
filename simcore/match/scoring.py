"""Scoring: zones in which pieces score, fouls, events, and points of the alliances."""

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


_ROUNDING = 1e-9  # [m]; margin for pieces that just touch a zone, which the zone's own test may accept


def other_alliance(alliance: Alliance) -> Alliance:
    """Return the opposing alliance."""
    return "red" if alliance == "blue" else "blue"


@dataclass(frozen=True, slots=True, kw_only=True)
class ScoringZone:
    """Zone in which pieces score points for an alliance."""

    name: str
    """Name of the zone, also used as key in the breakdown of the score."""
    alliance: Alliance
    """Alliance that receives the points, regardless of the alliance of the robot."""
    zone: Zone
    points: int = 1
    """Points for each piece while the zone is active."""
    downward: bool = True
    """Whether only falling pieces score in the zone."""
    kinds: tuple[str, ...] = ()
    """Kinds of pieces that score in the zone; empty for all kinds."""
    opening: ShotOpening | None = None
    """Opening through which shots must fall; None if the zone is not a target of shots."""

    def __post_init__(self) -> None:
        require_fields(self, f"ScoringZone {self.name!r}", points=Quantity("points", -1000, 1000, is_whole=True))


@dataclass(frozen=True, slots=True)
class ScoreEvent:
    """Record of a piece that has scored in a zone."""

    time: float
    """Simulated time at the end of the tick [s]."""
    zone: str
    alliance: Alliance
    points: int
    """Points for the piece; 0 if the zone was inactive."""
    slot: int
    """Slot of the piece."""


@dataclass(frozen=True, slots=True)
class FoulEvent:
    """Foul: violation of a rule by a robot, with the points for the other alliance."""

    time: float
    """Simulated time at the end of the tick [s]."""
    rule: str
    """Number of the rule in the game's manual."""
    robot: int
    alliance: Alliance
    """Alliance of the robot that broke the rule."""
    points: int
    """Points for the other alliance."""
    text: str
    """Description of the violation, worded to follow "robot 0" in a message."""

    @property
    def gains(self) -> Alliance:
        """Alliance that receives the points for the foul."""
        return other_alliance(self.alliance)

    def __str__(self) -> str:
        return f"{self.rule}, {self.alliance} robot {self.robot} {self.text}: {self.gains} {self.points:+d}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """Points of each alliance, and sum of the points of both alliances.

    Comparison with `<` or `>` raises an error.
    """

    red: int
    blue: int
    total: int

    def __gt__(self, other: object) -> bool:
        """Raise a `ConfigError`, because the points of two alliances have no common order."""
        raise ConfigError(
            f"a score has points of red and of blue, got {other!r}: did you mean score.blue or score.red?"
        )

    __ge__ = __lt__ = __le__ = __gt__


class ScoringTracker:
    """Tracker of pieces that enter scoring zones, of fouls, and of the points of each alliance."""

    def __init__(
        self,
        zones: Iterable[ScoringZone],
        *,
        worth: Callable[[ScoringZone], int] | None = None,
        kinds: Sequence[str] = (),
    ) -> None:
        """Initialize a tracker without events.

        Args:
            zones: Zones in which pieces score; the names must differ.
            worth: Function that returns the points for a piece in a zone at the current time; None for `zone.points`.
            kinds: Kind of the piece in each slot, required if a zone lists kinds.
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
        """Clear all scoring events, fouls, points and counts of pieces."""
        self.events: list[ScoreEvent] = []
        """All scoring events so far, oldest first."""
        self.fouls: list[FoulEvent] = []
        """All fouls so far, oldest first."""
        self.totals: dict[Alliance, int] = {"blue": 0, "red": 0}
        """Points of each alliance so far, with the points for fouls of the other alliance."""
        self.pieces: dict[str, int] = dict.fromkeys((zone.name for zone in self.zones), 0)
        """Number of pieces that have scored in each zone, including pieces without points."""

    def add(self, alliance: Alliance, points: int) -> None:
        """Add points to an alliance's total that are not for a piece, e.g. for a climb or a parked robot."""
        self.totals[alliance] += points

    def foul(self, event: FoulEvent) -> None:
        """Record a foul, and add the points for the foul to the other alliance's total."""
        self.fouls.append(event)
        self.totals[event.gains] += event.points

    @staticmethod
    def _mask(zone: ScoringZone, kinds: Sequence[str]) -> BoolArray | None:
        """Return a mask of the slots whose pieces may score in a zone, shape (n,); None if all pieces may score."""
        if not zone.kinds:
            return None
        unknown = set(zone.kinds) - set(kinds)
        if unknown:
            raise ConfigError(f"ScoringZone {zone.name!r}: no piece of kind {sorted(unknown)} in this game")
        return np.isin(np.array(kinds), zone.kinds)

    def update(self, time: float, slots: IntArray, start: FloatArray, end: FloatArray) -> list[ScoreEvent]:
        """Score the pieces that have entered a zone during a tick, and add the points to the totals.

        A piece scores at most once per call.

        Args:
            time: Simulated time at the end of the tick [s].
            slots: Slots of the pieces that moved, shape (n,).
            start: Positions at the start of the tick, field frame [m], shape (n, 3).
            end: Positions at the end of the tick, field frame [m], shape (n, 3).

        Returns:
            New scoring events; the caller must remove the scored pieces from the field.
        """
        if not len(slots):
            return []
        high = np.maximum(start[:, 2], end[:, 2]) >= self._bottom  # most pieces roll on the carpet, below all zones
        if not np.count_nonzero(high):
            return []
        slots, start, end = slots[high], start[high], end[high]
        found: list[ScoreEvent] = []
        left: BoolArray = np.ones(len(slots), dtype=bool)
        falling = end[:, 2] < start[:, 2]
        # few zones have a piece nearby: 102 -> 29 us per tick of a match of six robots
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
