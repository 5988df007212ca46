"""Static field: named shapes with surfaces, read from an OBJ file."""

from __future__ import annotations

import logging
import math
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from os import PathLike
from pathlib import Path
from types import MappingProxyType
from typing import Literal

import numpy as np

from simcore.errors import ConfigError, FieldMeshError, UnknownNameError
from simcore.quantities import FIELD_LENGTH, FIELD_PLACE, ROBOT_LENGTH, Quantity, require, require_fields
from simcore.typing import FloatArray
from simcore.world.contact_law import WALL, TerrainSurface
from simcore.world.mesh import SAME_PLACE, Sheet, choose_sides, decompose
from simcore.world.obj import ObjGroup, read_obj
from simcore.world.shapes import Box, Hull, Mesh, Shape, outline, outline_points
from simcore.world.symmetry import FieldSymmetry

__all__ = ["FieldBoundary", "FieldElement", "FieldGeometry", "box_element", "slope_element"]

MAX_EXTENT = 40.0
"""Largest length of a field mesh, and largest coordinate, without a known field size [m]; a larger mesh must be in
other units."""
MIN_EXTENT = 0.5
"""Smallest length of a field mesh [m]; a smaller mesh is an error."""
REFUSED_OVER = 20
"""Multiple of `max_triangles` above which loading a mesh is an error instead of a warning."""

