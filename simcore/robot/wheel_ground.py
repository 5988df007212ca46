"""What is under a robot's wheels."""

from __future__ import annotations

import math

import numpy as np

from simcore.geometry.rotation import Quaternion, Vector, matrix
from simcore.physics.world import PhysicsWorld
from simcore.robot.chassis_config import ChassisConfig
from simcore.robot.level_body import LEVEL_HEIGHT, LEVEL_TILT
from simcore.typing import FloatArray

__all__ = ["WheelGround"]

_CONTACT_GAP = 0.004  # [m]; a wheel this close to the ground carries load


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
        self.reach = max(math.hypot(x, y) for x, y in config.wheel_positions)
        """Of the wheels from the robot's origin [m]."""
        self.touching = list(self._all_touching)
        """Which wheels were on the ground in the last `find`."""

    def find(self, pos: Vector, quat: Quaternion) -> None:
        """Which wheels touch: all of them on the flat carpet, else those whose short ray down meets something.

        And those that touch what carries robots elsewhere: a wheel at the edge of a bar stands on it and pulls there.

        Args:
            pos: Of the robot's origin, field frame [m].
            quat: Attitude of the robot.
        """
        x, y, _, _ = quat
        if abs(pos[2]) < LEVEL_HEIGHT and x * x + y * y < LEVEL_TILT**2:
            self.touching = self._all_touching
            return
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

    def under(self, pos: Vector, quat: Quaternion) -> tuple[FloatArray, FloatArray]:
        """See `ChassisSimulation.wheel_ground`; for the arguments see `find`."""
        soles = self._contacts @ matrix(quat).T + pos
        if self._world.is_flat(pos[0], pos[1], self.reach):
            return soles, np.zeros(len(soles))
        start = soles + np.array((0.0, 0.0, self._radius))
        hits = self._world.ground_rays(start, start - np.array((0.0, 0.0, 5.0)))
        return soles, start[:, 2] - 5.0 * hits.fraction
