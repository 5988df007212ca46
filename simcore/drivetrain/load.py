"""How much of the robot each wheel carries."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from simcore.typing import FloatArray

__all__ = ["WheeledRobot", "load_shares", "normal_loads"]


class WheeledRobot(Protocol):
    """What loads depend on; swerve and tank configs both have it."""

    @property
    def mass(self) -> float:
        """Of the whole robot [kg]."""
        ...

    @property
    def yaw_inertia(self) -> float:
        """About the vertical axis through the center of mass [kg m^2]."""
        ...

    @property
    def center_of_mass(self) -> tuple[float, float, float]:
        """From the robot center on the floor, robot axes [m]."""
        ...

    @property
    def positions(self) -> Sequence[tuple[float, float]]:
        """Of the wheels relative to the center of mass, robot axes [m]."""
        ...


def normal_loads(
    config: WheeledRobot,
    touching: Sequence[bool],
    gravity_robot: Sequence[float],
    accel_robot: Sequence[float] = (0.0, 0.0, 0.0),
) -> list[float]:
    """Normal load of each wheel from gravity, acceleration and which wheels touch.

    The ground has to give the chassis f = m (a - g). Its vertical part is shared so that the forces at the contact
    points make no moment about the center of mass (a rigid chassis that is not just tipping):

        sum N_i = f_z,   sum N_i x_i = -height f_x,   sum N_i y_i = -height f_y

    Speeding up puts load on the rear axle, a left turn on the right wheels, and a slope on the lower ones. With more
    than three wheels the load with the least squares is taken (equal springs under every wheel). A wheel that would
    have to pull on the floor lifts instead.

    Args:
        config: Places of the wheels, mass, center of mass.
        touching: Per wheel, whether it is on the ground.
        gravity_robot: Acceleration of gravity, robot axes [m/s^2], shape (3,); level ground: (0, 0, -9.80665).
        accel_robot: Of the center of mass, robot axes, as seen from the field [m/s^2], shape (3,).

    Returns:
        Loads [N], each >= 0, 0 where nothing touches; they add up to f_z, or are all 0 in free fall.
    """
    force_x = config.mass * (accel_robot[0] - gravity_robot[0])
    force_y = config.mass * (accel_robot[1] - gravity_robot[1])
    force_z = config.mass * (accel_robot[2] - gravity_robot[2])
    places = config.positions
    loads = [0.0] * len(places)
    rows = [i for i, down in enumerate(touching) if down]
    if force_z <= 0.0 or not rows:
        return loads
    height = config.center_of_mass[2]
    want_x = -height * force_x
    want_y = -height * force_y
    while True:
        share = _share(places, rows, force_z, want_x, want_y)
        lowest = min(range(len(rows)), key=share.__getitem__)
        if share[lowest] >= -1e-12 * force_z:
            break
        del rows[lowest]  # it lifts; at least one wheel stays, as the shares add up to f_z > 0
    for i, load in zip(rows, share, strict=True):
        loads[i] = max(0.0, load)
    return loads


def _share(
    places: Sequence[tuple[float, float]], rows: Sequence[int], force: float, want_x: float, want_y: float
) -> list[float]:
    """Loads N = p + q x + r y that meet the three balances best; the sum is met exactly."""
    n = len(rows)
    mean_x = sum(places[i][0] for i in rows) / n
    mean_y = sum(places[i][1] for i in rows) / n
    # About the mean of the contacts: the sum decouples from the two moments.
    xx = yy = xy = 0.0
    for i in rows:
        dx = places[i][0] - mean_x
        dy = places[i][1] - mean_y
        xx += dx * dx
        yy += dy * dy
        xy += dx * dy
    moment_x = want_x - force * mean_x
    moment_y = want_y - force * mean_y
    q = r = 0.0
    det = xx * yy - xy * xy
    spread = xx + yy
    if spread < n * 1e-6:
        pass  # contacts within a millimeter are one point: it carries all, moments go unmet
    elif det > 1e-9 * spread * spread:
        q = (moment_x * yy - moment_y * xy) / det
        r = (moment_y * xx - moment_x * xy) / det
    else:  # contacts on one line: only the moment along it can be met
        scale = (xx * moment_x + xy * moment_y, xy * moment_x + yy * moment_y)
        q = scale[0] / (spread * spread)
        r = scale[1] / (spread * spread)
    return [force / n + q * (places[i][0] - mean_x) + r * (places[i][1] - mean_y) for i in rows]


def load_shares(config: WheeledRobot) -> FloatArray:
    """Share of the weight on each wheel at rest on level ground, shape (n,); adds up to 1."""
    loads = np.array(normal_loads(config, [True] * len(config.positions), (0.0, 0.0, -1.0)))
    return loads / config.mass