_BEYOND, _HIGHEST = 3.0, 6.0  # [m]; stations and chutes are outside the field, and no field element has been higher
_UNITS = {"meters": 1.0, "feet": 0.3048, "inches": 0.0254, "centimeters": 0.01, "millimeters": 0.001}

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldBoundary:
    """Four walls on the floor; the inner faces bound the rectangle from (0, 0) to (length, width)."""

    length: float
    """Length along x, between the inner faces of the end walls [m]."""
    width: float
    """Width along y, between the inner faces of the side walls [m]."""
    side_height: float
    """Height of the guardrails, the walls along x [m]."""
    end_height: float
    """Height of the alliance walls, the walls along y [m]."""
    thickness: float = 0.3
    """Thickness of the walls, outward [m]; by default, too thick for a ball at 40 m/s to pass in one sub-step."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            length=FIELD_LENGTH,
            width=FIELD_LENGTH,
            side_height=FIELD_LENGTH,
            end_height=FIELD_LENGTH,
            thickness=FIELD_LENGTH,
        )

    def elements(self, surface: TerrainSurface = WALL) -> tuple[FieldElement, ...]:
        """Return the four walls as field elements.

        The names are `boundary_right` (at y = 0), `boundary_left` (at y = width), `boundary_blue` (at x = 0) and
        `boundary_red` (at x = length).
        """
        t = self.thickness
        side, end = (self.length, t, self.side_height), (t, self.width + 2.0 * t, self.end_height)
        middle = self.length / 2.0, self.width / 2.0
        places = {
            "right": (side, (middle[0], -t / 2.0)),
            "left": (side, (middle[0], self.width + t / 2.0)),
            "blue": (end, (-t / 2.0, middle[1])),
            "red": (end, (self.length + t / 2.0, middle[1])),
        }
        return tuple(
            FieldElement(
                name=f"boundary_{name}", shape=Box(size), position=np.array([x, y, size[2] / 2.0]), surface=surface
            )
            for name, (size, (x, y)) in places.items()
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FieldElement:
    """Static part of the field: a named shape with a position and a surface."""

    name: str
    """Name of the group in the mesh, with `.0`, `.1` and so on appended if the group has several shapes."""
    shape: Shape
    position: FloatArray
    """Origin of the shape, field frame [m], shape (3,). Shapes are never rotated."""
    surface: TerrainSurface = WALL

    def __post_init__(self) -> None:
        require_fields(self, self.name, position=(FIELD_PLACE,) * 3)
        position = np.array(self.position, dtype=np.float64)
        position.setflags(write=False)
        object.__setattr__(self, "position", position)

    def outline(self) -> FloatArray:
        """Compute the convex plan-view outline, counter-clockwise, field frame [m], shape (n, 2)."""
        return outline(outline_points(self.shape)[:, :2] + self.position[:2])


def box_element(
    name: str,
    low: tuple[float, float, float],
    high: tuple[float, float, float],
    surface: TerrainSurface = WALL,
) -> FieldElement:
    """Make a box-shaped field element from two opposite corners.

    Args:
        name: Name of the element.
        low: Corner with the smallest coordinates, field frame [m].
        high: Corner with the largest coordinates, field frame [m].
        surface: Surface of the box.

    Raises:
        ConfigError: If the corners are not in order.
    """
    if not all(math.isfinite(a) and math.isfinite(b) and a < b for a, b in zip(low, high, strict=True)):
        raise ConfigError(f"{name}: low must be below high on every axis, got {low} and {high} m")
    size = (high[0] - low[0], high[1] - low[1], high[2] - low[2])
    middle = np.array([0.5 * (a + b) for a, b in zip(low, high, strict=True)])
    return FieldElement(name=name, shape=Box(size), position=middle, surface=surface)


def slope_element(
    name: str,
    low: tuple[float, float, float],
    high: tuple[float, float, float],
    toward: Literal["+x", "-x", "+y", "-y"],
    surface: TerrainSurface = WALL,
) -> FieldElement:
    """Make a wedge-shaped field element that rises from a lower edge of a box to the opposite upper edge.

    Args:
        name: Name of the element.
        low: Corner of the box with the smallest coordinates, field frame [m].
        high: Corner of the box with the largest coordinates, field frame [m].
        toward: Direction in which the slope rises.
        surface: Surface of the wedge.

    Raises:
        ConfigError: If the corners are not in order or the direction is unknown.
    """
    box = box_element(name, low, high, surface)
    if toward not in ("+x", "-x", "+y", "-y"):
        raise ConfigError(f"{name}: a slope rises toward '+x', '-x', '+y' or '-y', got {toward!r}")
    axis, sign = "xy".index(toward[1]), 1.0 if toward[0] == "+" else -1.0
    half = 0.5 * (np.array(high) - low)
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)
    is_there = (corners[:, 2] < 0.0) | (sign * corners[:, axis] > 0.0)
    return FieldElement(name=name, shape=Hull(corners[is_there] * half), position=box.position, surface=surface)


@dataclass(frozen=True, slots=True, eq=False)
class FieldGeometry:
    """All static parts of a field, as shapes that an engine can collide with."""

    elements: tuple[FieldElement, ...]

    def __post_init__(self) -> None:
        require_fields(self)
        names = [element.name for element in self.elements]
        if len(set(names)) < len(names):
            double = sorted({name for name in names if names.count(name) > 1})
            raise ConfigError(f"FieldGeometry: element names must be unique, got {double} more than once")

    @classmethod
    def load(
        cls,
        path: str | PathLike[str],
        *,
        surfaces: Mapping[str, TerrainSurface] = MappingProxyType({}),
        default_surface: TerrainSurface = WALL,
        boundary: FieldBoundary | None = None,
        symmetry: FieldSymmetry | None = None,
        plate_thickness: float = 0.05,
        max_triangles: int = 5000,
    ) -> FieldGeometry:
        """Read an OBJ file in meters, z up, field frame, and convert each named group into shapes.

        `simcore.world.mesh.decompose` chooses the shapes. The method logs each group that stays a triangle mesh, and
        issues one warning with the names of all groups with mixed winding, with a winding that differs from the image
        on the other half of the field, or without an image.

        Args:
            path: Path of the OBJ file.
            surfaces: Surface by group name; `*`, `?` and `[...]` match as in file names, and the last match wins.
                Patterns also match the names of the boundary walls.
            default_surface: Surface of groups that no pattern matches.
            boundary: Walls to add around the field; None if the mesh contains the walls.
            symmetry: Symmetry between the halves of the field; None if the field has no symmetry.
            plate_thickness: Thickness of the plates made from open surfaces [m].
            max_triangles: Number of triangles above which a warning suggests a simpler mesh; loading fails above
                `REFUSED_OVER` times this number.

        Raises:
            FieldMeshError: If the file is missing, malformed or empty, or cannot be a field in meters.
            UnknownNameError: If a pattern in `surfaces` matches no group.
        """
        require("FieldGeometry.load", "max_triangles", max_triangles, Quantity("", 1, 10_000_000, is_whole=True))
        require("FieldGeometry.load", "plate_thickness", plate_thickness, ROBOT_LENGTH)
        groups = read_obj(path, most_faces=REFUSED_OVER * max_triangles)
        _check_size(Path(path), groups, max_triangles, None if symmetry is None else symmetry.size)
        walls = () if boundary is None else boundary.elements()
        names = [group.name for group in groups] + [wall.name for wall in walls]
        for pattern in surfaces:
            if not any(fnmatchcase(name, pattern) for name in names):
                raise UnknownNameError("field group matching", pattern, names)

        def surface_of(name: str) -> TerrainSurface:
            matches = [surface for pattern, surface in surfaces.items() if fnmatchcase(name, pattern)]
            return matches[-1] if matches else default_surface

        pieces = [decompose(group.vertices, group.triangles(), group=group.name) for group in groups]
        sentences = choose_sides([piece for some in pieces for piece in some if isinstance(piece, Sheet)], symmetry)
        elements: list[FieldElement] = []
        for group, some in zip(groups, pieces, strict=True):
            parts = [part for p in some for part in (p.plates(plate_thickness) if isinstance(p, Sheet) else [p])]
            if any(isinstance(part.shape, Mesh) for part in parts):
                _log.warning("%s: group %r stays a triangle mesh; balls may bump on its edges", path, group.name)
            for i, part in enumerate(parts):
                name = group.name if len(parts) == 1 else f"{group.name}.{i}"
                elements.append(
                    FieldElement(name=name, shape=part.shape, position=part.position, surface=surface_of(group.name))
                )
        if not elements:
            raise FieldMeshError(f"{path} is empty: none of its faces has an area. Check the export")
        for wall in walls:
            elements.append(
                FieldElement(name=wall.name, shape=wall.shape, position=wall.position, surface=surface_of(wall.name))
            )
        if sentences:
            sentences.append(
                "their faces are wound both ways, or not as on the other half. A plate grows behind the side from "
                "which the corners of a face run counter-clockwise; reverse them in the file for the other side"
            )
        alone = [] if symmetry is None else _without_image(elements, symmetry)
        if alone:
            sentences.append(f"{alone} have nothing in their place on the other half of the field")
        if sentences:
            warnings.warn(f"{path}: {'; '.join(sentences)}", stacklevel=2)
        return cls(tuple(elements))

    def element(self, name: str) -> FieldElement:
        """Return the element with the given name.

        Raises:
            UnknownNameError: If no element has this name.
        """
        for element in self.elements:
            if element.name == name:
                return element
        raise UnknownNameError("field element", name, (element.name for element in self.elements))

    def outlines(self) -> list[tuple[str, FloatArray]]:
        """Return the name and the plan-view outline, field frame [m], shape (n, 2), of each element, for drawings."""
        return [(element.name, element.outline()) for element in self.elements]

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return the low and high corners of the field's bounding box, field frame [m], shape (3,) each."""
        points = np.vstack([outline_points(element.shape) + element.position for element in self.elements])
        return points.min(axis=0), points.max(axis=0)


