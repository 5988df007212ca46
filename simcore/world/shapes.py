"""Collision shapes, extents and mass properties, and functions that make tubes, tori and cones from convex parts.

A shape has its own frame. The body with this shape defines the pose of the frame. Volume, center of mass and inertia
assume uniform density.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from simcore.errors import ConfigError
from simcore.quantities import (
    ATTITUDE,
    FIELD_PLACE,
    ROBOT_HEIGHT,
    ROBOT_LENGTH,
    Quantity,
    require,
    require_fields,
    require_points,
)
from simcore.typing import FloatArray, IntArray
from simcore.world.rotation import IDENTITY, Quaternion, Vector, from_yaw, matrix

__all__ = [
    "Box",
    "Compound",
    "Cylinder",
    "Hull",
    "MassProperties",
    "Mesh",
    "Part",
    "Shape",
    "Sphere",
    "bounding_box",
    "bounding_radius",
    "centered",
    "cone",
    "free_spin",
    "hollow_cone",
    "inner_radius",
    "mass_properties",
    "mean_frontal_area",
    "outline",
    "outline_points",
    "parts_of",
    "principal_axes",
    "smallest_thickness",
    "stands",
    "support",
    "support_height",
    "torus",
    "tube",
]

_LENGTH = Quantity("m", 0.0, 2000.0, is_open=True)  # the floor of a world has this length
_RING = 24  # number of points of a round outline
_TOUCHES = 0.001  # [m]; points up to this height above the lowest point also support the shape
_OVER = 0.002  # [m]; largest distance of the center of mass outside the polygon of supporting points
_DIRECTIONS: FloatArray = np.array([np.cos(np.arange(72) * math.tau / 72), np.sin(np.arange(72) * math.tau / 72)])


@dataclass(frozen=True, slots=True)
class Sphere:
    """Sphere centered at the origin."""

    radius: float
    """Radius [m]."""

    def __post_init__(self) -> None:
        require_fields(self, radius=_LENGTH)


@dataclass(frozen=True, slots=True)
class Cylinder:
    """Cylinder along z, centered at the origin."""

    radius: float
    """Radius [m]."""
    height: float
    """Full height [m]."""

    def __post_init__(self) -> None:
        require_fields(self, radius=_LENGTH, height=_LENGTH)


@dataclass(frozen=True, slots=True)
class Box:
    """Box centered at the origin."""

    size: tuple[float, float, float]
    """Full edge lengths along x, y and z [m]."""

    def __post_init__(self) -> None:
        require_fields(self, size=(_LENGTH,) * 3)


@dataclass(frozen=True, slots=True, eq=False)
class Hull:
    """Convex hull of points."""

    points: FloatArray
    """Points of the hull [m], shape (n, 3), n >= 4."""

    def __post_init__(self) -> None:
        require_points("Hull", "points", self.points, FIELD_PLACE, least=4)


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """Two-sided triangle mesh, for statics only.

    Collisions take longer to compute than for other shapes, and balls pass through a mesh more often.
    """

    vertices: FloatArray
    """Vertices [m], shape (n, 3)."""
    faces: IntArray
    """Rows of the vertices of each triangle, shape (m, 3)."""

    def __post_init__(self) -> None:
        require_points("Mesh", "vertices", self.vertices, FIELD_PLACE, least=3)
        require_points("Mesh", "faces", self.faces, Quantity("", 0, len(self.vertices) - 1, is_whole=True), least=1)


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Convex shape with a position and an attitude in a `Compound`."""

    shape: Sphere | Cylinder | Box | Hull
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Origin of the part in the frame of the compound [m]."""
    quat: Quaternion = IDENTITY
    """Attitude of the part in the frame of the compound, unit quaternion x, y, z, w."""

    def __post_init__(self) -> None:
        require_fields(self, offset=(FIELD_PLACE,) * 3, quat=ATTITUDE)


@dataclass(frozen=True, slots=True, eq=False)
class Compound:
    """Convex shapes that move as one body and share one surface."""

    parts: tuple[Part, ...]

    def __post_init__(self) -> None:
        require_fields(self)
        if not self.parts:
            raise ConfigError("Compound: it needs at least one part")


Shape: TypeAlias = Sphere | Cylinder | Box | Hull | Mesh | Compound


def parts_of(shape: Shape) -> tuple[Part, ...]:
    """Return the convex parts of a shape; a convex shape has one part.

    Raises:
        ConfigError: If the shape is a mesh.
    """
    if isinstance(shape, Compound):
        return shape.parts
    if isinstance(shape, Mesh):
        raise ConfigError(f"a {type(shape).__name__} can only be a static")
    return (Part(shape),)


def support(shape: Shape, ways: FloatArray) -> FloatArray:
    """Compute the support function: the largest extent of a shape from the origin along each unit vector [m], (n,).

    Args:
        shape: Shape in its own frame.
        ways: Unit vectors, shape (n, 3).
    """
    if isinstance(shape, Compound):
        reach = [support(p.shape, ways @ matrix(p.quat)) + ways @ np.array(p.offset) for p in shape.parts]
        return np.asarray(np.max(reach, axis=0))
    if isinstance(shape, Sphere):
        return np.full(len(ways), shape.radius)
    if isinstance(shape, Cylinder):
        x, y, z = ways.T
        return np.asarray(0.5 * shape.height * np.abs(z) + shape.radius * np.hypot(x, y))
    if isinstance(shape, Box):
        return np.abs(ways) @ (0.5 * np.array(shape.size))
    return np.asarray((ways @ (shape.points if isinstance(shape, Hull) else shape.vertices).T).max(axis=1))


def bounding_box(shape: Shape) -> tuple[FloatArray, FloatArray]:
    """Return the low and high corners of a shape's bounding box, shape frame [m], shape (3,) each."""
    return -support(shape, -np.eye(3)), support(shape, np.eye(3))


