"""One tire on carpet: Coulomb friction that a solver can handle, and the circle it must stay in."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simcore.typing import FloatArray

__all__ = ["WheelContact", "on_friction_circle", "slip_scale", "tire_force"]


@dataclass(frozen=True, slots=True)
class WheelContact:
    """One wheel on the carpet."""

    x: float
    """From the center of mass, forward [m]."""
    y: float
    """From the center of mass, left [m]."""
    tread: float
    """Coefficient of friction [-]."""
    rolling_resistance: float
    """Drag per load [-]."""


def slip_scale(rolling_speed: float, slip_ratio: float, slip_speed: float) -> float:
    """Slip at which a tire reaches its grip [m/s]: a share of the rolling speed, and a little at standstill.

    Small on purpose. A robot that does not skid then keeps its odometry within 1 %, and one parked on a ramp
    creeps by well under a millimeter a second. The implicit solver does not mind how small it is.
    """
    return slip_ratio * abs(rolling_speed) + slip_speed


def tire_force(slip: FloatArray, grip: FloatArray, scale: FloatArray) -> FloatArray:
    """Force on the robot for a given slip: F = grip * s / max(|s|, scale), the law that the solver satisfies.

    Args:
        slip: Tread relative to the ground, backwards at the contact: (r w - v_l, -v_t) [m/s], shape (n, 2).
        grip: mu N [N], shape (n,).
        scale: See `slip_scale` [m/s], shape (n,).

    Returns:
        Force along and across the wheel [N], shape (n, 2).
    """
    size = np.linalg.norm(slip, axis=1)
    share: FloatArray = grip / np.maximum(size, scale)
    return slip * share[:, None]


def on_friction_circle(force: FloatArray, grip: FloatArray) -> FloatArray:
    """Shorten forces to their grip, keeping the direction.

    Args:
        force: [N], shape (n, 2).
        grip: mu N [N], shape (n,).
    """
    size = np.linalg.norm(force, axis=1)
    share: FloatArray = np.minimum(1.0, grip / np.maximum(size, 1e-12))
    return force * share[:, None]
