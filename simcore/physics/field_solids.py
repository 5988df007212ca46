"""Convex bodies as groups of an OBJ file, for scripts that write a field's mesh from its dimensions."""

from __future__ import annotations

import math

import numpy as np

from simcore.errors import ConfigError
from simcore.geometry.symmetry import FieldSymmetry
from simcore.physics.obj import ObjGroup
from simcore.typing import FloatArray

__all__ = ["box_group", "flipped_group", "pipe_group", "prism_group", "solid_group"]


def box_group(name: str, low: tuple[float, float, float], high: tuple[float, float, float]) -> ObjGroup:
    """An axis-aligned box between two corners [m]."""
    ring = [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
    return solid_group(name, np.array([(*xy, low[2]) for xy in ring]), np.array([(*xy, high[2]) for xy in ring]))


def solid_group(name: str, bottom: FloatArray, top: FloatArray) -> ObjGroup:
    """A prism or frustum: two flat polygons with equally many corners, and flat faces between them.

    Args:
        name: Of the group.
        bottom: Corners, counter-clockwise seen from the top [m], shape (n, 3).
        top: The corner over each of them [m], shape (n, 3).
    """
    n = len(bottom)
    sides = [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    return ObjGroup(name, np.vstack([bottom, top]), (tuple(reversed(range(n))), tuple(range(n, 2 * n)), *sides))


def prism_group(name: str, outline: FloatArray, bottom: float, top: float) -> ObjGroup:
    """An upright prism.

    Args:
        name: Of the group.
        outline: Convex, counter-clockwise seen from above [m], shape (n, 2).
        bottom: Height of its lower face [m].
        top: Height of its upper face [m].
    """
    ends = [np.column_stack([outline, np.full(len(outline), z)]) for z in (bottom, top)]
    return solid_group(name, ends[0], ends[1])


def pipe_group(
    name: str,
    start: tuple[float, float, float],
    end: tuple[float, float, float],
    diameter: float,
    *,
    aside: tuple[float, float, float],
    sides: int = 8,
) -> ObjGroup:
    """A straight pipe or bar, as a prism with as large a section as the round one.

    Args:
        name: Of the group.
        start: Middle of one end [m].
        end: Middle of the other [m].
        diameter: Of the round pipe [m].
        aside: A direction across the pipe, which two of the faces look to.
        sides: Faces around it.

    Raises:
        ConfigError: The pipe has no length or diameter, or `aside` is along it.
    """
    ends = np.array([start, end])
    way = ends[1] - ends[0]
    u = np.array(aside) - way * (way @ np.array(aside)) / max(float(way @ way), 1e-12)
    if not (diameter > 0.0 and float(way @ way) > 0.0 and float(u @ u) > 1e-12):
        raise ConfigError(
            f"{name}: diameter must be > 0 m, start and end differ and aside be across, got {diameter}, {start}, "
            f"{end}, {aside}"
        )
    u /= np.linalg.norm(u)
    v = np.cross(way / np.linalg.norm(way), u)
    # the regular polygon of the same area
    radius = 0.5 * diameter * math.sqrt(math.tau / (sides * math.sin(math.tau / sides)))
    turn = (np.arange(sides) + 0.5) * math.tau / sides
    ring = radius * (np.outer(np.cos(turn), u) + np.outer(np.sin(turn), v))
    return solid_group(name, ends[0] + ring, ends[1] + ring)


def flipped_group(group: ObjGroup, name: str, symmetry: FieldSymmetry) -> ObjGroup:
    """The group that the symmetry of a field puts on the other half; its faces look outward as well."""
    faces = group.faces if symmetry.keeps_hands else tuple(face[::-1] for face in group.faces)
    return ObjGroup(name, symmetry.flip_points(group.vertices), faces)
