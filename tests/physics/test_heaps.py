"""Heaps: nobody sinks into anything, they come to rest, and then nothing moves any more."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest
from scipy.spatial import cKDTree

from simcore.match.motion import Motion
from simcore.physics.contact_law import WALL
from simcore.physics.shapes import Box, Sphere
from simcore.physics.world import PhysicsWorld
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.piece_manager import GamePieceManager

DT = 0.02
RADIUS = 0.075
FUEL = GamePieceConfig(name="Fuel", shape=Sphere(RADIUS), mass=0.215, friction=0.8, restitution=0.55)
MIDDLE = (4.0, 4.0)
ALL_SIDES = ((1, 0), (-1, 0), (0, 1), (0, -1))


class Heap:
    """Fuel that falls into a bin from layers one above the other."""

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
        """Potential and of motion [J]; heights are of the tick's end, velocities its mean."""
        vel = self.pieces.state.vel[self.slots]
        return float(FUEL.mass * (self.world.gravity * self.pos[:, 2].sum() + 0.5 * (vel**2).sum()))

    def play(self, seconds: float, each=lambda: None, substeps: int | None = None) -> None:
        motion = Motion(self.world, pieces=self.pieces)
        for _ in range(round(seconds / DT)):
            motion.tick(steps=None if substeps is None else (substeps, 1))
            each()


def overlap(pos: np.ndarray) -> float:
    """Deepest of two balls [m]."""
    pairs = cKDTree(pos).query_pairs(2 * RADIUS, output_type="ndarray")
    if not len(pairs):
        return 0.0
    return float((2 * RADIUS - np.linalg.norm(pos[pairs[:, 0]] - pos[pairs[:, 1]], axis=1)).max())


@pytest.mark.parametrize(("count", "size", "sides"), [
    (100, 0.6, ALL_SIDES),
    pytest.param(300, 0.9, ALL_SIDES, marks=pytest.mark.slow),
    (100, 1.2, ((-1, 0), (0, -1))),
])  # fmt: skip
def test_a_heap_holds_its_height_and_falls_asleep(count, size, sides, engine_name, whole):
    """In a bin, and in a corner, where it rolls apart; with `-s` it prints its figures.

    At rest in a bin, spheres fill between 0.44 (loose, 8 radii from wall to wall) and 0.64 of the room (the closest at
    random).
    """
    if engine_name == "mujoco" and count == 300 and not whole:
        pytest.skip("10 s on MuJoCo: with --whole")
    with PhysicsWorld() as world:
        heap = Heap(world, count, size, sides)
        energies, deepest, ticks_awake = [], [0.0], [0]

        def look():
            energies.append(heap.energy)
            if len(heap.pieces.awake):
                ticks_awake[0] = len(energies)
            if len(energies) > 50:
                deepest[0] = max(deepest[0], overlap(heap.pos))

        began = time.process_time()
        heap.play(8.0 if len(sides) == 4 else 16.0, look)  # in a corner some roll away, for seconds
        print(
            f"\n{engine_name}, {count} in a {'bin' if len(sides) == 4 else 'corner'}: overlap after 1 s at most "
            f"{1000 * deepest[0]:.1f} mm, asleep after {ticks_awake[0] * DT:.1f} s, "
            f"{time.process_time() - began:.1f} s of CPU time"
        )
        assert deepest[0] < 0.008
        assert heap.pos[:, 2].min() > RADIUS - 0.003, "the lowest is not in the floor"
        assert len(heap.pieces.awake) == 0
        # a tick's mean speed may hide up to one tick of gravity's work in each awake piece
        energies = np.array(energies)
        hidden = 0.5 * FUEL.mass * (world.gravity * DT) ** 2 * count
        assert (np.diff(energies) < 0.02 * energies[0] + hidden).all(), "no tick adds any"
        assert (np.diff(energies[::25]) < 1e-3 * energies[0] + hidden).all(), "nor does half a second"
        if len(sides) == 4:
            assert np.abs(heap.pos[:, :2] - MIDDLE).max() < size / 2 - RADIUS + 0.003
            mean = heap.pos[:, 2].mean()
            filled = count * 4 / 3 * np.pi * RADIUS**3 / (size * size * 2.0 * mean)
            assert 0.44 < filled < 0.64
        before = heap.pos.copy()
        heap.play(4.0)
        assert np.abs(heap.pos - before).max() < 1e-6, "nothing creeps"


