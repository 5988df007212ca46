"""Reduce a CAD mesh of a field to a triangle budget, and report how far its surface moved.

    python scripts/simplify_field.py field_cad.obj field_collision.obj --triangles 5000

Groups (`o` and `g`) are kept apart, because their names choose surfaces. Small ones are unchanged. It needs the
optional package fast-simplification (quadric decimation): pip install fast-simplification
"""

from __future__ import annotations

import argparse
import importlib
import sys
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from scipy.spatial import KDTree

from simcore.errors import SimcoreError
from simcore.typing import FloatArray, IntArray
from simcore.world.obj import ObjGroup, format_obj, read_obj

KEEP = 12
"""Largest number of triangles, that of a box, of a group that is left unchanged [-]."""
SAMPLES = 2000
"""Number of points on each side that measure the movement of the surface, over all groups."""


def simplify(groups: tuple[ObjGroup, ...], budget: int) -> tuple[ObjGroup, ...]:
    """Return the groups with about `budget` triangles together, in proportion to their present numbers.

    Raises:
        ModuleNotFoundError: If fast-simplification is not installed.
    """
    meshes = [(group.name, *_merged(group)) for group in groups]
    counts = [len(faces) for _, _, faces in meshes]
    small = sum(count for count in counts if count <= KEEP)
    large = sum(counts) - small
    share = 1.0 if large == 0 else (budget - small) / large
    out = []
    for name, points, faces in meshes:
        target = max(KEEP, int(len(faces) * share))
        if len(faces) > KEEP and target < len(faces):
            points, faces = _decimated(points, faces, target)
        out.append(ObjGroup(name, points, tuple(tuple(face) for face in faces.tolist())))
    return tuple(out)


def deviation(before: ObjGroup, after: ObjGroup, samples: int) -> FloatArray:
    """Compute distances from points on each of two surfaces to the other one, in the unit of the mesh, shape (n,)."""
    a, b = (group.vertices[group.triangles()] for group in (before, after))
    return np.concatenate([_distances(_points_on(a, samples), b), _distances(_points_on(b, samples), a)])


def _points_on(triangles: FloatArray, samples: int) -> FloatArray:
    """Return corners, which move most, and random points in proportion to area; equal in each run."""
    rng = np.random.default_rng(0)
    corners = np.unique(triangles.reshape(-1, 3), axis=0)
    if len(corners) > samples:
        corners = rng.choice(corners, samples, replace=False)
    area = np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1)
    if area.sum() == 0.0:
        return corners
    chosen = triangles[rng.choice(len(triangles), samples, p=area / area.sum())]
    u, v = np.sqrt(rng.random(samples)), rng.random(samples)
    inside = np.einsum("ij,ijk->ik", np.column_stack([1.0 - u, u * (1.0 - v), u * v]), chosen)
    return np.vstack([corners, inside])


def _distances(points: FloatArray, triangles: FloatArray) -> FloatArray:
    """Compute the exact distance of each point to the nearest triangle.

    A triangle can be nearest only if its center is within the best known distance plus its radius. Triangles are
    searched by classes of radius, so that a few long ones do not make all others candidates.
    """
    centers = triangles.mean(axis=1)
    radius = np.linalg.norm(triangles - centers[:, None], axis=2).max(axis=1)
    first = KDTree(centers).query(points)[1]
    best = _to_triangles(points, triangles[first])
    size_class = np.floor(np.log2(np.maximum(radius, 1e-9))).astype(int)
    for size in np.unique(size_class):
        rows = np.flatnonzero(size_class == size)
        near = KDTree(centers[rows]).query_ball_point(points, best + radius[rows].max() + 1e-12)
        lengths = np.array([len(n) for n in near])
        if lengths.sum() == 0:
            continue
        which = np.repeat(np.arange(len(points)), lengths)
        candidates = rows[np.concatenate([np.asarray(n, dtype=int) for n in near])]
        np.minimum.at(best, which, _to_triangles(points[which], triangles[candidates]))
    return best


def _to_triangles(points: FloatArray, triangles: FloatArray) -> FloatArray:
    closest: Any = trimesh.triangles.closest_point  # Any: it has no types
    nearest = closest(triangles, points)
    return np.asarray(np.linalg.norm(points - nearest, axis=1))


def _merged(group: ObjGroup) -> tuple[FloatArray, IntArray]:
    """Return vertices and triangles with equal vertices merged: decimation cannot move a seam."""
    points, rows = np.unique(group.vertices, axis=0, return_inverse=True)
    faces = rows.reshape(-1)[group.triangles()]
    keep = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return points, np.asarray(faces[keep], dtype=np.int64)


def _decimated(points: FloatArray, faces: IntArray, target: int) -> tuple[FloatArray, IntArray]:
    fast_simplification = importlib.import_module("fast_simplification")
    low, size = points.min(axis=0), float(np.ptp(points, axis=0).max())
    # Scaled to about 1, because the package works with absolute thresholds.
    new_points, new_faces = fast_simplification.simplify((points - low) / size, faces, target_count=target)
    if len(new_faces) == 0:  # a collapsed sliver: too many triangles are better than a hole
        return points, faces
    return np.asarray(new_points, dtype=np.float64) * size + low, np.asarray(new_faces, dtype=np.int64)


def main(argv: list[str] | None = None) -> int:
    """Run the command line and return 0 if the file was written, 1 if not, 2 for wrong arguments."""
    parser = argparse.ArgumentParser(description="Reduce a field mesh to a triangle budget.")
    parser.add_argument("input", type=Path, metavar="IN.obj")
    parser.add_argument("output", type=Path, metavar="OUT.obj")
    parser.add_argument("--triangles", type=int, default=5000, metavar="N", help="budget, default 5000")
    parser.add_argument("--scale", type=float, default=1.0, help="to meters: 0.001 for mm, 0.0254 for inches")
    args = parser.parse_args(argv)
    if args.triangles < KEEP:
        parser.error(f"--triangles must be at least {KEEP}, a box, got {args.triangles}")
    if not (np.isfinite(args.scale) and args.scale > 0.0):
        parser.error(f"--scale must be finite and > 0, got {args.scale}")
    try:
        before = tuple(
            ObjGroup(g.name, g.vertices * args.scale, g.faces)
            for g in read_obj(args.input, most_faces=10**8, most_groups=10**6)
        )
        after = simplify(before, args.triangles)
        header = f"{args.input.name} simplified to a budget of {args.triangles} triangles. Meters."
        args.output.write_text(format_obj(after, header=header), encoding="utf-8", newline="\n")
    except SimcoreError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except ModuleNotFoundError as error:
        print(f"error: {error}. Install it: pip install fast-simplification", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"error: cannot write {args.output}: {error.strerror or error}", file=sys.stderr)
        return 1
    counts = [sum(len(group.faces) for group in after), sum(len(group.triangles()) for group in before)]
    moved = [deviation(a, b, max(50, SAMPLES // len(before))) for a, b in zip(before, after, strict=True)]
    every = np.concatenate(moved) * 1000.0
    print(f"triangles: {counts[1]} -> {counts[0]} in {len(after)} groups")
    print(f"the surface moved by {every.max():.2f} mm at most, {every.mean():.3f} mm on average")
    worst = int(np.argmax([distances.max() for distances in moved]))
    if every.max() >= 0.01:
        print(f"most in group {after[worst].name!r}")
    if counts[0] > args.triangles:
        print(f"over the budget of {args.triangles}: groups of up to {KEEP} triangles are kept, open edges hold others")
    return 0


if __name__ == "__main__":
    sys.exit(main())
