"""Collision shapes as plain records: how far they reach, what they weigh, and tubes, rings and cones of convex parts.

Every shape is given in its own frame; its pose is given where it is added to a world. Volume, center of mass and
inertia are those of uniform solids.
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

_LENGTH = Quantity("m", 0.0, 2000.0, is_open=True)  # the floor of a world is that long
_RING = 24  # points of a round outline
_TOUCHES = 0.001  # [m]; points this much above the lowest one carry the shape, too
_OVER = 0.002  # [m]; how far the center may be beside what carries it
_DIRECTIONS: FloatArray = np.array([np.cos(np.arange(72) * math.tau / 72), np.sin(np.arange(72) * math.tau / 72)])


@dataclass(frozen=True, slots=True)
class Sphere:
    """A ball around the origin."""

    radius: float
    """Radius [m]."""

    def __post_init__(self) -> None:
        require_fields(self, radius=_LENGTH)


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder along z, centered at the origin."""

    radius: float
    """Radius [m]."""
    height: float
    """Whole height [m]."""

    def __post_init__(self) -> None:
        require_fields(self, radius=_LENGTH, height=_LENGTH)


@dataclass(frozen=True, slots=True)
class Box:
    """A box centered at the origin."""

    size: tuple[float, float, float]
    """Whole edge lengths along x, y and z [m]."""

    def __post_init__(self) -> None:
        require_fields(self, size=(_LENGTH,) * 3)


@dataclass(frozen=True, slots=True, eq=False)
class Hull:
    """The convex hull of some points."""

    points: FloatArray
    """Corners [m], shape (n, 3), n >= 4."""

    def __post_init__(self) -> None:
        require_points("Hull", "points", self.points, FIELD_PLACE, least=4)


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """A triangle mesh, two-sided; for statics only. Slower and leakier than the shapes above."""

    vertices: FloatArray
    """Vertices [m], shape (n, 3)."""
    faces: IntArray
    """Vertex rows of each triangle, shape (m, 3)."""

    def __post_init__(self) -> None:
        require_points("Mesh", "vertices", self.vertices, FIELD_PLACE, least=3)
        require_points("Mesh", "faces", self.faces, Quantity("", 0, len(self.vertices) - 1, is_whole=True), least=1)


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """One member of a `Compound`, at its place and attitude."""

    shape: Sphere | Cylinder | Box | Hull
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Origin of the member in the frame of the whole [m]."""
    quat: Quaternion = IDENTITY
    """Its attitude there, x, y, z, w, a unit quaternion."""

    def __post_init__(self) -> None:
        require_fields(self, offset=(FIELD_PLACE,) * 3, quat=ATTITUDE)


@dataclass(frozen=True, slots=True, eq=False)
class Compound:
    """Several convex shapes that move as one body and share one surface."""

    parts: tuple[Part, ...]

    def __post_init__(self) -> None:
        require_fields(self)
        if not self.parts:
            raise ConfigError("Compound: it needs at least one part")


Shape: TypeAlias = Sphere | Cylinder | Box | Hull | Mesh | Compound


def parts_of(shape: Shape) -> tuple[Part, ...]:
    """The convex members of a shape; a shape that is one itself is its own."""
    if isinstance(shape, Compound):
        return shape.parts
    if isinstance(shape, Mesh):
        raise ConfigError(f"a {type(shape).__name__} can only be a static")
    return (Part(shape),)


def support(shape: Shape, ways: FloatArray) -> FloatArray:
    """How far a shape reaches from its origin along unit vectors, shape (n, 3) [m], shape (n,)."""
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
    """Smallest and largest coordinates of a shape in its own frame [m], shape (3,) each."""
    return -support(shape, -np.eye(3)), support(shape, np.eye(3))


def outline_points(shape: Shape) -> FloatArray:
    """Points whose convex hull is the shape (round ones as a ring of 24), in its own frame [m], shape (n, 3)."""
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
    """Corners of the convex hull of points in a plane, counter-clockwise, shape (n, 2); the ends of a line."""
    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except QhullError:
        return np.asarray(points[np.lexsort((points[:, 1], points[:, 0]))[[0, -1]]])


@lru_cache(maxsize=256)
def bounding_radius(shape: Shape) -> float:
    """Radius of the smallest ball around the origin that holds the shape [m]."""
    if isinstance(shape, Sphere):
        return shape.radius
    if isinstance(shape, Compound):
        return max([_reach(part) for part in shape.parts])
    return float(np.linalg.norm(outline_points(shape), axis=1).max())


@lru_cache(maxsize=256)
def inner_radius(shape: Shape) -> float:
    """Radius of the largest ball around the origin within the shape's convex hull [m]."""
    if isinstance(shape, Sphere):
        return shape.radius
    if isinstance(shape, Cylinder):
        return min(shape.radius, shape.height / 2.0)
    if isinstance(shape, Box):
        return min(shape.size) / 2.0
    return float(-ConvexHull(outline_points(shape)).equations[:, 3].max())


