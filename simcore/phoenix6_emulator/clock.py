"""Simulated time of the devices: whole nanoseconds, so that it never drifts, and a control loop each millisecond."""

from __future__ import annotations

__all__ = ["LOOP", "LOOP_NS", "SimulatedClock"]

LOOP_NS = 1_000_000
"""Period of a device's control loop [ns]."""
LOOP = 1e-3
"""Period of a device's control loop [s]."""


class SimulatedClock:
    """Time since the devices were switched on; `phoenix6.utils.get_current_time_seconds()` reads it."""

    __slots__ = ("next_frame_ns", "ns")

    def __init__(self) -> None:
        self.ns = 0
        """Time [ns]."""
        self.next_frame_ns = 0
        """Before this no device has a status frame to send [ns]; 0 where devices or rates have changed."""

    @property
    def now(self) -> float:
        """Time [s]."""
        return self.ns * 1e-9