def outline_points(shape: Shape) -> FloatArray:
    """Return points with a convex hull that equals or approximates the shape, shape frame [m], shape (n, 3).

    A circle becomes 24 points. A sphere becomes the cylinder around the sphere.
    """
    if isinstance(shape, Box):
        corners = np.array(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5])).reshape(3, -1).T
        return np.asarray(corners * np.array(shape.size))
    if isinstance(shape, Hull):
        return shape.points
    if isinstance(shape, Mesh):
        return shape.vertices
    if isinstance(shape, Compound):
        return np.vstack(
            [outline_points(part.shape) @ matrix(part.quat).T + np.array(part.offset) for part in shape.parts]
        )
    angle = np.arange(_RING) * math.tau / _RING
    half = shape.height / 2.0 if isinstance(shape, Cylinder) else shape.radius
    ring = shape.radius * np.column_stack([np.cos(angle), np.sin(angle)])
    return np.vstack([np.column_stack([ring, np.full(_RING, z)]) for z in (-half, half)])


def outline(points: FloatArray) -> FloatArray:
    """Return the corners of the convex hull of points in a plane (m, 2), counter-clockwise, shape (n, 2).

    For points on one line, the function returns the two end points.
    """
    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except QhullError:
        return np.asarray(points[np.lexsort((points[:, 1], points[:, 0]))[[0, -1]]])


@lru_cache(maxsize=256)
def bounding_radius(shape: Shape) -> float:
    """Compute the radius of the smallest sphere around the origin that encloses the shape [m]."""
    if isinstance(shape, Sphere):
        return shape.radius
    if isinstance(shape, Compound):
        return max([_reach(part) for part in shape.parts])
    return float(np.linalg.norm(outline_points(shape), axis=1).max())


