"""Sleep is invisible: no piece hangs in the air, and sleeping pieces react like awake pieces."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from games.rebuilt.fuel import FUEL as REBUILT_FUEL
from simcore.match.motion import Motion
from simcore.pieces.piece_manager import Footprint, GamePieceManager
from simcore.pieces.pool import PieceStatus
from simcore.testing.benches import LoneChassis
from simcore.units import GRAVITY
from simcore.world.contact_law import WALL
from simcore.world.shapes import Box, Sphere
from simcore.world.world import PhysicsWorld

DT = 0.02
RADIUS = 0.075
FUEL = replace(REBUILT_FUEL, shape=Sphere(RADIUS))
pytestmark = pytest.mark.engines("bullet")
FIELD = (60.0, 8.0)


def make(world: PhysicsWorld, count: int) -> GamePieceManager:
    return GamePieceManager(world, [(FUEL, count)], field_size=FIELD)


def play(world, pieces, seconds, movers=(), each=lambda: None):
    motion = Motion(world, pieces=pieces)
    for _ in range(round(seconds / DT)):
        motion.tick(others=movers)
        each()


def keep_awake(pieces: GamePieceManager) -> None:
    """Wake every piece, to run the scene without sleep."""
    for slot in np.nonzero(pieces.state.status == PieceStatus.ASLEEP)[0].tolist():
        pieces._wake(slot)


# --- no piece hangs in the air ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("distance", [0.5, 1.0, 2.0, 3.0, 5.0, 12.0])
def test_a_ball_at_its_apex_falls_at_any_distance_from_a_robot(distance):
    """A ball that is slow for an instant must not fall asleep in mid-air."""
    with PhysicsWorld() as world:
        pieces = make(world, 1)
        pieces.hold(pieces.stage("Fuel", 1), 0)
        slot = pieces.launch(0, (2.0, 4.0, 0.6), (0.0, 0.0, 4.0))
        robot = Footprint(2.0 + distance, 4.0, 0.0, 0.4, 0.4, 0.0)
        heights, statuses = [], []
        each = lambda: (heights.append(pieces.state.pos[slot, 2]), statuses.append(pieces.state.status[slot]))  # noqa: E731
        play(world, pieces, 1.6, [robot], each)
        fall = np.array(heights)
        assert fall.max() == pytest.approx(0.6 + 4.0**2 / (2 * world.gravity), abs=0.02)
        assert not any(s == PieceStatus.ASLEEP for s, z in zip(statuses, heights, strict=True) if z > RADIUS + 0.003)
        play(world, pieces, 3.0, [robot])
        assert pieces.state.status[slot] == PieceStatus.ASLEEP
        assert pieces.state.pos[slot, 2] == pytest.approx(RADIUS, abs=0.002)


def test_a_ball_spawned_in_the_air_falls_without_a_robot_near():
    with PhysicsWorld() as world:
        pieces = make(world, 3)
        slots = pieces.spawn("Fuel", np.array([[3.0, 3.0, 0.08], [5.0, 3.0, 1.0], [6.0, 3.0, 3.0]]))
        play(world, pieces, 4.0)
        assert pieces.state.pos[slots, 2] == pytest.approx([RADIUS] * 3, abs=0.002)


@pytest.mark.parametrize("rate", [0.5, 2.0])
def test_a_sleeping_ball_is_always_supported_while_a_heap_falls_and_settles(rate):
    """At every tick each sleeping ball touches the floor or a ball below its center."""
    rng = np.random.default_rng(2)
    with PhysicsWorld() as world:
        for x, y, size in ((4.0, 4.5, (1.2, 0.1, 1.0)), (4.0, 3.5, (1.2, 0.1, 1.0)), (3.5, 4.0, (0.1, 1.0, 1.0)),
                           (4.5, 4.0, (0.1, 1.0, 1.0))):  # fmt: skip
            world.add_static("bin", Box(size), (x, y, 0.5), surface=WALL)
        pieces = make(world, 60)
        places = np.column_stack(
            (rng.uniform(3.7, 4.3, 60), rng.uniform(3.7, 4.3, 60), 0.3 + 0.16 / rate * np.arange(60))
        )
        pieces.spawn("Fuel", places)
        hanging, seen_asleep = [], [0]

        def look():
            asleep = np.nonzero(pieces.state.status == PieceStatus.ASLEEP)[0]
            pos = pieces.state.pos
            for slot in asleep.tolist():
                if pos[slot, 2] < RADIUS + 0.003:
                    continue
                seen_asleep[0] += 1
                away = np.linalg.norm(pos - pos[slot], axis=1)
                below = (away < 2 * RADIUS + 0.004) & (pos[:, 2] < pos[slot, 2] - 0.005)
                if not below.any():
                    hanging.append((slot, pos[slot].tolist()))

        play(world, pieces, 8.0, each=look)
        assert hanging == []
        assert seen_asleep[0] > 5, "some slept on others"


# --- removing support wakes the pieces above --------------------------------------------------------------------------


def pyramid(pieces: GamePieceManager, world: PhysicsWorld, x: float = 4.0) -> tuple[np.ndarray, int]:
    """Spawn three balls between posts, with a fourth on top."""
    side = 2 * RADIUS
    height = RADIUS + side * math.sqrt(2.0 / 3.0)
    base = np.array([[x, 4.0, RADIUS], [x + side, 4.0, RADIUS], [x + side / 2, 4.0 + side * math.sqrt(3) / 2, RADIUS]])
    middle = base.mean(axis=0)
    for angle in (30.0, 150.0, 270.0):  # posts that keep the three balls from rolling apart
        a = math.radians(angle)
        away = side / math.sqrt(3) + 0.0005
        for turn in (-0.55, 0.55):
            c, s = math.cos(a + turn * 0.9), math.sin(a + turn * 0.9)
            place = (middle[0] + (away + 0.09) * c, middle[1] + (away + 0.09) * s, 0.1)
            world.add_static("post", Box((0.03, 0.03, 0.2)), place, surface=WALL)
    slots = pieces.spawn("Fuel", np.vstack((base, [middle[0], middle[1], height + 0.003])))
    return slots[:3], int(slots[3])


@pytest.mark.parametrize("how", ["hold", "score"])
def test_a_ball_falls_when_the_balls_under_it_are_taken(how):
    with PhysicsWorld() as world:
        pieces = make(world, 4)
        base, top = pyramid(pieces, world)
        play(world, pieces, 3.0)
        assert pieces.count(PieceStatus.ASLEEP) == 4
        assert pieces.state.pos[top, 2] > 0.15, "it lies on the three"
        if how == "hold":
            pieces.hold(base, 0)
        else:
            pieces.score(base)
        play(world, pieces, 1.5)
        assert pieces.state.pos[top, 2] == pytest.approx(RADIUS, abs=0.003)


def test_a_ball_falls_when_the_balls_under_it_are_moved():
    with PhysicsWorld() as world:
        pieces = make(world, 4)
        base, top = pyramid(pieces, world)
        play(world, pieces, 6.0)
        assert pieces.state.pos[top, 2] > 0.15
        pieces.release(base, np.array([[10.0 + i, 2.0, RADIUS] for i in range(3)]))
        play(world, pieces, 1.5)
        assert pieces.state.pos[top, 2] == pytest.approx(RADIUS, abs=0.003)


# --- a sleeping piece wakes before anything reaches it ----------------------------------------------------------------


def shoot_at_row(count: int, gap: float, speed: float, awake: bool):
    """Shoot a ball at `speed` into a row of balls along x; return where all balls end [m]."""
    with PhysicsWorld() as world:
        pieces = make(world, count + 1)
        row = pieces.spawn("Fuel", np.array([[5.0 + i * (2 * RADIUS + gap), 4.0, RADIUS] for i in range(count)]))
        shot = pieces.spawn("Fuel", np.array([[4.5, 4.0, RADIUS]]))
        assert not len(pieces.awake)
        if awake:
            keep_awake(pieces)
        pieces.push(shot, np.array([[speed, 0.0, 0.0]]))
        play(world, pieces, 1.0, each=(lambda: keep_awake(pieces)) if awake else (lambda: None))
        return pieces.state.pos[np.concatenate((shot, row))].copy()


@pytest.mark.parametrize("speed", [0.3, 1.0, 4.0, 20.0, 40.0])
@pytest.mark.parametrize("gap", [0.0, 0.0024, 0.05])
def test_a_ball_meets_a_sleeping_row_as_if_it_were_awake(speed, gap):
    """Places agree within 5 mm plus 3 % of the way: awake balls have settled into the carpet by half a millimeter.

    No ball passes another: the carpet holds the row with 1.7 N a ball, so at most 7.6 N at the middle of nine, which
    compress two balls by 3 mm. Touching balls hand on (1 + e) / 2 of their speed: of 4 m/s the last gets 0.13 m/s and
    rolls 18 mm.
    """
    asleep, awake = shoot_at_row(8, gap, speed, False), shoot_at_row(8, gap, speed, True)
    assert (np.diff(asleep[:, 0]) > 2 * RADIUS - 0.003).all(), "none passed another"
    assert asleep[:, 0] == pytest.approx(awake[:, 0], abs=0.005 + 0.03 * speed)
    if gap == 0.0 and speed >= 4.0:
        assert asleep[-1, 0] > 5.0 + 7 * 2 * RADIUS + 0.012, "the last one rolls away"


@pytest.mark.parametrize("speed", [0.7, 1.5, 2.4])
def test_a_robot_ploughs_through_sleeping_fuel_as_if_it_were_awake(speed):
    """Over 2 m through 12 x 5 fuel, the displacements of robot and fuel agree within 2 %.

    Means over eight blocks with balls up to 0.4 mm off the grid: in a perfect grid all rows behave alike, and rounding
    decides between two outcomes. All balls start compressed by their weight.
    """
    from simcore.robot.chassis import ChassisSimulation
    from simcore.robot.chassis_config import ChassisConfig

    height = RADIUS - FUEL.mass * GRAVITY / FUEL.foam[0]
    lattice = np.array([[5.0 + 0.1512 * i, 4.0 + 0.1512 * (j - 5.5), height] for i in range(5) for j in range(12)])
    ways = {False: [], True: []}
    for awake, seed in itertools.product(ways, range(1, 9)):
        jitter = np.random.default_rng(seed).uniform(-4e-4, 4e-4, (60, 2))
        places = lattice + np.column_stack((jitter, np.zeros(60)))
        with PhysicsWorld() as world:
            pieces = make(world, 60)
            slots = pieces.spawn("Fuel", places)
            robot = ChassisSimulation(world, ChassisConfig(), pose=(4.0, 4.0, 0.0))
            lone = LoneChassis(robot)
            motion = Motion(world, robots=[lone], pieces=pieces)
            lone.follow(speed, 0.0, 0.0)
            for _ in range(round(2.0 / speed / DT)):
                if awake:
                    keep_awake(pieces)
                motion.tick()
            ways[awake].append((robot.pos[0] - 4.0, float((pieces.state.pos[slots] - places)[:, 0].mean())))
    asleep, all_awake = np.mean(ways[False], axis=0), np.mean(ways[True], axis=0)
    assert all_awake[0] > 1.5
    assert all_awake[1] > 0.3
    assert asleep == pytest.approx(all_awake, rel=0.02)


def test_a_fast_robot_overlaps_sleeping_balls_by_less_than_30_mm():
    """Bumpers at 4 m/s through sleeping balls: the overlap stays below 30 mm."""
    from simcore.robot.chassis import ChassisSimulation
    from simcore.robot.chassis_config import ChassisConfig

    with PhysicsWorld() as world:
        pieces = make(world, 60)
        grid = np.array([[5.9 + 0.2 * i, 3.5 + 0.2 * j, RADIUS] for i in range(10) for j in range(6)])
        pieces.spawn("Fuel", grid)
        robot = ChassisSimulation(world, ChassisConfig(), pose=(3.5, 4.0, 0.0))
        deepest = 0.0
        lone = LoneChassis(robot)
        lone.follow(4.0, 0.0, 0.0)
        motion = Motion(world, robots=[lone], pieces=pieces)
        for _ in range(60):
            motion.tick()
            away = np.abs(pieces.state.pos[:, :2] - robot.pos[:2])
            inside = (away < 0.4).all(axis=1) & (pieces.state.pos[:, 2] < 0.25)
            if inside.any():
                deepest = max(deepest, float((0.4 - away[inside].max(axis=1)).max()))
        assert robot.pos[0] > 6.5
        assert deepest < 0.03, "a middle may come no nearer than 45 mm outside of the bumper"


# --- results do not depend on distant events --------------------------------------------------------------------------


def travel(kind: str, elsewhere: float | None) -> np.ndarray:
    from simcore.pieces.aerodynamics import Aerodynamics

    config = replace(FUEL, aerodynamics=Aerodynamics(drag_coefficient=0.47), rolling=0.003)
    with PhysicsWorld() as world:
        pieces = GamePieceManager(world, [(config, 2)], field_size=(40.0, 8.0))
        pieces.hold(pieces.stage("Fuel", 2), 0)
        if kind == "roll":
            mine = pieces.launch(0, (2.0, 2.0, RADIUS), (2.0, 0.0, 0.0), (0.0, 2.0 / RADIUS, 0.0))
        else:
            mine = pieces.launch(0, (2.0, 2.0, 0.5), (6.0, 0.0, 6.0))
        if elsewhere is not None:
            pieces.launch(0, (38.0, 7.0, 2.0), (-elsewhere, 0.0, 5.0))
        play(world, pieces, 1.0 if kind == "fly" else 5.0)
        return pieces.state.pos[mine].copy()


@pytest.mark.parametrize("speed", [10.0, 40.0])
@pytest.mark.parametrize("kind", ["fly", "roll"])
def test_a_fast_ball_elsewhere_does_not_change_a_balls_path(kind, speed):
    alone, busy = travel(kind, None), travel(kind, speed)
    length = float(np.linalg.norm(alone[:2] - (2.0, 2.0)))
    assert length > 2.0
    assert (busy == alone).all(), "nobody changes another one's steps"


# --- pieces that leave the field --------------------------------------------------------------------------------------


@pytest.mark.parametrize("out", [(65.0, 4.0, 1.0), (-3.0, 4.0, 0.1), (8.0, 30.0, 0.1), (8.0, 4.0, -5.0)])
def test_a_ball_that_leaves_the_field_is_returned_inside(out):
    with PhysicsWorld() as world:
        pieces = make(world, 1)
        slot = pieces.spawn("Fuel", np.array([out]))[0]
        play(world, pieces, 0.02)
        x, y, _ = pieces.state.pos[slot]
        assert 0.0 < x < FIELD[0] and 0.0 < y < 8.0
        assert pieces.recovered == 1
        play(world, pieces, 4.0)
        assert pieces.state.status[slot] == PieceStatus.ASLEEP and pieces.state.pos[slot, 2] < 0.08
        assert pieces.recovered == 1


def test_balls_that_leave_together_return_without_bursting_apart():
    with PhysicsWorld() as world:
        pieces = make(world, 12)
        pieces.spawn("Fuel", np.array([[-3.0, 2.0 + 0.2 * i, 1.0] for i in range(12)]))
        fastest = [0.0]

        def each():
            fastest[0] = max(fastest[0], float(np.linalg.norm(pieces.state.vel, axis=1).max()))

        play(world, pieces, 0.02)
        play(world, pieces, 5.0, each=each)
        assert fastest[0] < 5.0, "they fall from 0.6 m (3.4 m/s), not more"
        apart = np.linalg.norm(pieces.state.pos[:, None] - pieces.state.pos[None], axis=2) + np.eye(12)
        assert apart.min() > 2 * RADIUS - 0.006
