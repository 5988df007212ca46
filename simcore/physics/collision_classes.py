"""Groups and masks of bodies in MuJoCo's words.

MuJoCo lets two shapes touch if either wants to; here both must have the other's group in their mask. So all bodies with
the same group and mask form a class with a bit of its own, and the affinity of a class is the bits of all it touches.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from simcore.errors import EngineError
from simcore.physics.mujoco_model import CompiledModel

__all__ = ["CollisionClasses", "ray_flags", "require_group"]

_MOST_CLASSES = 31  # bits of MuJoCo's masks
_MOST_GROUPS = 5  # MuJoCo tells six groups apart for rays; the sixth is of what is out of the world


def require_group(group: int) -> None:
    """Raise `EngineError` for a group that MuJoCo's rays cannot tell apart."""
    if group >= 1 << _MOST_GROUPS:
        raise EngineError(f"MuJoCo tells {_MOST_GROUPS} collision groups apart, the bits 1 to 16; got {group}")


def ray_flags(mask: int) -> Any:
    """Which groups a ray meets, as MuJoCo takes it."""
    return np.array([*(mask >> number & 1 for number in range(_MOST_GROUPS)), 0], dtype=np.uint8)


class CollisionClasses:
    """Classes of the bodies of one model."""

    def __init__(self, model: CompiledModel) -> None:
        self._model, self._m = model, model.m
        self._classes: dict[tuple[int, int], int] = {}
        self._affinity = np.zeros(1, dtype=np.int32)  # of each class, and last that of none
        self._class_of_geom = np.full(self._m.ngeom, -1, dtype=np.int64)

    def write(self, row: int, group: int, mask: int) -> None:
        """Put a row into the class of its group and mask; into none if either is 0."""
        if not (group and mask):
            group, number = 0, -1
        elif (group, mask) in self._classes:
            number = self._classes[group, mask]
        else:
            number = self._new_class(group, mask)
        m, geoms, body = self._m, self._model.geoms_of_row[row], self._model.body_of_row[row]
        bit, affinity = 1 << number if number >= 0 else 0, self._affinity[number]
        m.geom_contype[geoms], m.geom_conaffinity[geoms] = bit, affinity
        m.geom_group[geoms] = (group.bit_length() or _MOST_GROUPS + 1) - 1
        self._class_of_geom[geoms] = number
        if body >= 0:
            m.body_contype[body + 1], m.body_conaffinity[body + 1] = bit, affinity
        else:
            self._write_world()

    def _new_class(self, group: int, mask: int) -> int:
        """Number of a class; those touch each other of which each has the other's group in its mask."""
        if len(self._classes) == _MOST_CLASSES:
            raise EngineError(f"MuJoCo: more than {_MOST_CLASSES} pairs of group and mask")
        self._classes[group, mask] = len(self._classes)
        groups, masks = np.array([*self._classes, (0, 0)]).T
        touch = (groups[:, None] & masks != 0) & (masks[:, None] & groups != 0)
        self._affinity = (touch << np.arange(len(groups))).sum(axis=1).astype(np.int32)
        model, m = self._model, self._m
        m.geom_conaffinity[:] = self._affinity[self._class_of_geom]
        bodies = model.body_of_geom >= 0
        m.body_conaffinity[model.body_of_geom[bodies] + 1] = m.geom_conaffinity[bodies]
        self._write_world()
        return self._classes[group, mask]

    def _write_world(self) -> None:
        """What the statics together touch."""
        statics = self._model.body_of_geom < 0
        self._m.body_contype[0] = np.bitwise_or.reduce(self._m.geom_contype[statics], initial=0)
        self._m.body_conaffinity[0] = np.bitwise_or.reduce(self._m.geom_conaffinity[statics], initial=0)