@lru_cache(maxsize=256)
def inner_radius(shape: Shape) -> float:
    """Compute the radius of the largest sphere around the origin inside the shape's convex hull [m]."""
    if isinstance(shape, Sphere):
        return shape.radius
    if isinstance(shape, Cylinder):
        return min(shape.radius, shape.height / 2.0)
    if isinstance(shape, Box):
        return min(shape.size) / 2.0
    return float(-ConvexHull(outline_points(shape)).equations[:, 3].max())


@lru_cache(maxsize=256)
def smallest_thickness(shape: Shape) -> float:
    """Compute the smallest thickness of a shape [m], or the smallest thickness of any part of a compound [m].

    For a hull, the function compares the extents perpendicular to all faces.
    """
    if isinstance(shape, Sphere):
        return 2.0 * shape.radius
    if isinstance(shape, Cylinder):
        return min(2.0 * shape.radius, shape.height)
    if isinstance(shape, Box):
        return min(shape.size)
    if isinstance(shape, Compound):
        return min([smallest_thickness(part.shape) for part in shape.parts])
    points = outline_points(shape)
    height = points @ ConvexHull(points).equations[:, :3].T
    return float((height.max(axis=0) - height.min(axis=0)).min())


@lru_cache(maxsize=256)
def mean_frontal_area(shape: Shape) -> float:
    """Compute the projected area of the shape's convex hull, averaged over all directions [m^2].

    The mean projected area of a convex body is exactly a quarter of the surface area, for example pi r^2 for a sphere.

    Source: A. Cauchy, 1841.
    """
    if isinstance(shape, Sphere):
        return math.pi * shape.radius**2
    if isinstance(shape, Cylinder):
        return 0.5 * math.pi * shape.radius * (shape.radius + shape.height)
    if isinstance(shape, Box):
        x, y, z = shape.size
        return 0.5 * (x * y + y * z + z * x)
    return float(ConvexHull(outline_points(shape)).area) / 4.0


def support_height(shape: Shape, quat: Quaternion = IDENTITY) -> float:
    """Compute the height of the origin of a shape that rests on flat ground in a given attitude [m]."""
    return float(support(shape, -matrix(quat)[2:])[0])


def stands(shape: Shape, quat: Quaternion = IDENTITY) -> bool:
    """Return whether a shape in a given attitude stands on flat ground: the origin is above the support polygon."""
    parts = parts_of(shape)
    axes = matrix(quat)
    points = np.vstack([_low_points(part, axes) for part in parts])
    carrying = points[points[:, 2] < points[:, 2].min() + _TOUCHES, :2]
    return bool((carrying @ _DIRECTIONS).min(axis=0).max() < _OVER)


def _low_points(part: Part, axes: FloatArray) -> FloatArray:
    """Return the points of a rotated part that can touch the ground, relative to the shape's origin [m], (n, 3)."""
    origin = axes @ np.array(part.offset)
    if isinstance(part.shape, Sphere):
        return np.array([origin - (0.0, 0.0, part.shape.radius)])
    turned: FloatArray = outline_points(part.shape) @ (axes @ matrix(part.quat)).T + origin
    return turned


def _reach(part: Part) -> float:
    """Compute the largest distance of a part's points from the origin of the compound [m]."""
    if isinstance(part.shape, Sphere):
        return math.hypot(*part.offset) + part.shape.radius
    return float(np.linalg.norm(outline_points(part.shape) @ matrix(part.quat).T + part.offset, axis=1).max())


# --- mass ------------------------------------------------------------------------------------------------------------


_ALIGNED = 1e-6  # largest ratio of a product to a moment of inertia at which the axes count as principal axes


@dataclass(frozen=True, slots=True, eq=False)
class MassProperties:
    """Mass properties of a uniform solid."""

    volume: float
    """Volume [m^3]; for a compound the sum over the parts, including overlaps."""
    center: FloatArray
    """Center of mass in the frame of the shape [m], shape (3,)."""
    inertia: FloatArray
    """Inertia tensor about the center of mass per unit mass, in the axes of the shape [m^2], shape (3, 3)."""