def _without_image(elements: Sequence[FieldElement], symmetry: FieldSymmetry) -> list[str]:
    """Return the names of groups with parts whose bounds have no image under the symmetry.

    The other half of the field may divide a surface differently. For the parts without an image, the function therefore
    also compares the overall bounds of the parts of each group.
    """
    low_high = [outline_points(element.shape) + element.position for element in elements]
    bounds = np.array([[points.min(axis=0), points.max(axis=0)] for points in low_high])

    def left(bounds: FloatArray) -> list[int]:
        flipped = np.sort([symmetry.flip_points(one) for one in bounds], axis=1)
        return [i for i, one in enumerate(flipped) if np.abs(bounds - one).max(axis=(1, 2)).min() > SAME_PLACE]

    groups: dict[str, list[int]] = {}
    for i in left(bounds):
        name, _, number = elements[i].name.rpartition(".")
        groups.setdefault(name if name and number.isdigit() else elements[i].name, []).append(i)
    if not groups:
        return []
    whole = np.array([[bounds[some, 0].min(axis=0), bounds[some, 1].max(axis=0)] for some in groups.values()])
    names = list(groups)
    return [names[i] for i in left(whole)]


def _misread(low: FloatArray, high: FloatArray, size: tuple[float, float]) -> str:
    """Return a sentence that explains a misplaced mesh by other units, y up or a centered origin.

    The sentence is empty if no such explanation fits.

    Args:
        low: Corner with the smallest coordinates, in the units of the file.
        high: Corner with the largest coordinates, in the units of the file.
        size: Length and width of the field [m].
    """
    for unit, scale in _UNITS.items():
        for is_y_up in (False, True):
            a, b = scale * low, scale * high
            if is_y_up:  # x stays x, y becomes z, and z becomes -y
                a, b = np.array([a[0], -b[2], a[1]]), np.array([b[0], -a[2], b[1]])
            for is_centered in (False, True):
                shift = np.array([size[0] / 2.0, size[1] / 2.0, 0.0]) if is_centered else np.zeros(3)
                length, width = b[0] - a[0], b[1] - a[1]
                is_whole = length > 0.7 * size[0] and width > 0.7 * size[1]
                if is_whole and _is_within(a + shift, b + shift, size):
                    hints = [f"in {unit} (scale it by {scale:g})"] if scale != 1.0 else []
                    hints += ["with y up (export it with z up)"] if is_y_up else []
                    hints += [f"about its middle (move it by {shift[0]:g}, {shift[1]:g} m)"] if is_centered else []
                    return f". It is {' and '.join(hints)}" if hints else ""
    return ""


