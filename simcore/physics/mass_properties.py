"""Volume, center of mass and inertia of uniform solids, from their shape."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from simcore.errors import ConfigError
from simcore.geometry.rotation import IDENTITY, Quaternion, Vector, matrix
from simcore.physics.shapes import Box, Compound, Cylinder, Hull, Part, Shape, Sphere
from simcore.typing import FloatArray

__all__ = ["MassProperties", "centered", "free_spin", "mass_properties", "principal_axes"]

_ALIGNED = 1e-6  # share of the largest moment that products of inertia may be, for the axes to count as principal


@dataclass(frozen=True, slots=True, eq=False)
class MassProperties:
    """Of a uniform solid."""

    volume: float
    """[m^3]; of a compound whose parts overlap, the overlap counts twice."""
    center: FloatArray
    """Center of mass in the frame of the shape [m], shape (3,)."""
    inertia: FloatArray
    """Inertia tensor about the center of mass, along the axes of the shape, for a mass of 1 kg [m^2], shape (3, 3)."""


@lru_cache(maxsize=256)
def mass_properties(shape: Shape) -> MassProperties:
    """Volume, center of mass and inertia.

    Raises:
        ConfigError: The shape has no volume: a half space, a mesh, or a hull of points in one plane.

    >>> float(mass_properties(Sphere(0.5)).inertia[0, 0])
    0.1
    """
    if isinstance(shape, Compound):
        return _compound(shape)
    if isinstance(shape, Hull):
        return _hull(shape.points)
    if isinstance(shape, Sphere):
        moments = [0.4 * shape.radius**2] * 3
        volume = 4.0 / 3.0 * math.pi * shape.radius**3
    elif isinstance(shape, Cylinder):
        across = (3.0 * shape.radius**2 + shape.height**2) / 12.0
        moments = [across, across, 0.5 * shape.radius**2]
        volume = math.pi * shape.radius**2 * shape.height
    elif isinstance(shape, Box):
        x, y, z = shape.size
        moments = [(y * y + z * z) / 12.0, (x * x + z * z) / 12.0, (x * x + y * y) / 12.0]
        volume = x * y * z
    else:
        raise ConfigError(f"a {type(shape).__name__} has no volume and can only stand still")
    return MassProperties(volume, np.zeros(3), np.diag(moments))


def principal_axes(inertia: FloatArray) -> tuple[Vector, Quaternion]:
    """Principal moments of a tensor, shape (3, 3), and the attitude of the principal axes, x, y, z, w.

    A tensor that is diagonal already keeps its axes.
    """
    moments = np.diag(inertia)
    if np.abs(inertia - np.diag(moments)).max() <= _ALIGNED * moments.max():
        a, b, c = moments.tolist()
        return (a, b, c), IDENTITY
    from scipy.spatial.transform import Rotation

    values, axes = np.linalg.eigh(inertia)
    axes = axes * np.where(axes[np.abs(axes).argmax(axis=0), range(3)] < 0.0, -1.0, 1.0)
    if np.linalg.det(axes) < 0.0:
        axes[:, 2] *= -1.0
    a, b, c = values.tolist()
    x, y, z, w = Rotation.from_matrix(axes).as_quat().tolist()
    return (a, b, c), (x, y, z, w)


def free_spin(spin: FloatArray, moments: FloatArray, h: float) -> FloatArray:
    """Angular velocities after h [s] without a torque: Euler's equations, by the classical Runge-Kutta method.

    Args:
        spin: Along the principal axes [rad/s], shape (n, 3).
        moments: Principal moments of inertia [kg m^2], shape (n, 3).
        h: Step [s].

    >>> free_spin(np.array([[0.0, 0.0, 2.0]]), np.array([[2.0, 2.0, 1.0]]), 0.1).tolist()
    [[0.0, 0.0, 2.0]]
    """
    share = (np.roll(moments, -1, axis=1) - np.roll(moments, 1, axis=1)) / moments

    def rate(w: FloatArray) -> FloatArray:
        return share * np.roll(w, -1, axis=1) * np.roll(w, 1, axis=1)

    a = rate(spin)
    b = rate(spin + 0.5 * h * a)
    c = rate(spin + 0.5 * h * b)
    after: FloatArray = spin + h / 6.0 * (a + 2.0 * (b + c) + rate(spin + h * c))
    return after


def centered(shape: Hull | Compound) -> Hull | Compound:
    """The same shape with its center of mass in the origin, as a game piece needs it."""
    center = mass_properties(shape).center
    if isinstance(shape, Hull):
        return Hull(shape.points - center)
    cx, cy, cz = center.tolist()
    moved = [
        Part(part.shape, (part.offset[0] - cx, part.offset[1] - cy, part.offset[2] - cz), part.quat)
        for part in shape.parts
    ]
    return Compound(tuple(moved))


def _compound(shape: Compound) -> MassProperties:
    found = [(part, mass_properties(part.shape)) for part in shape.parts]
    volumes = np.array([one.volume for _, one in found])
    share = volumes / volumes.sum()
    places = np.array([np.array(part.offset) + matrix(part.quat) @ one.center for part, one in found])
    center = share @ places
    inertia = np.zeros((3, 3))
    for (part, one), part_share, away in zip(found, share.tolist(), places - center, strict=True):
        axes = matrix(part.quat)
        inertia += part_share * (axes @ one.inertia @ axes.T + (away @ away) * np.eye(3) - np.outer(away, away))
    return MassProperties(float(volumes.sum()), center, inertia)


def _hull(points: FloatArray) -> MassProperties:
    """From tetrahedra between a point inside and the triangles of the surface."""
    try:
        hull = ConvexHull(points)
    except QhullError as error:
        raise ConfigError("a Hull whose points lie in one plane has no volume; give it some thickness") from error
    middle = points.mean(axis=0)
    corners = points[hull.simplices] - middle
    volumes = np.abs(np.linalg.det(corners)) / 6.0
    volume = float(volumes.sum())
    total = corners.sum(axis=1)
    center = (volumes / volume) @ total / 4.0
    # second moments of a tetrahedron with a corner in the origin: (sum of the outer products + that of the sum) / 20
    outer = np.einsum("ijk,ijl->ikl", corners, corners) + np.einsum("ik,il->ikl", total, total)
    second = np.einsum("i,ikl->kl", volumes / volume, outer) / 20.0 - np.outer(center, center)
    return MassProperties(volume, middle + center, np.trace(second) * np.eye(3) - second)
