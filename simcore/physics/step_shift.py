"""What positions after a step of semi-implicit Euler, x += h v with the v of its end, lack.

- Free flight under a constant force is a parabola: - a h^2 / 2.
- A body that bounces at time t does so then, not at the start: - t times the change of its velocity.
- What slides or rolls on one plane moves by the mean of its velocities along it: - h / 2 times their change.
- Under any other load nothing is lacking: the velocity of the end keeps contacts stable.
"""

from __future__ import annotations

import numpy as np

from simcore.physics.constraint_rows import RowsOfStep
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["step_shift"]

_PARALLEL = 0.9999  # cosine between normals of one plane


def step_shift(
    h: float,
    step: RowsOfStep | None,
    pushes: FloatArray,
    change: FloatArray,
    free: FloatArray,
    awake: IntArray,
    body_of_geom: IntArray,
) -> FloatArray:
    """What to add to the positions of the bodies that are awake, shape (awake, 3) [m].

    Args:
        h: Step [s].
        step: Its contacts, n of them; None: there are none.
        pushes: Normal forces of those [N], shape (n,).
        change: Of the velocity of all bodies in the step [m/s], shape (bodies, 3).
        free: The same without contacts.
        awake: Numbers of the bodies that are.
        body_of_geom: Body of each shape, -1 for statics.
    """
    shift: FloatArray = -0.5 * h * free[awake]
    if step is None:
        return shift
    bodies = len(change)
    pushed = pushes > 0.0
    hits = step.law.hits & pushed
    holds = step.law.loaded | (pushed & ~step.law.hits)
    first, second = body_of_geom[step.geoms[0]], body_of_geom[step.geoms[1]]
    held = np.zeros(bodies + 1, dtype=bool)  # the last is the world
    held[first[holds]] = held[second[holds]] = True
    shift[held[awake]] = 0.0
    _slide(h, shift, step, holds, first, second, change, awake)
    if hits.any():
        late = np.full(bodies + 1, np.inf)
        for body in (first, second):
            np.minimum.at(late, body[hits], step.law.hit_time[hits])
        late = np.where(np.isfinite(late), late, 0.0)[awake]
        shift -= late[:, None] * (change[awake] - free[awake])
    return shift


def _slide(
    h: float,
    shift: FloatArray,
    step: RowsOfStep,
    holds: BoolArray,
    first: IntArray,
    second: IntArray,
    change: FloatArray,
    awake: IntArray,
) -> None:
    """Write the shift of those that touch one plane with friction, and nothing else."""
    on_plane = holds & (step.dim > 1) & ((first < 0) | (second < 0))
    some = np.nonzero(on_plane)[0]
    if not len(some):
        return
    body = np.maximum(first, second)[some]
    normal = np.zeros((len(change) + 1, 3))
    normal[body] = step.frames[some, 0]
    bent = np.einsum("ij,ij->i", normal[body], step.frames[some, 0]) < _PARALLEL
    slides = np.zeros(len(normal), dtype=bool)
    slides[body] = True
    slides[body[bent]] = False
    others = ~on_plane
    slides[first[others]] = slides[second[others]] = False
    moving = np.nonzero(slides[awake])[0]
    n, dv = normal[awake[moving]], change[awake[moving]]
    shift[moving] = -0.5 * h * (dv - np.einsum("ij,ij->i", n, dv)[:, None] * n)
