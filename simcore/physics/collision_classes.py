"""Groups and masks of bodies in MuJoCo's words.

MuJoCo lets two shapes touch if either wants to; here both must have the other's group in their mask. So all bodies with
the same group and mask form a class with a bit of its own, and the affinity of a class is the bits of all it touches.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from simcore.errors import EngineError
from simcore.physics.mujoco_model import ModelLayout
from simcore.typing import IntArray

__all__ = ["CollisionClasses", "RayGroups"]

_MOST_CLASSES = 31  # bits of MuJoCo's masks
_MOST_GROUPS = 5  # MuJoCo tells six groups apart for rays; the sixth is of what is in no group
_HIDDEN = 5


class RayGroups:
    """Numbers of MuJoCo's ray groups by collision group."""

    def __init__(self) -> None:
        self._numbers: dict[int, int] = {}

    def require(self, group: int) -> None:
        """Number a group; raises `EngineError` if it is one too many."""
        if group and group not in self._numbers:
            if len(self._numbers) == _MOST_GROUPS:
                raise EngineError(f"MuJoCo tells {_MOST_GROUPS} collision groups apart, group {group} is one more")
            self._numbers[group] = len(self._numbers)

    def number(self, group: int) -> int:
        """Of a group; 0, the group of what is out of the world, has one that no ray meets."""
        return self._numbers[group] if group else _HIDDEN

    def flags(self, mask: int) -> Any:
        """Which groups a ray meets, as MuJoCo takes it."""
        flags = np.zeros(6, dtype=np.uint8)
        for group, number in self._numbers.items():
            flags[number] = bool(group & mask)
        return flags


class CollisionClasses:
    """Classes of the bodies of one model.

    Args:
        model: The `MjModel`.
        layout: Where each row is in it.
        geoms: Numbers of the shapes of each row.
        groups: For rays.
    """

    def __init__(self, model: Any, layout: ModelLayout, geoms: list[IntArray], groups: RayGroups) -> None:
        self._m = model
        self._layout = layout
        self._geoms = geoms
        self._groups = groups
        self._classes: dict[tuple[int, int], int] = {}
        self._affinity: list[int] = []
        self._class_of_geom = np.full(model.ngeom, -1, dtype=np.int64)
        self._class_of_body = np.full(len(layout.row_of_body), -1, dtype=np.int64)

    def write(self, row: int, group: int, mask: int) -> None:
        """Put a row into the class of its group and mask; into none if either is 0."""
        number = self._class((group, mask)) if group and mask else -1
        bit = 1 << number if number >= 0 else 0
        affinity = self._affinity[number] if number >= 0 else 0
        m, geoms, body = self._m, self._geoms[row], self._layout.body_of_row[row]
        m.geom_contype[geoms] = bit
        m.geom_conaffinity[geoms] = affinity
        m.geom_group[geoms] = self._groups.number(group)
        self._class_of_geom[geoms] = number
        if body >= 0:
            m.body_contype[body + 1] = bit
            m.body_conaffinity[body + 1] = affinity
            self._class_of_body[body] = number
        else:
            self._write_world()

    def _class(self, key: tuple[int, int]) -> int:
        """Number of the class of bodies with a group and mask; a new one learns who touches it."""
        if key not in self._classes:
            if len(self._classes) == _MOST_CLASSES:
                raise EngineError(f"MuJoCo: more than {_MOST_CLASSES} pairs of group and mask")
            self._classes[key] = len(self._classes)
            self._write_affinities()
        return self._classes[key]

    def _write_affinities(self) -> None:
        """Which classes touch which: each must have the other's group in its mask."""
        keys = list(self._classes)
        self._affinity = [0] * len(keys)
        for one, (group, mask) in enumerate(keys):
            for other, (other_group, other_mask) in enumerate(keys):
                if group & other_mask and other_group & mask:
                    self._affinity[one] |= 1 << other
        of_class = np.array([*self._affinity, 0], dtype=np.int32)
        self._m.geom_conaffinity[:] = of_class[self._class_of_geom]
        self._m.body_conaffinity[1:] = of_class[self._class_of_body]
        self._write_world()

    def _write_world(self) -> None:
        """What the statics together touch."""
        statics = self._layout.body_of_geom < 0
        self._m.body_contype[0] = np.bitwise_or.reduce(self._m.geom_contype[statics], initial=0)
        self._m.body_conaffinity[0] = np.bitwise_or.reduce(self._m.geom_conaffinity[statics], initial=0)
