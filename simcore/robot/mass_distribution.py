"""Mass, center of mass and inertia of a robot, from those of its body and of what moves on it or is held in it.

A robot's stated mass, center and inertia are those of all of it at the start, with nothing held. Its body is what is
left without its moving masses; these, and the pieces that it holds, are points: what they have of inertia about their
own centers stays with the body, or is left out (of 50 balls of 0.215 kg 0.02 kg m^2).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

from simcore.errors import ConfigError
from simcore.geometry.linkage import Joint, MechanismMotion, part_pose
from simcore.geometry.rotation import Vector
from simcore.quantities import MASS, ROBOT_PLACE, require_fields

__all__ = ["MassDistribution", "MovingMass", "PointMass", "moved_points", "with_points"]

PointMass: TypeAlias = tuple[float, Vector]
"""Mass [kg], and its place in the robot frame [m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MovingMass:
    """A part of the robot's mass that mechanisms move: an elevator's stage, a carriage, an arm."""

    name: str
    mass: float
    """Of the mass of the whole robot [kg]."""
    joints: tuple[Joint, ...]
    """What moves it, from the robot outward."""
    center: Vector = (0.0, 0.0, 0.0)
    """Its center of mass in the frame after the last joint [m]."""

    def __post_init__(self) -> None:
        require_fields(self, f"moving mass {self.name!r}", mass=MASS, center=(ROBOT_PLACE,) * 3)
        if not self.joints:
            raise ConfigError(f"moving mass {self.name!r}: it needs a joint that moves it")


class MassDistribution(NamedTuple):
    """Of a rigid body, in the robot frame: x forward, y to the left, z up from the floor under the robot's center."""

    mass: float
    """[kg]"""
    center: Vector
    """Center of mass [m]."""
    inertia: Vector
    """Moments about the center of mass, along the robot's axes [kg m^2].

    Products of inertia are left out: wheels hold roll and pitch, and the yaw moment does not need them.
    """


def moved_points(parts: Iterable[MovingMass], mechanisms: Mapping[str, MechanismMotion]) -> list[PointMass]:
    """Where moving masses are as their mechanisms stand."""
    return [(part.mass, part_pose(part.joints, mechanisms, part.center)[0]) for part in parts]


def with_points(body: MassDistribution, points: Iterable[PointMass]) -> MassDistribution:
    """A body and points on it as one rigid body; points of negative mass are taken out of it.

        m = sum m_i,   c = sum m_i r_i / m,   I_x = sum (I_xi + m_i (y_i^2 + z_i^2)) - m (c_y^2 + c_z^2), ...

    >>> whole = with_points(MassDistribution(30.0, (0.0, 0.0, 0.2), (2.0, 2.0, 3.0)), [(10.0, (0.0, 0.0, 0.6))])
    >>> whole.mass, round(whole.center[2], 6), [round(moment, 6) for moment in whole.inertia]
    (40.0, 0.3, [3.2, 3.2, 3.0])
    """
    m0, (x0, y0, z0), (ix, iy, iz) = body
    # About the body's own center: where nothing is added, its own numbers come out, to the last bit.
    mass = m0
    sx = sy = sz = xx = yy = zz = 0.0
    for m, (x, y, z) in points:
        x, y, z = x - x0, y - y0, z - z0
        mass += m
        sx, sy, sz = sx + m * x, sy + m * y, sz + m * z
        xx, yy, zz = xx + m * x * x, yy + m * y * y, zz + m * z * z
    cx, cy, cz = sx / mass, sy / mass, sz / mass
    xx, yy, zz = xx - sx * cx, yy - sy * cy, zz - sz * cz
    return MassDistribution(mass, (x0 + cx, y0 + cy, z0 + cz), (ix + yy + zz, iy + xx + zz, iz + xx + yy))