@lru_cache(maxsize=256)
def mass_properties(shape: Shape) -> MassProperties:
    """Compute volume, center of mass and inertia tensor of a shape with uniform density.

    Raises:
        ConfigError: If the shape has no volume: a mesh, or a hull of points in one plane.

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
    """Compute the principal moments of an inertia tensor (3, 3), and the attitude of the principal axes (x, y, z, w).

    For a diagonal tensor, the function returns the diagonal and the identity.
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


def free_spin(spin: Vector, moments: Vector, h: float) -> Vector:
    """Compute the angular velocity after h [s] of torque-free rotation (Euler's equations, one Runge-Kutta step).

    Args:
        spin: Angular velocity at the start, along the principal axes [rad/s].
        moments: Principal moments of inertia [kg m^2].
        h: Length of the step [s].

    >>> free_spin((0.0, 0.0, 2.0), (2.0, 2.0, 1.0), 0.1)
    (0.0, 0.0, 2.0)
    """
    x, y, z = moments
    shares = (y - z) / x, (z - x) / y, (x - y) / z

    def after(step: float, rates: Vector) -> Vector:
        return spin[0] + step * rates[0], spin[1] + step * rates[1], spin[2] + step * rates[2]

    def rate(w: Vector) -> Vector:
        return shares[0] * w[1] * w[2], shares[1] * w[2] * w[0], shares[2] * w[0] * w[1]

    a = rate(spin)
    b = rate(after(0.5 * h, a))
    c = rate(after(0.5 * h, b))
    d = rate(after(h, c))
    p, q, r = (k + 2.0 * (m + n) + o for k, m, n, o in zip(a, b, c, d, strict=True))
    return after(h / 6.0, (p, q, r))


def centered(shape: Hull | Compound) -> Hull | Compound:
    """Return a copy of a shape, shifted so that the center of mass is at the origin, as game pieces require."""
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
    """Compute the mass properties of a hull from tetrahedra between an inner point and the surface triangles."""
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
    # second moments of a tetrahedron with a corner at the origin: (sum of outer products + outer product of sum) / 20
    outer = np.einsum("ijk,ijl->ikl", corners, corners) + np.einsum("ik,il->ikl", total, total)
    second = np.einsum("i,ikl->kl", volumes / volume, outer) / 20.0 - np.outer(center, center)
    return MassProperties(volume, middle + center, np.trace(second) * np.eye(3) - second)


# --- tubes, rings and cones ------------------------------------------------------------------------------------------


_OUTER_FACES = 8  # of each stave: a tube of 12 staves has 96 outer faces
_WAIST = 0.0001  # [m]; recess of the inner and outer surface in the middle of a tube
_TONGUE = 0.008  # [m]; length by which each half of a stave extends into the other half
_SUNK = 0.2  # depth of the end of this extension below the other half's surfaces, as a fraction of the wall
_FEWEST_STAVES = 6
_MOST_STAVES = 16


def tube(*, length: float, outer_radius: float, inner_radius: float, staves: int = 12) -> Compound:
    """Make a hollow tube along z around the origin, as a ring of staves; thinner objects can pass through the bore.

    The bore is a regular polygon around the inner radius. Each stave has eight outer faces with edges on the outer
    radius. A stave has two halves along z, so that an engine finds at least two contacts of a lying tube with the
    ground. With one contact, a sliding tube would sink in by 8 mm. Each half extends into the other half, below the
    surfaces of the other half. Otherwise the end face of a half would stop an object that slides along the tube under
    pressure. Without these extensions, a pipe's end in the bore lost two thirds of 1.3 m/s.

    Args:
        length: Length [m].
        outer_radius: Outer radius [m].
        inner_radius: Radius of the largest cylinder that passes through the bore [m].
        staves: Number of staves, 6 to 16.

    Raises:
        ConfigError: If a length is not above zero, the bore is not smaller than the tube, or the number of staves is
        out of range.

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
    """Make a torus around z from convex segments.

    The outer side of a segment is round. The inner side is flat.

    Args:
        ring_radius: Distance from the axis to the center of the tube [m].
        tube_radius: Radius of the tube [m].
        segments: Number of segments, 6 to 16.

    Raises:
        ConfigError: If a radius is not above zero, the tube is as thick as the ring, or the number of segments is out
        of range.
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
    outer = away > ring_radius  # the middle of a convex segment can be round only on the outside
    middle = np.column_stack((away, np.zeros(12), height))[outer]
    return _ring(Hull(np.vstack((*ends, middle))), segments)


