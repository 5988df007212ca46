"""The match clock: named phases counted in simulated time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from simcore.errors import ConfigError, require_positive
from simcore.units import plain_sum

__all__ = ["MatchClock", "Phase"]


@dataclass(frozen=True, slots=True)
class Phase:
    """A part of a match."""

    name: str
    duration: float
    """[s]."""

    def __post_init__(self) -> None:
        require_positive(f"Phase {self.name!r}", "duration", self.duration, "s")


class MatchClock:
    """Which phase a time belongs to.

    >>> clock = MatchClock([Phase("auto", 20.0), Phase("teleop", 140.0)])
    >>> clock.phase(19.9).name, clock.phase(20.0).name, clock.remaining(150.0)
    ('auto', 'teleop', 10.0)
    """

    def __init__(self, phases: Sequence[Phase]) -> None:
        if not phases:
            raise ConfigError("MatchClock: at least one phase is needed")
        self.phases = tuple(phases)

    @property
    def duration(self) -> float:
        """Of the whole match [s]."""
        return plain_sum([phase.duration for phase in self.phases])

    def start(self, name: str) -> float:
        """When a phase begins [s]."""
        time = 0.0
        for phase in self.phases:
            if phase.name == name:
                return time
            time += phase.duration
        raise ConfigError(f"MatchClock: no phase {name!r}; there are {[p.name for p in self.phases]}")

    def phase(self, time: float) -> Phase:
        """The phase at a time since the start of the match [s]; after the end, the last one."""
        for phase in self.phases:
            if time < phase.duration - 1e-9:
                return phase
            time -= phase.duration
        return self.phases[-1]

    def remaining(self, time: float) -> float:
        """Time left in the match [s]."""
        return max(0.0, self.duration - time)