@pytest.mark.parametrize("on_top", [1, 2, 3, 4, 5])
def test_a_few_on_top_of_others_fall_asleep_like_many(on_top):
    """In a box that holds five by five: those on top press them apart, and the walls push back."""
    with PhysicsWorld() as world:
        heap = Heap(world, 25 + on_top, 0.8)
        heap.play(5.0)
        assert len(heap.pieces.awake) == 0
        assert overlap(heap.pos) < 0.002
        assert np.count_nonzero(heap.pos[:, 2] > 1.5 * RADIUS) >= on_top
        before = heap.pos.copy()
        heap.play(2.0)
        assert np.abs(heap.pos - before).max() < 1e-6


def test_a_heap_is_as_high_as_with_fine_steps(engine_name, whole):
    """At its own sub-steps within 3 % of 1.25 ms, over five heaps: one packing differs from the next by as much."""
    if engine_name == "mujoco" and not whole:
        pytest.skip("a minute on MuJoCo: with --whole")
    means = {None: [], 16: []}
    for seed in range(1, 6):
        for substeps, found in means.items():
            with PhysicsWorld() as world:
                heap = Heap(world, 100, 0.6, seed=seed)
                heap.play(5.0, substeps=substeps)
                found.append(heap.pos[:, 2].mean())
    assert np.mean(means[None]) == pytest.approx(np.mean(means[16]), rel=0.03)


def test_a_sleeping_heap_gives_way_when_its_foot_is_taken():
    with PhysicsWorld() as world:
        heap = Heap(world, 60, 0.6)
        heap.play(6.0)
        foot = heap.slots[np.argsort(heap.pos[:, 2])[:9]]
        top = heap.pos[:, 2].max()
        heap.pieces.hold(foot, 0)
        heap.play(4.0)
        left = np.setdiff1d(heap.slots, foot)
        assert heap.pieces.state.pos[left, 2].max() < top - 0.05
        assert overlap(heap.pieces.state.pos[left]) < 0.008
        assert len(heap.pieces.awake) == 0


@pytest.mark.engines("bullet")  # MuJoCo tells impacts and springs apart by itself
def test_balls_that_touch_on_a_ramp_are_no_heap():
    """Heaps ask for short steps with many iterations, as long as they are awake; balls that roll down a bump do not."""
    tilt = math.radians(15.0)
    along, up = np.array([math.cos(tilt), 0.0, -math.sin(tilt)]), np.array([math.sin(tilt), 0.0, math.cos(tilt)])
    with PhysicsWorld() as world:
        quat = (0.0, math.sin(tilt / 2), 0.0, math.cos(tilt / 2))
        world.add_static("ramp", Box((4.0, 2.0, 0.2)), (4.0, 4.0, 1.0), surface=WALL, quat=quat)
        pieces = GamePieceManager(world, [(FUEL, 3)], field_size=(16.0, 8.0))
        row = [np.array([4.0, 4.0, 1.0]) + (0.1 + RADIUS) * up + 2.0 * RADIUS * k * along for k in (-1, 0, 1)]
        slots = pieces.spawn("Fuel", np.array(row))
        motion = Motion(world, pieces=pieces)
        for _ in range(8):
            motion.tick(steps=(2, 1))
            assert motion.plan.longest_step == math.inf
        pos = pieces.state.pos[slots]
        assert np.linalg.norm(np.diff(pos, axis=0), axis=1) == pytest.approx(2.0 * RADIUS, abs=0.001), "they touch"
        assert 0.2 < np.linalg.norm(pieces.state.vel[slots], axis=1).min() < 0.5, "and roll down"
