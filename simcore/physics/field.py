"""The static field as named shapes with surfaces, read from an OBJ file."""

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

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from simcore.errors import ConfigError, FieldMeshError, UnknownNameError, require_positive
from simcore.geometry.symmetry import FieldSymmetry
from simcore.physics.mesh import decompose, plates
from simcore.physics.obj import ObjGroup, read_obj
from simcore.physics.shape_extent import outline_points
from simcore.physics.shapes import Box, Mesh, Shape
from simcore.physics.sheets import SAME_PLACE, Sheet, choose_sides
from simcore.physics.surface import WALL, TerrainSurface
from simcore.typing import FloatArray

__all__ = ["FieldBoundary", "FieldElement", "FieldGeometry", "box_element"]

MAX_EXTENT = 100.0
"""No field is longer than this [m]; a mesh that is has other units."""
MIN_EXTENT = 0.5
"""Nor shorter than this [m]."""
REFUSED_OVER = 20
"""A mesh over this many times `max_triangles` is an error and no longer a warning."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldBoundary:
    """Walls around the rectangle from (0, 0) to (length, width), standing on the floor and thick to the outside."""

    length: float
    """Along x, between the inner faces of the end walls [m]."""
    width: float
    """Along y, between the inner faces of the side walls [m]."""
    side_height: float
    """Of the walls along x, where guardrails stand [m]."""
    end_height: float
    """Of the walls along y, where drivers stand [m]."""
    thickness: float = 0.3
    """Outward [m]: so thick that a ball at 40 m/s cannot pass in one sub-step."""

    def __post_init__(self) -> None:
        for name in ("length", "width", "side_height", "end_height", "thickness"):
            require_positive("FieldBoundary", name, getattr(self, name), "m")

    def elements(self, surface: TerrainSurface = WALL) -> tuple[FieldElement, ...]:
        """`boundary_right` (y = 0), `boundary_left`, and the end walls `boundary_blue` and `boundary_red`."""
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
    """One static part of the field."""

    name: str
    """Its group in the mesh; parts of a group that needs several shapes add `.0`, `.1` and so on."""
    shape: Shape
    position: FloatArray
    """Origin of the shape, field frame [m], shape (3,). Shapes stand as given, never rotated."""
    surface: TerrainSurface = WALL

    def __post_init__(self) -> None:
        position = np.array(self.position, dtype=np.float64)
        if position.shape != (3,) or not np.isfinite(position).all():
            raise ConfigError(f"{self.name}: position must be 3 finite numbers in m, got {self.position}")
        position.setflags(write=False)
        object.__setattr__(self, "position", position)

    def outline(self) -> FloatArray:
        """Convex outline seen from above, counter-clockwise, field frame [m], shape (n, 2)."""
        points = outline_points(self.shape)[:, :2] + self.position[:2]
        try:
            return np.asarray(points[ConvexHull(points).vertices])
        except QhullError:  # seen edge-on: a line
            return np.stack([points.min(axis=0), points.max(axis=0)])


def box_element(
    name: str,
    low: tuple[float, float, float],
    high: tuple[float, float, float],
    surface: TerrainSurface = WALL,
) -> FieldElement:
    """A box between two corners.

    Args:
        name: What patterns match.
        low: Smallest corner, field frame [m].
        high: Largest corner [m].
        surface: Its material.

    Raises:
        ConfigError: The corners are not in order.
    """
    if not all(math.isfinite(a) and math.isfinite(b) and a < b for a, b in zip(low, high, strict=True)):
        raise ConfigError(f"{name}: low must be below high on every axis, got {low} and {high} m")
    size = (high[0] - low[0], high[1] - low[1], high[2] - low[2])
    middle = np.array([0.5 * (a + b) for a, b in zip(low, high, strict=True)])
    return FieldElement(name=name, shape=Box(size), position=middle, surface=surface)


@dataclass(frozen=True, slots=True, eq=False)
class FieldGeometry:
    """All static parts of a field, ready for an engine."""

    elements: tuple[FieldElement, ...]

    def __post_init__(self) -> None:
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
        """Read an OBJ file in meters, z up, field frame, and turn each named group into shapes.

        `simcore.physics.mesh.decompose` chooses the shapes; a group that comes out as triangle meshes is logged. One
        warning names groups whose open surfaces are wound both ways or against their image on the other half, and
        groups that have no image there.

        Args:
            path: The OBJ file.
            surfaces: Surface by group name; `*`, `?` and `[...]` match as in file names, the last match wins. Names of
                the boundary walls match too.
            default_surface: Of groups that no pattern matches.
            boundary: Walls to add around the field; None if the mesh has its own.
            symmetry: How one half of the field becomes the other; None if it does not.
            plate_thickness: Of the plates made of open surfaces [m].
            max_triangles: Above this a warning is logged that suggests a simpler mesh; far above it is an error.

        Raises:
            FieldMeshError: The file is missing, broken or empty, or holds what cannot be a field in meters.
            UnknownNameError: A pattern in `surfaces` matches no group.
        """
        require_positive("FieldGeometry.load", "max_triangles", max_triangles)
        require_positive("FieldGeometry.load", "plate_thickness", plate_thickness, "m")
        groups = read_obj(path)
        _check_size(Path(path), groups, max_triangles)
        walls = () if boundary is None else boundary.elements()
        names = [group.name for group in groups] + [wall.name for wall in walls]
        for pattern in surfaces:
            if not any(fnmatchcase(name, pattern) for name in names):
                raise UnknownNameError("field group matching", pattern, names)

        def surface_of(name: str) -> TerrainSurface:
            matches = [surface for pattern, surface in surfaces.items() if fnmatchcase(name, pattern)]
            return matches[-1] if matches else default_surface

        pieces = [decompose(group.vertices, group.triangles(), group=group.name) for group in groups]
        remarks = choose_sides([piece for some in pieces for piece in some if isinstance(piece, Sheet)], symmetry)
        elements: list[FieldElement] = []
        for group, some in zip(groups, pieces, strict=True):
            parts = [part for p in some for part in (plates(p, plate_thickness) if isinstance(p, Sheet) else [p])]
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
        sentences = remarks.sentences
        if sentences:
            sentences.append(
                "their faces are wound both ways, or not as on the other half. A plate grows behind the side from "
                "which the corners of a face run counter-clockwise; turn them round in the file for the other side"
            )
        alone = [] if symmetry is None else _without_image(elements, symmetry)
        if alone:
            sentences.append(f"{alone} have nothing in their place on the other half of the field")
        if sentences:
            warnings.warn(f"{path}: {'; '.join(sentences)}", stacklevel=2)
        return cls(tuple(elements))

    def element(self, name: str) -> FieldElement:
        """The element of that name.

        Raises:
            UnknownNameError: There is none.
        """
        for element in self.elements:
            if element.name == name:
                return element
        raise UnknownNameError("field element", name, (element.name for element in self.elements))

    def outlines(self) -> list[tuple[str, FloatArray]]:
        """Name and outline from above of each element, for drawing: field frame [m], each of shape (n, 2)."""
        return [(element.name, element.outline()) for element in self.elements]

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest corner of everything, field frame [m], each of shape (3,)."""
        points = np.vstack([outline_points(element.shape) + element.position for element in self.elements])
        return points.min(axis=0), points.max(axis=0)


def _without_image(elements: Sequence[FieldElement], symmetry: FieldSymmetry) -> list[str]:
    """Names of groups with parts that the symmetry does not put on others, by their bounds.

    A surface may be cut up otherwise on the other half: so what is left of each group is compared as a whole, too.
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


def _check_size(path: Path, groups: Iterable[ObjGroup], max_triangles: int) -> None:
    points = np.vstack([group.vertices for group in groups])
    extent = float((points.max(axis=0) - points.min(axis=0)).max())
    farthest = float(np.abs(points).max())
    if extent < MIN_EXTENT:
        raise FieldMeshError(
            f"{path} is only {extent:g} m long; no field is under {MIN_EXTENT:g} m. Was it scaled twice?"
        )
    if max(extent, farthest) > MAX_EXTENT:
        raise FieldMeshError(
            f"{path} reaches {farthest:g} from the origin and is {extent:g} long; in meters no field is over "
            f"{MAX_EXTENT:g}. It is probably in millimeters (scale it by 0.001) or inches (0.0254)"
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
