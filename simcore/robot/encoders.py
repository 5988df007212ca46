"""Encoder readings at 250 Hz with time stamps, as high-rate odometry reads them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from simcore.errors import require_positive
from simcore.typing import FloatArray

__all__ = ["EncoderCache", "EncoderSamples", "angles_after"]


@dataclass(frozen=True, slots=True, kw_only=True)
class EncoderSamples:
    """Readings since the last drain, oldest first: k samples of n modules."""

    time: FloatArray
    """Simulated time of each sample [s], shape (k,)."""
    wheel_angle: FloatArray
    """Of the wheels [rad], any number of turns, shape (k, n)."""
    steer_angle: FloatArray
    """Of the azimuths [rad], any number of turns, shape (k, n)."""


_Row = tuple[float, float, Sequence[float], Sequence[float], Sequence[float], Sequence[float]]


def _back(angles: list[Sequence[float]], speeds: list[Sequence[float]], back: FloatArray) -> FloatArray:
    """Angles `back` seconds before they were taken, shape (k, n)."""
    angle: FloatArray = np.array(angles)
    speed: FloatArray = np.array(speeds)
    return angle - speed * back[:, None] if len(angles) else angle


def angles_after(angles: Sequence[float], before: Sequence[float], after: Sequence[float], h: float) -> list[float]:
    """Angles after a step of `h` [s] in which speeds went from `before` to `after` [rad/s].

    With the mean speed, as the robot itself moves: an encoder on a wheel that rolls reads the robot's way.
    """
    half = 0.5 * h
    return [a + (w0 + w1) * half for a, w0, w1 in zip(angles, before, after, strict=True)]


class EncoderCache:
    """Samples two angles per module on a fixed time grid, between the solver's own steps.

    The solver moves at constant speed within a step, so a straight line between its ends is exact.
    """

    def __init__(self, n: int, *, rate: float = 250.0, capacity: int = 500) -> None:
        require_positive("encoder cache", "rate", rate, "Hz")
        self._n = n
        self._period = 1.0 / rate
        self._capacity = capacity
        self.clear(0.0)

    def clear(self, time: float) -> None:
        """Forget all samples; the next one is due one period after `time` [s]."""
        self._start = time
        self._taken = 0
        self.due = time + self._period
        """Time of the next sample [s]."""
        self._rows: list[_Row] = []
        self.dropped = 0
        """Samples lost because nobody drained them."""

    def record(
        self,
        end: float,
        h: float,
        wheel_angle: Sequence[float],
        wheel_speed: Sequence[float],
        steer_angle: Sequence[float],
        steer_speed: Sequence[float],
    ) -> None:
        """Take the samples that fall in the step of length `h` that ends now at `end` [s]."""
        # A billionth of a second of slack: sums of 0.0025 must not miss a sample at 0.02.
        while self.due <= end + 1e-9:
            # Interpolated when somebody drains: most samples are taken and never looked at (2.0 -> 0.7 us).
            back = min(h, max(0.0, end - self.due))
            self._rows.append((self.due, back, wheel_angle[:], wheel_speed[:], steer_angle[:], steer_speed[:]))
            self._taken += 1
            self.due = self._start + (self._taken + 1) * self._period
            if len(self._rows) > self._capacity:
                del self._rows[0]
                self.dropped += 1

    def drain(self) -> EncoderSamples:
        """Hand out all samples since the last call."""
        rows, self._rows = self._rows, []
        k = len(rows)
        back = np.array([r[1] for r in rows])
        return EncoderSamples(
            time=np.array([r[0] for r in rows]),
            wheel_angle=_back([r[2] for r in rows], [r[3] for r in rows], back).reshape(k, self._n),
            steer_angle=_back([r[4] for r in rows], [r[5] for r in rows], back).reshape(k, self._n),
        )
