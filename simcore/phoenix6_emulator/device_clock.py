"""Simulated time of the devices, and the enable signal, which reaches them a little later than it is fed.

Time is whole nanoseconds, so that it never drifts, with a control loop each millisecond. On the wall clock a device of
CTRE's simulation drives 49 ms after the driver station enables, and stops 86 ms after it disables; most of that is the
period of the enable frame.
"""

from __future__ import annotations

from dataclasses import dataclass

from simcore.errors import ConfigError

__all__ = ["LOOP", "LOOP_NS", "EnableDelays", "EnableState", "SimulatedClock"]

LOOP_NS = 1_000_000
"""Period of a device's control loop [ns]."""
LOOP = 1e-3
"""Period of a device's control loop [s]."""


class SimulatedClock:
    """Time since the devices were switched on; `phoenix6.utils.get_current_time_seconds()` reads it."""

    __slots__ = ("loop_ns", "next_frame_ns", "ns")

    def __init__(self) -> None:
        self.ns = 0
        """Time [ns]."""
        self.loop_ns = 0
        """Time of the last control loop [ns]."""
        self.next_frame_ns = 0
        """Before this no device has a status frame to send [ns]; 0 where devices or rates have changed."""

    def reset(self, start: float = 0.0) -> None:
        """Begin again, at `start` [s]."""
        self.ns = self.loop_ns = round(start * 1e9)
        self.next_frame_ns = 0

    @property
    def now(self) -> float:
        """Time [s]."""
        return self.ns * 1e-9


_PERIOD_NS = 10_000_000
"""Period of the feed [ns]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EnableDelays:
    """Delays from the enable feed to the devices."""

    enable: float = 0.045
    """From the first feed to the first volts [s]; measured 49 ms from the driver station, of which 4 are the feed."""
    disable: float = 0.080
    """From a feed of zero to none [s]; measured 86 ms from the driver station."""

    def __post_init__(self) -> None:
        if not (0.0 <= self.enable < 1.0 and 0.0 <= self.disable < 1.0):
            raise ConfigError(f"enable delays must be 0..1 s, got enable={self.enable}, disable={self.disable}")


class EnableState:
    """The enable signal of all devices.

    Args:
        clock: Simulated time.
        delays: From feed to effect.
    """

    __slots__ = ("_clock", "_fed_until", "_since", "_until", "delays")

    def __init__(self, clock: SimulatedClock, delays: EnableDelays) -> None:
        self._clock = clock
        self.delays = delays
        """From feed to effect."""
        self._fed_until = -1
        self._since = 0
        self._until = -1

    def feed(self, milliseconds: int) -> None:
        """Enable for this long from now [ms]; 0 disables."""
        # The feed runs on a thread of its own. Where it meets a step of the physics either may come first; rounded up
        # to the feed's period both orders give the same time.
        now = -(-self._clock.ns // _PERIOD_NS) * _PERIOD_NS
        if milliseconds <= 0:
            if self.is_fed:
                self._fed_until = now
                self._until = now + round(self.delays.disable * 1e9)
            return
        if not self.is_fed:
            # A device that still drives from before goes on.
            self._since = now if self.is_enabled else now + round(self.delays.enable * 1e9)
        self._fed_until = self._until = now + milliseconds * 1_000_000

    @property
    def is_fed(self) -> bool:
        """Whether the feed of the library is in force."""
        return self._fed_until > self._clock.ns

    @property
    def is_enabled(self) -> bool:
        """Whether devices drive."""
        return self._since <= self._clock.ns < self._until
