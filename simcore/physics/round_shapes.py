"""Round and hollow shapes made of convex parts: tubes, rings and cones."""

from __future__ import annotations

import math

import numpy as np

from simcore.errors import ConfigError
from simcore.geometry.rotation import from_yaw
from simcore.physics.mass_properties import centered
from simcore.physics.shapes import Compound, Hull, Part
from simcore.quantities import ROBOT_HEIGHT, ROBOT_LENGTH, require
from simcore.typing import FloatArray

__all__ = ["cone", "torus", "tube"]

_OUTER_FACES = 8  # of each stave: a tube of 12 staves has 96 faces outside
_WAIST = 0.0001  # [m]; by how much each surface of a tube recedes in its middle
_TONGUE = 0.008  # [m]; how far each half of a stave reaches into the other,
_SUNK = 0.2  # and how far it lies under the other's surfaces at its end, share of the wall
_FEWEST_STAVES = 6
_MOST_STAVES = 16


def tube(*, length: float, outer_radius: float, inner_radius: float, staves: int = 12) -> Compound:
    """A hollow tube along z around the origin, as a ring of staves: what is thinner than its bore goes through it.

    The bore is a regular polygon around the inner radius; outside there are eight faces a stave, with their edges on
    the outer radius. Each stave is in two halves, so that an engine finds at least two places where a tube that lies
    touches the ground (with one it sinks in by 8 mm as it slides). Each half ends in a tongue under the other's
    surfaces: what slides along and is pressed in a little would be stopped by a face across its way (a pipe's end in
    the bore lost two thirds of 1.3 m/s).

    Args:
        length: [m]
        outer_radius: [m]
        inner_radius: Of the largest cylinder that passes [m].
        staves: Of the ring, 6 to 16.

    Raises:
        ConfigError: A length is not above zero, the bore is not smaller than the tube, or a number of staves that does
            not do.

    >>> len(tube(length=0.3, outer_radius=0.06, inner_radius=0.05).parts)
    24
    """
    require("tube", "length", length, ROBOT_LENGTH)
    require("tube", "inner_radius", inner_radius, ROBOT_LENGTH)
    require("tube", "outer_radius", outer_radius, ROBOT_LENGTH)
    _require_staves("tube", staves)
    half = math.pi / staves
    if not inner_radius / math.cos(half) < outer_radius * math.cos(half / _OUTER_FACES):
        raise ConfigError(
            f"tube: a bore of {inner_radius} m leaves no wall in a radius of {outer_radius} m with {staves} staves; "
            "make it smaller or take more staves"
        )
    arc = np.linspace(-half, half, _OUTER_FACES + 1)
    outside = outer_radius * np.column_stack((np.cos(arc), np.sin(arc)))
    inside = inner_radius * np.array([[1.0, -math.tan(half)], [1.0, math.tan(half)]])
    wall = outer_radius - inner_radius

    def thinner(by: float) -> FloatArray:
        inward = np.array([by, 0.0])
        return np.vstack((outside - inward, inside + inward))

    sections = ((thinner(0.0), 0.5 * length), (thinner(_WAIST), 0.0), (thinner(_SUNK * wall), -_TONGUE))
    ups = [np.vstack([np.column_stack((points, np.full(len(points), z))) for points, z in sections])]
    ups.append(ups[0] * (1.0, 1.0, -1.0))
    return Compound(tuple(part for points in ups for part in _ring(Hull(points), staves).parts))


def torus(*, ring_radius: float, tube_radius: float, segments: int = 12) -> Compound:
    """A ring around z, as convex segments that are round outside.

    Args:
        ring_radius: From the axis to the middle of the ring's own section [m].
        tube_radius: Of that section [m].
        segments: Parts of the ring, 6 to 16.

    Raises:
        ConfigError: A radius is not above zero, the section is as large as the ring, or a number of segments that does
            not do.
    """
    require("torus", "tube_radius", tube_radius, ROBOT_LENGTH)
    require("torus", "ring_radius", ring_radius, ROBOT_LENGTH)
    _require_staves("torus", segments)
    if not tube_radius < ring_radius:
        raise ConfigError(f"torus: ring_radius must be above tube_radius, got {ring_radius} and {tube_radius} m")
    half = math.pi / segments
    turn = np.arange(12) * math.tau / 12
    away, height = ring_radius + tube_radius * np.cos(turn), tube_radius * np.sin(turn)
    ends = [np.column_stack((away * math.cos(a), away * math.sin(a), height)) for a in (-half, half)]
    outer = away > ring_radius  # the middle of a segment is round only where it bends outward
    middle = np.column_stack((away, np.zeros(12), height))[outer]
    return _ring(Hull(np.vstack((*ends, middle))), segments)


def cone(*, height: float, bottom_radius: float, top_radius: float = 0.0, sides: int = 24) -> Hull:
    """A cone, or the frustum of one, along z; its origin is its center of mass.

    Args:
        height: [m]
        bottom_radius: [m]
        top_radius: 0 for a pointed one [m].
        sides: Faces around it.
    """
    require("cone", "height", height, ROBOT_LENGTH)
    require("cone", "bottom_radius", bottom_radius, ROBOT_LENGTH)
    require("cone", "top_radius", top_radius, ROBOT_HEIGHT)
    if not (isinstance(sides, int) and 6 <= sides <= 96):
        raise ConfigError(f"cone: sides must be a whole number from 6 to 96, got {sides!r}")
    turn = np.arange(sides) * math.tau / sides
    circle = np.column_stack((np.cos(turn), np.sin(turn)))
    bottom = np.column_stack((bottom_radius * circle, np.zeros(sides)))
    top = np.array([[0.0, 0.0, height]])
    if top_radius > 0.0:
        top = np.column_stack((top_radius * circle, np.full(sides, height)))
    shape = centered(Hull(np.vstack((bottom, top))))
    assert isinstance(shape, Hull)
    return shape


def _ring(segment: Hull, count: int) -> Compound:
    return Compound(tuple(Part(segment, quat=from_yaw(k * math.tau / count)) for k in range(count)))


def _require_staves(name: str, count: int) -> None:
    if not (isinstance(count, int) and _FEWEST_STAVES <= count <= _MOST_STAVES):
        raise ConfigError(f"{name}: {_FEWEST_STAVES} to {_MOST_STAVES} parts of a ring, got {count!r}")
