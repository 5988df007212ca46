"""Lists of possible contacts within a few milliseconds: between balls, and between balls and solids.

A list is valid for up to 5 ms. The list contains all pairs that can touch within this time at the present speeds, with
a margin for balls and bodies that start to move during this time.
"""

from __future__ import annotations

import numpy as np

from simcore.loop.compiled import compiled, inlined
from simcore.loop.state import AWAKE, IN_FLIGHT, NOBODY, sleeps, speed, to_body

__all__ = ["cell_range", "grid_of", "is_outside", "listed_balls", "near_pairs", "near_solids"]

_MARGIN = 0.02  # margin for balls and bodies that start to move while a list is valid [m]
_HOPS = 2  # number of sleeping balls in a chain behind a possible contact that are listed, as they may wake
_SLOW = 0.02  # largest displacement within a list of balls that count as slow [m]
_FAR = 1e5  # distance from the origin beyond which balls are ignored [m]


@inlined
def _is_here(balls_are, status, pos, i):
    """Return whether row i is a ball on the field with a finite position less than `_FAR` from the origin."""
    return (
        balls_are[i]
        and (sleeps(status, i) or status[i] == AWAKE or status[i] == IN_FLIGHT)
        and abs(pos[i, 0]) + abs(pos[i, 1]) + abs(pos[i, 2]) < _FAR
    )


@compiled
def grid_of(balls):
    """Sort the balls on the field into square cells.

    Returns:
        Row of the first ball in each cell, and row of the next ball in the cell for each ball, both -1 for none; lowest
            x and lowest y of the grid [m], edge length of a cell [m], numbers of cells along x and y, and largest
            radius of a ball [m].
    """
    is_ball, states, pos, radius = balls.is_ball, balls.status, balls.pos, balls.radius
    n = pos.shape[0]
    largest, low_x, low_y, high_x, high_y = 0.0, 1e30, 1e30, -1e30, -1e30
    for i in range(n):
        if _is_here(is_ball, states, pos, i):
            largest = max(largest, radius[i])
            low_x, high_x = min(low_x, pos[i, 0]), max(high_x, pos[i, 0])
            low_y, high_y = min(low_y, pos[i, 1]), max(high_y, pos[i, 1])
    edge = max(0.2, 2.2 * largest)
    nx = min(400, int((high_x - low_x) / edge) + 1) if high_x >= low_x else 1
    ny = min(400, int((high_y - low_y) / edge) + 1) if high_y >= low_y else 1
    head, after = np.full(nx * ny, NOBODY, np.int64), np.full(n, NOBODY, np.int64)
    for i in range(n - 1, -1, -1):
        if _is_here(is_ball, states, pos, i):
            cell = min(int((pos[i, 0] - low_x) / edge), nx - 1) * ny
            cell += min(int((pos[i, 1] - low_y) / edge), ny - 1)
            after[i] = head[cell]
            head[cell] = i
    return head, after, low_x, low_y, edge, nx, ny, largest


@inlined
def cell_range(low, high, origin, edge, count):
    """Return the indices of the first and last grid cell that an interval along an axis [m] overlaps."""
    return max(int((low - origin) / edge), 0), min(int((high - origin) / edge), count - 1)


@compiled
def listed_balls(balls, bodies, grid, way, h):
    """List the moving balls, fast balls first, and the sleeping balls that a body may touch within h [s].

    Returns:
        Rows of the listed balls, with capacity for all balls, shape (n,); for each row, 0 for a listed ball and -1 for
            any other ball, shape (n,); number of listed balls.
    """
    head, after, low_x, low_y, edge, nx, ny, _ = grid
    is_ball, status, pos, n = balls.is_ball, balls.status, balls.pos, balls.pos.shape[0]
    queue, depth, count = np.empty(n, np.int64), np.full(n, NOBODY, np.int64), 0
    for fast in (True, False):
        for i in range(n):
            if depth[i] < 0 and (way[i] > _SLOW) == fast and _is_here(is_ball, status, pos, i):
                if not sleeps(status, i):
                    queue[count], depth[i], count = i, 0, count + 1
    origin, moving, turning, extent = bodies.pos, bodies.vel, bodies.rate, bodies.model.reach
    for b in range(len(bodies)):
        if not bodies[b].is_active:
            continue
        reach = extent[b] + (speed(moving, b) + speed(turning, b) * extent[b]) * h + _MARGIN + edge
        x0, x1 = cell_range(origin[b, 0] - reach, origin[b, 0] + reach, low_x, edge, nx)
        y0, y1 = cell_range(origin[b, 1] - reach, origin[b, 1] + reach, low_y, edge, ny)
        for cx in range(x0, x1 + 1):
            for cy in range(y0, y1 + 1):
                i = head[cx * ny + cy]
                while i >= 0:
                    if depth[i] < 0:
                        queue[count], depth[i], count = i, 0, count + 1
                    i = after[i]
    return queue, depth, count


