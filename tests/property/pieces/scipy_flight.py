"""The flight of a piece by scipy, to compare faster methods with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from simcore.errors import NonFiniteError
from simcore.loop.contact import air_acceleration
from simcore.pieces.aerodynamics import AirFactors
from simcore.quantities import DURATION, require
from simcore.typing import FloatArray
from simcore.units import GRAVITY

__all__ = ["Flight", "fly"]

_VACUUM = AirFactors()


@dataclass(frozen=True, slots=True, kw_only=True)
class Flight:
    """A trajectory, one row per sample; the last row is where it ended."""

    time: FloatArray
    """Since the launch [s], shape (m,)."""
    pos: FloatArray
    """Center, field frame [m], shape (m, 3)."""
    velocity: FloatArray
    """Field frame [m/s], shape (m, 3)."""
    landed: bool
    """Whether it came down through the stop height; if not, time ran out."""


def fly(
    pos: FloatArray,
    velocity: FloatArray,
    *,
    air: AirFactors = _VACUUM,
    spin: FloatArray | None = None,
    stop_height: float = 0.0,
    max_time: float = 10.0,
    sample_period: float = 0.02,
    gravity: float = GRAVITY,
) -> Flight:
    """Fly one piece until it falls through a height. Takes some 20 ms: not for the hot loop.

    Args:
        pos: Start, field frame [m], shape (3,).
        velocity: At the start, field frame [m/s], shape (3,).
        air: Drag and lift; none by default.
        spin: Angular velocity, kept through the flight [rad/s], shape (3,); None is no spin.
        stop_height: The flight ends when the center falls through it [m]. A piece that starts below has to rise first.
        max_time: The flight ends here at the latest [s].
        sample_period: Between rows of the result [s].
        gravity: Downward [m/s^2].

    Raises:
        NonFiniteError: If the start is not finite.
    """
    start = np.concatenate([np.asarray(pos, dtype=np.float64), np.asarray(velocity, dtype=np.float64)])
    omega = np.zeros((1, 3)) if spin is None else np.asarray(spin, dtype=np.float64).reshape(1, 3)
    if start.shape != (6,) or not (np.isfinite(start).all() and np.isfinite(omega).all()):
        raise NonFiniteError(f"fly: position, velocity and spin must be 3 finite numbers each, got {pos}, {velocity}")
    require("fly", "max_time", max_time, DURATION)
    require("fly", "sample_period", sample_period, DURATION)

    def law(_: float, state: FloatArray) -> FloatArray:
        acceleration = np.array(air_acceleration(*state[3:], *omega[0], *map(float, air[:3])))
        acceleration[2] -= gravity
        return np.concatenate([state[3:], acceleration])

    def falls_through(_: float, state: FloatArray) -> float:
        return float(state[2] - stop_height)

    falls_through.terminal = True  # type: ignore[attr-defined]
    falls_through.direction = -1.0  # type: ignore[attr-defined]
    # A step must not jump over the time that the piece is above the stop height: solve_ivp would see no crossing.
    solution = solve_ivp(
        law, (0.0, max_time), start, events=falls_through, dense_output=True, rtol=1e-9, atol=1e-10, max_step=0.02
    )
    assert solution.sol is not None
    end = float(solution.t[-1])
    time = np.append(np.arange(0.0, end, sample_period), end)
    rows = np.asarray(solution.sol(time)).T
    rows[-1] = solution.y[:, -1]
    return Flight(time=time, pos=rows[:, :3].copy(), velocity=rows[:, 3:].copy(), landed=solution.status == 1)
