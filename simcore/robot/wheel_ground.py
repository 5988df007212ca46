"""What is under a robot's wheels, and how high it is above that."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from simcore.errors import ConfigError, NonFiniteError
from simcore.geometry.rotation import IDENTITY, Quaternion, Vector, from_rpy, from_yaw, matrix, multiply
from simcore.physics.world import PhysicsWorld
from simcore.robot.chassis_config import ChassisConfig
from simcore.typing import FloatArray

__all__ = ["GroundClearance", "WheelGround", "ground_clearance"]

_CONTACT_GAP = 0.004  # [m]; a wheel this close to the ground carries load
_SINK = -2e-5  # [m]; a gap of exactly 0 is no contact yet, and the first step would fall
_ABOVE, _BELOW = 2.0, -1.0  # [m]; heights between which ground is looked for
_ROUNDS = 4  # a tilt moves the wheels, which stand elsewhere then


class WheelGround:
    """Which wheels of a robot touch the ground, and how high it is under each.

    Args:
        world: Where the robot is.
        row: Of its body.
        config: Where its wheels are.
    """

    def __init__(self, world: PhysicsWorld, row: int, config: ChassisConfig) -> None:
        self._world, self._row, self._radius = world, row, config.wheel_radius
        self._hubs = np.array([(x, y, config.wheel_radius) for x, y in config.wheel_positions])
        self._soles = np.array([(x, y, -_CONTACT_GAP) for x, y in config.wheel_positions])
        self._contacts = np.array([(x, y, 0.0) for x, y in config.wheel_positions])
        self._all_touching = [True] * len(config.wheel_positions)
        half = 0.5 * config.bumper_length, 0.5 * config.bumper_width
        below = [
            (x * half[0], y * half[1], config.clearance) for x in np.linspace(-1, 1, 9) for y in np.linspace(-1, 1, 9)
        ]
        self._underside = np.array([*self._contacts.tolist(), *below])
        self._half_diagonal = math.hypot(*half)
        self.reach = max(math.hypot(x, y) for x, y in config.wheel_positions)
        """Of the wheels from the robot's origin [m]."""
        self.touching = list(self._all_touching)
        """Which wheels were on the ground in the last `find`."""

    def stand(self) -> None:
        """All wheels touch: it stands level on the flat carpet."""
        self.touching = self._all_touching

    def find(self, pos: Vector, quat: Quaternion) -> None:
        """Which wheels touch, of a robot that does not stand level: those whose short ray down meets something.

        And those that touch what carries robots elsewhere: a wheel at the edge of a bar stands on it and pulls there.

        Args:
            pos: Of the robot's origin, field frame [m].
            quat: Attitude of the robot.
        """
        turn = matrix(quat).T
        start = self._hubs @ turn + pos
        end = self._soles @ turn + pos
        touching = self._world.ground_rays(start, end).row >= 0
        if not touching.all():
            places = self._world.ground_contacts(self._row)
            if len(places):
                away = np.linalg.norm(start[:, None] - places, axis=2).min(axis=1)
                touching |= away < self._radius + _CONTACT_GAP
        self.touching = touching.tolist()

    def standing(self, x: float, y: float, yaw: float) -> tuple[Vector, Quaternion]:
        """How a robot stands somewhere at rest: level on the carpet, tilted on what robots drive over.

        Wheels and underside are above the ground, and its origin as low as that allows: a linear program.

        Args:
            x: Field frame [m].
            y: The same [m].
            yaw: Heading [rad].

        Returns:
            Place of the robot's origin, field frame [m], and its attitude.
        """
        pos, quat, level = (x, y, _SINK), from_yaw(yaw), from_yaw(yaw)
        if self._world.is_flat(x, y, self._half_diagonal):
            return pos, quat
        tilt, rows, heights = IDENTITY, np.empty((0, 3)), np.empty(0)
        for _ in range(_ROUNDS):
            points = self._underside @ matrix(tilt).T
            start = points @ matrix(level).T + (x, y, 0.0)
            end = start.copy()
            start[:, 2], end[:, 2] = _ABOVE, _BELOW
            hits = self._world.ground_rays(start, end)
            is_over = np.asarray(hits.row) >= 0
            if is_over.sum() < 3:
                return (x, y, _SINK), level
            ground = _ABOVE + (_BELOW - _ABOVE) * np.asarray(hits.fraction)[is_over]
            flat = points[is_over]
            lift = flat[:, 2] - _plane_heights(flat, tilt)  # of each point over the plane of the wheels' soles
            rows = np.vstack([rows, np.column_stack([np.ones(len(flat)), flat[:, :2]])])
            heights = np.append(heights, ground - lift)  # those of earlier rounds, too: or it may tilt to and fro
            from scipy.optimize import linprog  # 0.1 s, and on a flat floor not needed

            found = linprog(
                (1.0, 0.0, 0.0),
                A_ub=-rows,
                b_ub=-heights,
                bounds=[(None, None), (-1.0, 1.0), (-1.0, 1.0)],
            )
            if found.x is None:  # all that carries it is on one side
                return (x, y, _SINK), level
            height, along, aside = found.x.tolist()
            size = math.sqrt(1.0 + along * along + aside * aside)
            tilt = from_rpy(math.asin(aside / size), math.atan2(-along, 1.0), 0.0)
            pos, quat = (x, y, height + _SINK), multiply(level, tilt)
        return pos, quat

    def under(self, pos: Vector, quat: Quaternion) -> tuple[FloatArray, FloatArray]:
        """See `ChassisSimulation.wheel_ground`; for the arguments see `find`."""
        soles = self._contacts @ matrix(quat).T + pos
        if self._world.is_flat(pos[0], pos[1], self.reach):
            return soles, np.zeros(len(soles))
        start = soles + np.array((0.0, 0.0, self._radius))
        hits = self._world.ground_rays(start, start - np.array((0.0, 0.0, 5.0)))
        return soles, start[:, 2] - 5.0 * hits.fraction


