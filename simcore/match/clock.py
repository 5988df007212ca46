"""Match clock: a timetable of named phases, and a timer with the current match time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from simcore.errors import ConfigError
from simcore.quantities import DURATION, require_fields
from simcore.units import plain_sum

__all__ = ["MatchClock", "MatchTimer", "Mode", "Phase"]

Mode: TypeAlias = Literal["auto", "disabled", "teleop"]
"""Robot mode, as selected at a driver station."""


@dataclass(frozen=True, slots=True)
class Phase:
    """Phase of a match: name, duration and robot mode."""

    name: str
    duration: float
    """Duration of the phase [s]."""
    mode: Mode = "teleop"

    def __post_init__(self) -> None:
        require_fields(self, f"Phase {self.name!r}", duration=DURATION)


class MatchClock:
    """Timetable of a match: named phases, one after another.

    >>> clock = MatchClock([Phase("auto", 20.0, "auto"), Phase("teleop", 140.0)])
    >>> clock.phase(19.9).name, clock.phase(20.0).name, clock.remaining(150.0)
    ('auto', 'teleop', 10.0)
    """

    def __init__(self, phases: Sequence[Phase]) -> None:
        if not phases:
            raise ConfigError("MatchClock: at least one phase is needed")
        self.phases = tuple(phases)
        names = [phase.name for phase in self.phases]
        if len(set(names)) < len(names):
            raise ConfigError(f"MatchClock: names of phases must differ, got {names}")
        self.duration = plain_sum(phase.duration for phase in self.phases)
        """Duration of the whole match [s]."""

    def start(self, name: str) -> float:
        """Return the match time at which a phase begins [s].

        Raises:
            ConfigError: If the clock has no phase of this name.
        """
        time = 0.0
        for phase in self.phases:
            if phase.name == name:
                return time
            time += phase.duration
        raise ConfigError(f"MatchClock: no phase {name!r}; there are {[p.name for p in self.phases]}")

    def start_of_mode(self, mode: Mode) -> float:
        """Return the match time at which the first phase of a mode begins [s].

        Raises:
            ConfigError: If the clock has no phase of this mode.
        """
        for phase in self.phases:
            if isinstance(mode, str) and phase.mode == mode:
                return self.start(phase.name)
        raise ConfigError(f"MatchClock: no phase of mode {mode!r} among {[p.name for p in self.phases]}")

    def phase(self, time: float) -> Phase:
        """Return the phase at a match time [s]; after the end of the match, return the last phase."""
        for phase in self.phases:
            if time < phase.duration - 1e-9:
                return phase
            time -= phase.duration
        return self.phases[-1]

    def remaining(self, time: float) -> float:
        """Return the time left until the end of the match at a match time [s]; 0 after the end."""
        return max(0.0, self.duration - time)


class MatchTimer:
    """Timer with the current match time, for scoring, telemetry and rules.

    Without a driver station, the time starts with the first tick and never stops. With a driver station, the time
    starts when robots are first enabled and stops while robots are disabled, except in disabled phases and after the
    match.
    """

    def __init__(self, clock: MatchClock) -> None:
        self.clock = clock
        self.time = 0.0
        """Match time: simulated time since the start of the first phase, without stops [s]."""
        self._ticks = 0
        self._start = 0.0
        self._enabled: bool | None = None  # None without a driver station

    @property
    def phase(self) -> Phase:
        """Phase of the match at the current match time; the last phase after the end of the match."""
        return self.clock.phase(self.time)

    @property
    def remaining(self) -> float:
        """Time left until the end of the match [s]."""
        return self.clock.remaining(self.time)

    @property
    def is_over(self) -> bool:
        """Whether the last phase has ended."""
        return self.time >= self.clock.duration - 1e-9

    @property
    def is_enabled(self) -> bool:
        """Whether robots are enabled.

        A driver station sets this value with `set_enabled`. Without a driver station, robots are enabled until the end
        of the match, except in phases with mode `disabled`.
        """
        if self._enabled is not None:
            return self._enabled
        return not self.is_over and self.phase.mode != "disabled"

    def follow_driver_station(self) -> None:
        """Disable the robots and stop the match time until a driver station enables the robots with `set_enabled`."""
        self._enabled = False

    def start(self, mode: Mode) -> None:
        """Set the match time to the start of the first phase of a mode that a driver station has just enabled.

        Raises:
            ConfigError: If the clock has no phase of this mode.
        """
        self._start = self.clock.start_of_mode(mode)
        self._ticks = 0
        self.time = self._start

    def set_enabled(self, enabled: bool) -> None:
        """Enable or disable the robots on behalf of a driver station."""
        self._enabled = enabled

    def advance(self, dt: float) -> None:
        """Advance the match time by one tick of dt [s], unless the driver station has stopped the match time."""
        if self._enabled is False and not self.is_over and (self.phase.mode != "disabled"):
            return
        self._ticks += 1
        self.time = self._start + self._ticks * dt  # a running sum would drift from the number of ticks