def _is_within(low: FloatArray, high: FloatArray, size: tuple[float, float]) -> bool:
    """Return whether a box is within 3 m around a field, from 1 m below to 6 m above the floor [m]."""
    below, above = (-_BEYOND, -_BEYOND, -1.0), (size[0] + _BEYOND, size[1] + _BEYOND, _HIGHEST)
    return bool((low >= below).all() and (high <= above).all())


def _check_size(path: Path, groups: Iterable[ObjGroup], max_triangles: int, size: tuple[float, float] | None) -> None:
    points = np.vstack([group.vertices for group in groups])
    extent = float((points.max(axis=0) - points.min(axis=0)).max())
    farthest = float(np.abs(points).max())
    if extent < MIN_EXTENT:
        raise FieldMeshError(
            f"{path} is only {extent:g} m long; no field is under {MIN_EXTENT:g} m. Was it scaled twice?"
        )
    if size is None and max(extent, farthest) > MAX_EXTENT:
        units = [f"{unit} (scale it by {scale:g})" for unit, scale in _UNITS.items() if 5.0 <= scale * extent <= 30.0]
        raise FieldMeshError(
            f"{path} reaches {farthest:g} from the origin and is {extent:g} long; in meters no field is over "
            f"{MAX_EXTENT:g}. It is probably in {', '.join(units) or 'another unit'}"
        )
    low, high = points.min(axis=0), points.max(axis=0)
    if size is not None and not _is_within(low, high, size):
        box = " to ".join(f"({x:.4g}, {y:.4g}, {z:.4g})" for x, y, z in (low, high))
        raise FieldMeshError(
            f"{path} reaches from {box}; the field is {size[0]:g} x {size[1]:g} m with its blue corner at the origin, "
            f"in meters, z up{_misread(low, high, size)}"
        )
    count = sum(len(face) - 2 for group in groups for face in group.faces)
    if count > max_triangles:
        advice = (
            f"{path} has {count} triangles, over the limit of {max_triangles}: the simulation will be slow. Reduce it "
            f"with `python scripts/simplify_field.py {path} OUT.obj --triangles {max_triangles}`"
        )
        if count > REFUSED_OVER * max_triangles:
            raise FieldMeshError(f"{advice}, or raise max_triangles")
        warnings.warn(advice, stacklevel=3)
