"""Cuts the owner's step into inner steps and follows the turning robot through them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from simcore.errors import NonFiniteError
from simcore.robot.tire_solver import TireSolver
from simcore.typing import FloatArray

__all__ = ["MAX_INNER_STEP", "Forces", "follow_frame", "mean_forces"]

MAX_INNER_STEP = 0.005
"""Longest step of motors and tires [s]; a longer step of the owner is cut into equal parts.

With 5 ms all of `scripts/drivetrain_figures.py` is within tolerance, as with 4 and 1; a tick of a robot in the open
takes four inner steps, with 4 ms it took 5.2 on average.
"""


Forces = list[tuple[list[float], list[float]]]
"""Per inner step: forward and leftward force of every wheel, in the robot axes of that moment [N]."""


def mean_forces(forces: Forces, n: int) -> FloatArray:
    """Mean over the inner steps, shape (n, 2); averaged when asked, not every step."""
    if not forces:
        return np.zeros((n, 2))
    mean: FloatArray = np.mean(np.array(forces), axis=0).T
    return mean


class InnerStep(Protocol):
    """Moves motors and wheels by `h` and returns the new velocity in the robot axes of that moment."""

    def __call__(
        self, h: float, vx: float, vy: float, omega: float, loads: Sequence[float], /
    ) -> tuple[float, float, float]:
        """Advance."""
        ...


def follow_frame(
    inner: InnerStep,
    solver: TireSolver,
    h: float,
    vx: float,
    vy: float,
    omega: float,
    loads: Sequence[float],
    ax: float,
    ay: float,
) -> tuple[tuple[float, float, float], Forces]:
    """Change of velocity by the tires over `h`, in the robot axes at its start, and the wheel forces.

    A robot that spins at 12 rad/s turns by 3.4 degrees in 5 ms. Each inner step therefore sees the velocity in the
    axes of its own moment, and its impulse is turned back to the axes of the start.

    Args:
        inner: One inner step of the drivetrain.
        solver: Whose wheel forces are collected.
        h: Time step of the owner [s].
        vx: Velocity at the start, robot axes of the start [m/s].
        vy: To the left [m/s].
        omega: Yaw rate [rad/s].
        loads: Per wheel [N].
        ax: Acceleration that the owner adds itself, robot axes of the start [m/s^2].
        ay: To the left [m/s^2].

    Returns:
        Changes (m/s, m/s, rad/s), and per inner step the wheel forces for `mean_forces`.

    Raises:
        NonFiniteError: When an argument is not finite or h is not above zero; nothing has changed.
    """
    if not (math.isfinite(h + vx + vy + omega + ax + ay + sum(loads)) and h > 0.0):
        raise NonFiniteError(
            f"drivetrain step needs finite numbers and h > 0, got h={h}, velocity=({vx}, {vy}, {omega}), "
            f"acceleration=({ax}, {ay}), loads={list(loads)}"
        )
    # A numpy number from the owner would turn all arithmetic below into numpy calls, ten times slower.
    vx, vy, omega, loads = float(vx), float(vy), float(omega), [float(load) for load in loads]
    parts = math.ceil(h / MAX_INNER_STEP - 1e-9)
    dt = h / parts
    dx = dy = turned = 0.0
    start = omega
    forces: Forces = []
    c, s = 1.0, 0.0
    for part in range(parts):
        if part > 0:
            turned += omega * dt
            c = math.cos(turned)
            s = math.sin(turned)
        wx = vx + dx + ax * dt * (part + 1)
        wy = vy + dy + ay * dt * (part + 1)
        ux = c * wx + s * wy
        uy = c * wy - s * wx
        nx, ny, omega = inner(dt, ux, uy, omega, loads)
        jx = nx - ux
        jy = ny - uy
        dx += c * jx - s * jy
        dy += s * jx + c * jy
        forces.append((solver.force_x, solver.force_y))
    return (dx, dy, omega - start), forces