def _plane_heights(points: FloatArray, tilt: Quaternion) -> FloatArray:
    """Heights of the tilted plane through the origin at the places of points [m], shape (n,)."""
    nx, ny, nz = matrix(tilt)[:, 2].tolist()
    return np.asarray(-(nx * points[:, 0] + ny * points[:, 1]) / nz)


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundClearance:
    """Result of `ground_clearance`."""

    height: float
    """Of the lowest wheel above the surface under it [m]; a little below 0 when a tire is pressed in."""
    is_airborne: bool
    """No wheel touches."""


def ground_clearance(
    wheel_points: FloatArray, surface_heights: FloatArray, *, tolerance: float = 0.01
) -> GroundClearance:
    """Clearance of a robot from its wheels' lowest points, so that a tilted robot on a bump is not in the air.

    Args:
        wheel_points: Where each wheel would touch, field frame [m], shape (n, 3).
        surface_heights: Height of carpet, bump or ramp under each point, from a ray or a map [m], shape (n,).
        tolerance: A wheel within this of its surface touches it [m].

    Raises:
        ConfigError: No wheel, or shapes that do not belong together.
        NonFiniteError: A NaN or an infinity.

    >>> ground_clearance(np.array([[0.3, 0.0, 0.12], [-0.3, 0.0, 0.10]]), np.array([0.0, 0.0]))
    GroundClearance(height=0.1, is_airborne=True)
    """
    points, heights = np.asarray(wheel_points, dtype=np.float64), np.asarray(surface_heights, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or not len(points) or heights.shape != (len(points),):
        raise ConfigError(
            f"wheel_points need shape (n, 3) and surface_heights (n,), got {points.shape}, {heights.shape}"
        )
    gap = (points[:, 2] - heights).tolist()
    if not all(map(math.isfinite, gap)):
        raise NonFiniteError(f"height of wheels over the ground must be finite, got {gap}")
    height = min(gap)
    return GroundClearance(height=height, is_airborne=height > tolerance)
