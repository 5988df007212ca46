"""Heaps of fuel: no ball sinks into another, the heap comes to rest and then nothing moves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from games.rebuilt.fuel import FUEL as REBUILT_FUEL
from simcore.loop.contact import foam_force
from simcore.match.motion import Motion
from simcore.pieces.piece_manager import GamePieceManager
from simcore.world.contact_law import WALL
from simcore.world.shapes import Box, Sphere
from simcore.world.world import PhysicsWorld

DT = 0.02
RADIUS = 0.075
FUEL = replace(REBUILT_FUEL, shape=Sphere(RADIUS))
pytestmark = pytest.mark.engines("bullet")
MIDDLE = (4.0, 4.0)
ALL_SIDES = ((1, 0), (-1, 0), (0, 1), (0, -1))


class Heap:
    """Fuel that falls into a bin in layers."""

    def __init__(self, world: PhysicsWorld, count: int, size: float, sides=ALL_SIDES, seed=1) -> None:
        for dx, dy in sides:
            shape = Box((0.1, size + 0.2, 3.0) if dx else (size + 0.2, 0.1, 3.0))
            place = (MIDDLE[0] + dx * (size / 2 + 0.05), MIDDLE[1] + dy * (size / 2 + 0.05), 1.5)
            world.add_static("bin", shape, place, surface=WALL)
        self.world = world
        self.pieces = GamePieceManager(world, [(FUEL, count)], field_size=(16.0, 8.0))
        rng = np.random.default_rng(seed)
        a_side = int((size - 2 * RADIUS) / 0.16) + 1
        spread = np.linspace(RADIUS + 0.005, size - RADIUS - 0.005, a_side) - size / 2
        places = []
        for i in range(count):
            layer, place = divmod(i, a_side * a_side)
            row, column = divmod(place, a_side)
            places.append((MIDDLE[0] + spread[row], MIDDLE[1] + spread[column], RADIUS + 0.01 + 0.155 * layer))
        noise = np.column_stack((rng.uniform(-0.004, 0.004, (count, 2)), np.zeros(count)))
        self.slots = self.pieces.spawn("Fuel", np.array(places) + noise)

    @property
    def pos(self) -> np.ndarray:
        return self.pieces.state.pos[self.slots]

    @property
    def energy(self) -> float:
        """Potential plus kinetic energy [J], from the heights at the end of a tick and its mean velocities."""
        vel = self.pieces.state.vel[self.slots]
        return float(FUEL.mass * (self.world.gravity * self.pos[:, 2].sum() + 0.5 * (vel**2).sum()))

    def play(self, seconds: float, each=lambda: None) -> None:
        motion = Motion(self.world, pieces=self.pieces)
        for _ in range(round(seconds / DT)):
            motion.tick()
            each()


def overlap(pos: np.ndarray) -> float:
    """Return the largest overlap of two balls [m]."""
    pairs = cKDTree(pos).query_pairs(2 * RADIUS, output_type="ndarray")
    if not len(pairs):
        return 0.0
    return float((2 * RADIUS - np.linalg.norm(pos[pairs[:, 0]] - pos[pairs[:, 1]], axis=1)).max())


@pytest.mark.parametrize(("count", "size", "sides"), [
    (100, 0.6, ALL_SIDES), (300, 0.9, ALL_SIDES), (100, 1.2, ((-1, 0), (0, -1))),
])  # fmt: skip
def test_a_heap_holds_its_height_and_falls_asleep(count, size, sides):
    """A heap in a bin rests within 4 s and sleeps within 6 s; in a corner it rolls apart and sleeps within 16 s.

    The lowest balls yield under the weight above them, a share each. At rest in a bin, the balls fill between 0.44
    (loose packing, 8 radii from wall to wall) and 0.64 (random close packing) of the volume, or 0.70 when compressed.
    """
    with PhysicsWorld() as world:
        heap = Heap(world, count, size, sides)
        speeds, awake = [], []

        def look():
            speeds.append(float(np.linalg.norm(heap.pieces.state.vel[heap.slots], axis=1).max()))
            awake.append(len(heap.pieces.awake))

        heap.play(6.0 if len(sides) == 4 else 16.0, look)
        if len(sides) == 4:
            assert max(speeds[200:]) < 0.03
        assert awake[-1] == 0
        share = count * FUEL.mass * world.gravity / max(1.0, (size / (2.0 * RADIUS)) ** 2)
        depth = next(d for d in np.arange(0.0, 0.05, 1e-4) if foam_force(d, *FUEL.foam) > 3.0 * share)
        assert overlap(heap.pos) < 2.0 * depth + 0.002
        assert heap.pos[:, 2].min() > RADIUS - depth - 0.001, "the lowest is not in the floor"
        if len(sides) == 4:
            assert np.abs(heap.pos[:, :2] - MIDDLE).max() < size / 2 - RADIUS + depth + 0.001
            mean = heap.pos[:, 2].mean()
            filled = count * 4 / 3 * np.pi * RADIUS**3 / (size * size * 2.0 * mean)
            assert 0.44 < filled < 0.70
        before = heap.pos.copy()
        heap.play(4.0)
        assert (heap.pos == before).all(), "nothing creeps"


@pytest.mark.parametrize("on_top", [1, 2, 3, 4, 5])
def test_a_small_heap_falls_asleep_like_a_large_heap(on_top):
    """In a box for five by five balls, those on top press the others apart and the walls push back."""
    with PhysicsWorld() as world:
        heap = Heap(world, 25 + on_top, 0.8)
        heap.play(5.0)
        assert len(heap.pieces.awake) == 0
        assert overlap(heap.pos) < 0.004
        assert np.count_nonzero(heap.pos[:, 2] > 1.5 * RADIUS) >= on_top
        before = heap.pos.copy()
        heap.play(2.0)
        assert (heap.pos == before).all()


def test_a_sleeping_heap_collapses_when_its_base_is_removed():
    with PhysicsWorld() as world:
        heap = Heap(world, 60, 0.6)
        heap.play(6.0)
        foot = heap.slots[np.argsort(heap.pos[:, 2])[:9]]
        top = heap.pos[:, 2].max()
        heap.pieces.hold(foot, 0)
        heap.play(4.0)
        left = np.setdiff1d(heap.slots, foot)
        assert heap.pieces.state.pos[left, 2].max() < top - 0.05
        assert overlap(heap.pieces.state.pos[left]) < 0.012
        assert len(heap.pieces.awake) == 0
