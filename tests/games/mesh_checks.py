"""Geometry of field elements: corners, and free space in a box."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog
from scipy.spatial import ConvexHull

from simcore.world.shapes import Box


def points(element):
    """Return corners in the field frame, in a fixed order."""
    if isinstance(element.shape, Box):
        half = np.array(element.shape.size) / 2
        local = half * np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
    else:
        local = element.shape.points
    out = local + element.position
    return out[np.lexsort(np.round(out, 5).T)]


def span(field, name):
    corners = points(field.element(name))
    return corners.min(axis=0), corners.max(axis=0)


def is_free(field, low, high):
    """Return whether an axis-aligned box overlaps no element, by linear programming."""
    walls = np.vstack([np.column_stack([np.eye(3), np.array(high)]), np.column_stack([-np.eye(3), -np.array(low)])])
    for element in field.elements:
        corners = points(element)
        if (corners.max(axis=0) <= low).any() or (corners.min(axis=0) >= high).any():
            continue
        planes = ConvexHull(corners).equations
        a = np.vstack([planes[:, :3], walls[:, :3]])
        b = np.concatenate([-planes[:, 3], walls[:, 3]]) - 1e-6  # strictly inside both
        if linprog(np.zeros(3), A_ub=a, b_ub=b, bounds=(None, None)).status == 0:
            return False
    return True
