"""GLB files in memory: bumpers in the alliance's color, pieces as bare triangles."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from simcore.errors import ModelError
from simcore.geometry.footprints import box_corners
from simcore.show.palette import rgb
from simcore.show.scene import PieceLook
from simcore.show.view_models import Model
from simcore.typing import FloatArray, IntArray

__all__ = [
    "Body", "PieceMesh", "box_glb", "convex_bodies", "corners", "linear_rgba", "look_mesh", "opaque_triangles",
    "painted_glb", "piece_mesh",
]  # fmt: skip

PieceMesh = tuple[FloatArray, IntArray, tuple[int, int, int]]
"""Vertices [m], triangles, color."""
Body = tuple[str, str, float, FloatArray]
"""Name, fill, opacity, and corners of a convex body, frame of its owner [m], shape (n, 3)."""

_PLAIN = (255, 206, 20)
_MOST_CORNERS = 64
_MOST_TRIANGLES = 500  # of a piece; hundreds are drawn. 80 run on a laptop without a graphics card, 320 do not


def linear_rgba(color: Sequence[int]) -> list[float]:
    """A color as on a screen (RGB or RGBA, 0 to 255) as glTF wants it: linear in light, 0 to 1.

    Source: IEC 61966-2-1 (sRGB).

    >>> [round(c, 3) for c in linear_rgba((255, 128, 0))]
    [1.0, 0.216, 0.0, 1.0]
    """
    red, green, blue, alpha = (*(c / 255.0 for c in color), 1.0)[:4]
    return [*(c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in (red, green, blue)), alpha]


def painted_glb(path: Path, color: tuple[int, int, int]) -> bytes:
    """The file with every mesh whose name contains `bumper` in a color; as it is if there is none."""
    data = path.read_bytes()
    scene = _load(path)
    names = [name for name in scene.geometry if "bumper" in name.lower()]
    if not names:
        return data
    for name in names:
        material = scene.geometry[name].visual.material
        material.baseColorFactor = linear_rgba(color)
    exported: bytes = scene.export(file_type="glb", include_normals=True)
    return exported


def piece_mesh(model: Model) -> PieceMesh:
    """A piece's triangles in its own frame, and its main color.

    Raises:
        ModelError: The file cannot be read, or is too fine to be drawn hundreds of times.
    """
    scene = _load(model.path)
    mesh = scene.to_geometry() if hasattr(scene, "to_geometry") else scene.dump(concatenate=True)
    if len(mesh.faces) > _MOST_TRIANGLES:
        raise ModelError(
            f"{model.path.parent.name}/{model.path.name} has {len(mesh.faces)} triangles; "
            f"a piece may have {_MOST_TRIANGLES}, because hundreds are drawn"
        )
    vertices = mesh.vertices @ model.transform[:3, :3].T + model.transform[:3, 3]
    color = _screen_color(mesh.visual.material) if hasattr(mesh.visual, "material") else _PLAIN
    mesh.vertices = vertices
    mesh.merge_vertices(merge_norm=True, merge_tex=True)  # smooth: the view computes its own normals
    return np.asarray(mesh.vertices), np.asarray(mesh.faces), color


@functools.lru_cache(maxsize=256)
def corners(model: Model) -> FloatArray:
    """Of the box around a model, frame of its owner [m], shape (8, 3); a model without a surface has its origin.

    Raises:
        ModelError: The file cannot be read.
    """
    bounds = _load(model.path).bounds
    box = np.zeros((2, 3)) if bounds is None else np.asarray(bounds)
    return box_corners(*box) @ model.transform[:3, :3].T + model.transform[:3, 3]


def opaque_triangles(model: Model, most: int) -> FloatArray:
    """Triangles of what cannot be seen through, frame of the model's owner [m], shape (n, 3, 3).

    Args:
        model: The file.
        most: A model with more of them gives none.

    Raises:
        ModelError: The file cannot be read.
    """
    found = [np.zeros((0, 3, 3))]
    for _, mesh, whole in _placed_meshes(model):
        if getattr(getattr(mesh.visual, "material", None), "alphaMode", None) != "BLEND":
            found.append(mesh.triangles @ whole[:3, :3].T + whole[:3, 3])
    triangles = np.concatenate(found)
    return triangles if len(triangles) <= most else found[0]


def convex_bodies(model: Model) -> list[Body]:
    """The convex hull of each mesh; of one with many corners the box around it.

    Raises:
        ModelError: The file cannot be read.
    """
    bodies = []
    for name, mesh, whole in _placed_meshes(model):
        points = np.unique(np.round(mesh.vertices, 4), axis=0)
        with contextlib.suppress(QhullError):  # a flat one is its own hull
            points = points[ConvexHull(points).vertices]
        if len(points) > _MOST_CORNERS:
            points = box_corners(points.min(axis=0), points.max(axis=0))
        material = getattr(mesh.visual, "material", None)
        r, g, b = _PLAIN if material is None else _screen_color(material)
        opacity = 1.0 if material is None else float(material.main_color[3]) / 255.0
        bodies.append((name, f"#{r:02x}{g:02x}{b:02x}", opacity, points @ whole[:3, :3].T + whole[:3, 3]))
    return bodies


def _placed_meshes(model: Model) -> Iterator[tuple[str, Any, FloatArray]]:
    """Each mesh of a file by its name, and where it is in the frame of the model's owner [m], shape (4, 4)."""
    scene = _load(model.path)
    for node in scene.graph.nodes_geometry:
        place, name = scene.graph[node]
        yield name, scene.geometry[name], model.transform @ place


def look_mesh(look: PieceLook) -> PieceMesh:
    """A ball or a box for a piece without a model."""
    import trimesh

    if look.size is None:
        mesh = trimesh.creation.icosphere(subdivisions=1, radius=look.reach)
    else:
        mesh = trimesh.creation.box(look.size)
    return np.asarray(mesh.vertices), np.asarray(mesh.faces), rgb(look.color)


def box_glb(size: tuple[float, float, float], height: float, color: tuple[int, int, int]) -> bytes:
    """A box about the origin in x and y, its middle at a height [m]: stands in for a robot without a model."""
    import trimesh

    visual: Any = trimesh.visual
    box = trimesh.creation.box(size)
    box.apply_translation((0.0, 0.0, height))
    material = visual.material.PBRMaterial(baseColorFactor=linear_rgba(color), metallicFactor=0.0, roughnessFactor=0.8)
    box.visual = visual.TextureVisuals(material=material)
    scene: Any = trimesh.Scene(box)
    data: bytes = scene.export(file_type="glb")
    return data


def _screen_color(material: Any) -> tuple[int, int, int]:
    """Of a glTF material, which is linear in light: the inverse of `linear_rgba`."""
    linear = np.asarray(material.main_color)[:3] / 255.0
    screen = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
    r, g, b = (round(255.0 * float(c)) for c in screen)
    return r, g, b


def _load(path: Path) -> Any:
    import trimesh

    try:
        return trimesh.load_scene(path)
    except Exception as error:  # trimesh passes on whatever its parser stumbles over
        raise ModelError(f"{path.parent.name}/{path.name} is no readable GLB: {error}") from error