@lru_cache(maxsize=256)
def smallest_thickness(shape: Shape) -> float:
    """Of the thinnest part, between two parallel planes of which one is along a face [m]."""
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
    """Area of the shadow of the shape's convex hull, the mean over all directions: a quarter of its surface [m^2].

    Source: A. Cauchy, 1841; exact for convex bodies, so also for a ball: pi r^2.
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
    """Height of the origin over flat ground that the shape touches in an attitude [m]."""
    return float(support(shape, -matrix(quat)[2:])[0])


def stands(shape: Shape, quat: Quaternion = IDENTITY) -> bool:
    """Whether the shape stays in an attitude on flat ground: its origin is above what carries it."""
    parts = parts_of(shape)
    axes = matrix(quat)
    points = np.vstack([_low_points(part, axes) for part in parts])
    carrying = points[points[:, 2] < points[:, 2].min() + _TOUCHES, :2]
    return bool((carrying @ _DIRECTIONS).min(axis=0).max() < _OVER)


def _low_points(part: Part, axes: FloatArray) -> FloatArray:
    """Points of which some carry a member of a shape whose axes are turned, about the shape's origin."""
    origin = axes @ np.array(part.offset)
    if isinstance(part.shape, Sphere):
        return np.array([origin - (0.0, 0.0, part.shape.radius)])
    turned: FloatArray = outline_points(part.shape) @ (axes @ matrix(part.quat)).T + origin
    return turned


def _reach(part: Part) -> float:
    """Farthest that a member has from the origin of the whole [m]."""
    if isinstance(part.shape, Sphere):
        return math.hypot(*part.offset) + part.shape.radius
    return float(np.linalg.norm(outline_points(part.shape) @ matrix(part.quat).T + part.offset, axis=1).max())


# --- mass ------------------------------------------------------------------------------------------------------------


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
        ConfigError: The shape has no volume: a mesh, or a hull of points in one plane.

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


def free_spin(spin: Vector, moments: Vector, h: float) -> Vector:
    """Angular velocity after h [s] without a torque: Euler's equations, by the classical Runge-Kutta method.

    Args:
        spin: Along the principal axes [rad/s].
        moments: Principal moments of inertia [kg m^2].
        h: Step [s].

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


# --- tubes, rings and cones ------------------------------------------------------------------------------------------


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


def hollow_cone(
    *, height: float, bottom_radius: float, top_radius: float, wall: float, foot: float = 0.0, staves: int = 12
) -> Compound:
    """A cone along z that is open below and closed on top, as one that is put over a pole; its origin is its center.

    Args:
        height: [m]
        bottom_radius: Outside, at the lower end [m].
        top_radius: Outside, at the upper end [m].
        wall: Thickness of its side and its top [m].
        foot: Edge of a square plate around its lower end [m]; 0: there is none.
        staves: Of its side, 6 to 16.

    Raises:
        ConfigError: A length is not above zero, the wall fills the cone, or the foot is smaller than its lower end.
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