@compiled
def near_pairs(balls, grid, way, queue, depth, count, first, second):
    """Find the pairs of balls that may touch, and append the sleeping balls of these pairs to the list.

    The function searches around each ball in the order of the list, and therefore finds a pair of a fast and a slow
    ball in the search around the fast ball. The search radius of a fast ball is the largest distance from which another
    ball can reach the fast ball.

    Returns:
        Number of pairs in `first` and `second`, -1 if these arrays are too short; number of listed balls.
    """
    status, pos, radius = balls.status, balls.pos, balls.radius
    head, after, low_x, low_y, edge, nx, ny, largest = grid
    done = np.zeros(balls.pos.shape[0], np.uint8)
    pairs, room, longest = 0, len(first), 0.0
    for k in range(count):
        longest = max(longest, way[queue[k]])
    k = 0
    while k < count:
        i = queue[k]
        k += 1
        done[i] = 1
        own = radius[i] + way[i] + _MARGIN
        x, y, z = pos[i, 0], pos[i, 1], pos[i, 2]
        around = own + largest + (longest if way[i] > _SLOW else _SLOW)
        x0, x1 = cell_range(x - around, x + around, low_x, edge, nx)
        y0, y1 = cell_range(y - around, y + around, low_y, edge, ny)
        for cx in range(x0, x1 + 1):
            for cy in range(y0, y1 + 1):
                j = head[cx * ny + cy]
                while j >= 0:
                    dx, dy, dz = x - pos[j, 0], y - pos[j, 1], z - pos[j, 2]
                    reach = own + radius[j] + way[j]
                    if dx * dx + dy * dy + dz * dz < reach * reach and done[j] == 0:
                        if depth[i] < _HOPS or not sleeps(status, j):
                            if pairs == room:
                                return -1, count
                            first[pairs], second[pairs], pairs = i, j, pairs + 1
                            if depth[j] < 0:
                                queue[count], depth[j], count = j, depth[i] + 1, count + 1
                    j = after[j]
    return pairs, count


@inlined
def is_outside(box, s, x, y, z, reach):
    """Return whether a ball of radius `reach` [m] is outside the bounding box of a solid, both in the same frame."""
    return (
        x + reach < box[s, 0] or x - reach > box[s, 3] or y + reach < box[s, 1] or y - reach > box[s, 4]
        or z + reach < box[s, 2] or z - reach > box[s, 5]
    )  # fmt: skip


@compiled
def _grown(near):
    """Return a copy of `near` with twice the length; the values of the second half are undefined."""
    return np.concatenate((near, np.empty_like(near)))


@compiled
def near_solids(balls, bodies, solids, way, queue, count, h):
    """Find the solids that each listed ball may touch within h [s].

    Returns:
        Index of each ball's first entry, with the number of entries as the last element, shape (count + 1,); entries:
            rows of the solids, ball by ball, with spare capacity.
    """
    pos, radius, boxes = balls.pos, balls.radius, solids.box
    cell_first, cell_solid, cell_low = solids.cell_first, solids.cell_solid, solids.cell_low
    origin, frame, moving, turning = bodies.pos, bodies.axes, bodies.vel, bodies.rate
    is_active, model = bodies.is_active, bodies.model
    extent, first_solid, last_solid = model.reach, model.first_solid, model.last_solid
    start, near, size = np.zeros(count + 1, np.int64), np.empty(8 * count + 64, np.int64), 0
    nx, ny = solids.cell_count[0], solids.cell_count[1]
    for k in range(count):
        i = queue[k]
        start[k] = size
        x, y, z = pos[i, 0], pos[i, 1], pos[i, 2]
        reach = radius[i] + way[i] + _MARGIN
        x0, x1 = cell_range(x - reach, x + reach, cell_low[0], cell_low[2], nx)
        y0, y1 = cell_range(y - reach, y + reach, cell_low[1], cell_low[2], ny)
        for cx in range(x0, x1 + 1):
            for cy in range(y0, y1 + 1):
                cell = cx * ny + cy
                for entry in range(cell_first[cell], cell_first[cell + 1]):
                    s = cell_solid[entry]
                    if is_outside(boxes, s, x, y, z, reach):
                        continue
                    known = False
                    if x0 < x1 or y0 < y1:  # a solid may be in several cells
                        for e in range(start[k], size):
                            if near[e] == s:
                                known = True
                    if not known:
                        if size == len(near):
                            near = _grown(near)
                        near[size], size = s, size + 1
        for b in range(origin.shape[0]):
            if not is_active[b]:
                continue
            dx, dy, dz = x - origin[b, 0], y - origin[b, 1], z - origin[b, 2]
            moved = (speed(moving, b) + speed(turning, b) * extent[b]) * h
            far = reach + moved + extent[b]
            if dx * dx + dy * dy + dz * dz > far * far:
                continue
            lx, ly, lz = to_body(frame, b, dx, dy, dz)
            far = reach + moved
            for s in range(first_solid[b], last_solid[b]):
                if is_outside(boxes, s, lx, ly, lz, far):
                    continue
                if size == len(near):
                    near = _grown(near)
                near[size], size = s, size + 1
    start[count] = size
    return start, near