def cone(*, height: float, bottom_radius: float, top_radius: float = 0.0, sides: int = 24) -> Hull:
    """Make a cone or frustum along z, with the center of mass at the origin.

    Args:
        height: Height [m].
        bottom_radius: Radius of the lower end [m].
        top_radius: Radius of the upper end [m]; 0 for a pointed cone.
        sides: Number of side faces, 6 to 96.

    Raises:
        ConfigError: If a length or the number of sides is out of range.
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


def hollow_cone(
    *, height: float, bottom_radius: float, top_radius: float, wall: float, foot: float = 0.0, staves: int = 12
) -> Compound:
    """Make a hollow cone along z, open below and closed on top, with the center of mass at the origin.

    Args:
        height: Height [m].
        bottom_radius: Outer radius at the lower end [m].
        top_radius: Outer radius at the upper end [m].
        wall: Thickness of the side and the top [m].
        foot: Edge length of a square plate around the lower end [m]; 0 for no plate.
        staves: Number of staves of the side, 6 to 16.

    Raises:
        ConfigError: If a length is not above zero, the wall fills the cone, or the foot is smaller than the opening.
    """
    for name, value in (
        ("height", height),
        ("bottom_radius", bottom_radius),
        ("top_radius", top_radius),
        ("wall", wall),
    ):
        require("hollow_cone", name, value, ROBOT_LENGTH)
    require("hollow_cone", "foot", foot, ROBOT_HEIGHT)
    _require_staves("hollow_cone", staves)
    if not wall < min(top_radius, bottom_radius):
        raise ConfigError(
            f"hollow_cone: wall must be below both radii, got {wall} of {bottom_radius} and {top_radius} m"
        )
    if foot and not 0.5 * foot > bottom_radius - wall:
        raise ConfigError(f"hollow_cone: foot must be wider than the opening, got {foot} and {bottom_radius - wall} m")
    wide = math.tan(math.pi / staves)
    corners = [
        (radius, side * radius * wide, z)
        for z, outside in ((0.0, bottom_radius), (height, top_radius))
        for radius in (outside - wall, outside)
        for side in (-1.0, 1.0)
    ]
    parts = [
        *_ring(Hull(np.array(corners)), staves).parts,
        Part(Cylinder(top_radius, wall), (0.0, 0.0, height - 0.5 * wall)),
    ]
    if foot:
        across = 0.5 * foot - (bottom_radius - wall)
        away, flat = 0.5 * (foot - across), 0.5 * wall
        for sign in (-1.0, 1.0):
            parts.append(Part(Box((across, foot, wall)), (sign * away, 0.0, flat)))
            parts.append(Part(Box((foot - 2.0 * across, across, wall)), (0.0, sign * away, flat)))
    shape = centered(Compound(tuple(parts)))
    assert isinstance(shape, Compound)
    return shape


def _ring(segment: Hull, count: int) -> Compound:
    return Compound(tuple(Part(segment, quat=from_yaw(k * math.tau / count)) for k in range(count)))


def _require_staves(name: str, count: int) -> None:
    if not (isinstance(count, int) and _FEWEST_STAVES <= count <= _MOST_STAVES):
        raise ConfigError(f"{name}: {_FEWEST_STAVES} to {_MOST_STAVES} parts of a ring, got {count!r}")
