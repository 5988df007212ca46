"""Pieces that a robot presses against something with all its force: none is penetrated, and the robot is held back."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial import ConvexHull

from games.rebuilt import REBUILT
from simcore.loop.contact import foam_force
from simcore.match.motion import Motion
from simcore.pieces.piece_manager import Footprint, GamePieceManager
from simcore.pieces.pool import PieceStatus
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.chassis_config import ChassisConfig
from simcore.testing.benches import LoneChassis
from simcore.world.contact_law import WALL
from simcore.world.rotation import matrix
from simcore.world.shapes import Box, Hull, Sphere
from simcore.world.world import PhysicsWorld

DT = 0.02
RADIUS = 0.075
FUEL = replace(REBUILT.pieces[0].kind, shape=Sphere(RADIUS))
FACE = 5.0
FORCE = 55.0 * 9.80665 * 1.1
"""Largest push of the default chassis by the grip of its tires [N]."""
pytestmark = pytest.mark.engines("bullet")


def depth_at(force: float) -> float:
    """Return the compression of one side of a ball under a force [m]."""
    return brentq(lambda d: foam_force(d, *FUEL.foam) - force, 0.0, RADIUS)


def block(rows: int, columns: int, face: float = FACE) -> np.ndarray:
    """Return places of fuel on the carpet in front of a wall, slightly apart."""
    return np.array(
        [
            [face - 0.2 - 0.153 * row, 4.0 + 0.153 * (column - (columns - 1) / 2), RADIUS]
            for row in range(rows)
            for column in range(columns)
        ]
    )


class Pin:
    """A robot that drives into fuel and then backs off."""

    def __init__(self, world: PhysicsWorld, places: np.ndarray, start, field=(16.0, 8.0), kind=FUEL) -> None:
        self.world = world
        self.pieces = GamePieceManager(world, [(kind, len(places))], field_size=field)
        self.slots = self.pieces.spawn(kind.name, places)
        self.robot = ChassisSimulation(world, ChassisConfig(), pose=start)
        self.lone = LoneChassis(self.robot)
        self.motion = Motion(world, robots=[self.lone], pieces=self.pieces)

    @property
    def fuel(self) -> np.ndarray:
        return self.pieces.state.pos[self.slots]

    def drive(self, speed: float, seconds: float, each=lambda: None) -> None:
        """Drive at a speed [m/s] for a duration [s]."""
        self.lone.follow(speed, 0.0, 0.0)
        for _ in range(round(seconds / DT)):
            self.motion.tick()
            each()


def room(world: PhysicsWorld, thickness: float) -> None:
    """Add walls around x 0-5, y 0-8, with a given thickness at x = 5 [m]; 8 m high, so that no ball escapes."""
    world.add_static("face", Box((thickness, 8.0, 8.0)), (FACE + thickness / 2, 4.0, 4.0), surface=WALL)
    for x, y, size in ((2.5, -0.15, (6.0, 0.3, 8.0)), (2.5, 8.15, (6.0, 0.3, 8.0)), (-0.15, 4.0, (0.3, 8.6, 8.0))):
        world.add_static("side", Box(size), (x, y, 4.0), surface=WALL)


@pytest.mark.parametrize("thickness", [0.05, 0.3])
@pytest.mark.parametrize("speed", [1.0, 3.0, 4.5])
@pytest.mark.parametrize(("rows", "columns"), [(1, 1), (2, 3), (6, 4)])
def test_a_ball_pinned_by_a_robot_stays_in_front_of_the_wall(thickness, speed, rows, columns):
    """No ball center reaches the face; a ball that does not squeeze flat stays out of the 57 mm under the bumpers."""
    if columns > 1 and thickness == 0.05 and speed == 3.0:
        pytest.skip("a thinner wall makes no difference to a center that never comes to its face")
    places = block(rows, columns)
    with PhysicsWorld() as world:
        room(world, thickness)
        pin = Pin(world, places, (float(places[:, 0].min()) - RADIUS - 0.4 - 0.5, 4.0, 0.0), field=(FACE, 8.0))
        farthest, gaps = [0.0], []

        def look():
            farthest[0] = max(farthest[0], float(pin.fuel[:, 0].max()))
            gaps.append(FACE - pin.robot.pos[0] - 0.4)

        pin.drive(speed, 4.0, look)
        held_off = float(np.mean(gaps[100:]))  # foam takes little energy from 55 kg, so the robot still swings
        assert farthest[0] < FACE - 0.005, "no center comes to the face"
        assert farthest[0] > FACE - RADIUS - 0.01, "but it was pressed against it"
        if rows * columns == 1:
            assert 2 * RADIUS - held_off == pytest.approx(2.0 * depth_at(FORCE), rel=0.1), "a ball holds the robot off"
            assert pin.fuel[0, 0] > FACE - gaps[-1], "it has not been let out under the bumper"
        else:
            corners = np.array([(0.4, 0.4, 0.05), (0.4, -0.4, 0.05), (0.4, 0.4, 0.25), (0.4, -0.4, 0.25)])
            front = (corners @ matrix(pin.robot.quat).T + pin.robot.pos)[:, 0]
            assert front.max() < FACE + 0.01, "the robot is not in the wall, even where it climbs on fuel"
        pin.drive(-1.0, 3.0)  # stops short of the opposite wall
        asleep = pin.pieces.state.status[pin.slots] == PieceStatus.ASLEEP
        assert (pin.fuel[asleep, 0] < FACE - RADIUS + 0.006).all(), "none sleeps in the wall"
        assert (pin.fuel[:, :2] > 0.0).all() and (pin.fuel[:, 0] < FACE).all() and (pin.fuel[:, 1] < 8.0).all()
        apart = np.linalg.norm(pin.fuel[:, None] - pin.fuel[None], axis=2) + np.eye(len(pin.fuel))
        assert apart.min() > 2 * RADIUS - 0.01, "none in another"


@pytest.mark.parametrize("ahead", [0.0, 0.2, 0.36])
def test_a_robot_that_lands_on_a_ball_rests_on_it(ahead):
    """The ball is under the frame, on bare carpet, as after a jump over a bump.

    In the middle the ball bears all of the weight. Near one end the robot stands on the ball and on two wheels, and the
    moments of ball load and weight about the axle balance. The load is read from the compression of the ball against
    the carpet, averaged over two seconds because the robot still sways.
    """
    with PhysicsWorld() as world:
        pin = Pin(world, np.array([[4.0 + ahead, 4.0, RADIUS]]), (4.0, 4.0, 0.0))
        config, body = pin.robot.config, pin.robot
        world.set_pose(body.row, (4.0, 4.0, 0.115))
        body.read()
        pushes = []
        pin.drive(0.0, 3.0, lambda: pushes.append(foam_force(RADIUS - pin.fuel[0, 2], *FUEL.foam)))
        attitude = matrix(body.quat)
        axle = (attitude @ (-config.wheel_positions[0][0], 0.0, config.wheel_radius))[0]
        weight_at = (attitude @ (0.0, 0.0, config.center_of_mass_height))[0]
        ball_at = pin.fuel[0, 0] - body.pos[0]
        load = config.mass * world.gravity
        if ahead > 0.0:
            load *= (weight_at - axle) / (ball_at - axle)
        assert body.touching.count(True) == (0 if ahead == 0.0 else 2)
        assert np.mean(pushes[50:]) == pytest.approx(load, rel=0.1)
        in_frame = ((pin.fuel[0] - body.pos) @ attitude)[2] + RADIUS - config.clearance
        assert in_frame < 1.5 * depth_at(load), "and the frame stays on it"


# --- on the REBUILT field ---------------------------------------------------------------------------------------------

LENGTH, WIDTH = REBUILT.field.size
HUB_X, HUB_HALF = 4.6256, 0.597


def spot(rng: np.random.Generator) -> tuple[float, float, float]:
    """Draw a place on a wall, in a corner or on a hub, and the heading toward it."""
    kind = rng.integers(6)
    along, across = rng.uniform(1.0, LENGTH - 1.0), rng.uniform(1.0, WIDTH - 1.0)
    if kind < 4:
        return ((along, 0.0, -math.pi / 2), (along, WIDTH, math.pi / 2), (0.0, across, math.pi), (LENGTH, across, 0.0))[
            kind
        ]
    if kind == 4:
        x, y = float(rng.choice([0.0, LENGTH])), float(rng.choice([0.0, WIDTH]))
        return x, y, math.atan2(y - WIDTH / 2, (x - LENGTH / 2) / 2) + rng.uniform(-0.3, 0.3)
    x = float(rng.choice([HUB_X, LENGTH - HUB_X]))
    side = float(rng.choice([-1.0, 1.0]))
    return x + side * HUB_HALF, WIDTH / 2 + rng.uniform(-0.3, 0.3), math.pi if side > 0.0 else 0.0


def inside_of(elements) -> list:
    """Return a function for each box and hull of a field that tests whether points are inside."""
    tests = []
    for element in elements:
        pos, shape = np.asarray(element.position), element.shape
        if isinstance(shape, Box):
            half = np.array(shape.size) / 2
            tests.append(lambda p, pos=pos, half=half: (np.abs(p - pos) < half).all(axis=1))
        elif isinstance(shape, Hull):
            planes = ConvexHull(np.asarray(shape.points)).equations
            tests.append(lambda p, pos=pos, q=planes: ((p - pos) @ q[:, :3].T + q[:, 3] < 0.0).all(axis=1))
    return tests


@pytest.fixture(scope="module")
def field():
    return REBUILT.field.load()


def test_random_pins_on_the_field_lose_no_fuel(field, whole):
    """A robot presses 1, 6 or 24 fuel against guardrails, walls, corners and hub faces, at 0.3 to 4.5 m/s."""
    is_inside = inside_of(field.elements)
    assert len(is_inside) > 40
    reached = 0
    for seed in range(200 if whole else 8):
        rng = np.random.default_rng(seed)
        x, y, yaw = spot(rng)
        count, speed = int(rng.choice([1, 6, 24])), float(rng.choice([0.3, 1.0, 3.0, 4.5]))
        c, s = math.cos(yaw), math.sin(yaw)
        wide = min(count, 4)
        places = []
        for i in range(count):
            ahead, aside = 0.3 + RADIUS + 0.155 * (i // wide), 0.155 * (i % wide - (wide - 1) / 2)
            places.append([x - c * ahead - s * aside, y - s * ahead + c * aside, RADIUS])
        places = np.clip(places, [0.1, 0.1, RADIUS], [LENGTH - 0.1, WIDTH - 0.1, RADIUS])
        back = 1.25 + 0.155 * ((count - 1) // wide)
        with PhysicsWorld() as world:
            world.add_field(field.elements, drivable=REBUILT.field.drivable_in(field))
            pin = Pin(world, places, (x - c * back, y - s * back, yaw), field=(LENGTH, WIDTH))
            found = []

            def look(pin=pin, found=found):
                found.extend(pin.fuel[np.any([test(pin.fuel) for test in is_inside], axis=0)].tolist())

            pin.drive(speed, 4.0, look)
            reached += math.hypot(pin.robot.pos[0] - x, pin.robot.pos[1] - y) < back - 0.2
            pin.drive(-1.0, 6.0, look)
            assert not found, f"seed {seed}: {count} fuel at {speed} m/s, inside of something at {found[:3]}"
            for _ in range(15):  # fuel squeezed onto a guardrail is returned once it has come to rest there
                low, high = pin.fuel.min(axis=0), pin.fuel.max(axis=0)
                if low[0] > 0.0 and low[1] > 0.0 and high[0] < LENGTH and high[1] < WIDTH:
                    break
                pin.drive(0.0, 1.0, look)
            assert low[0] > 0.0 and low[1] > 0.0 and high[0] < LENGTH and high[1] < WIDTH, f"seed {seed}: outside"
    assert reached > 0, "robots got to what they pressed against"


@pytest.mark.parametrize("speed", [2.4, 2.9])
def test_bumpers_that_drive_through_loose_fuel_only_compress_it(speed):
    """The robot moves 12 and 15 mm in a step; the energy m v^2 / 2 of a ball compresses foam by less than 65 mm."""
    grid = np.array([(x, y) for x in np.arange(3.0, 5.6, 0.3) for y in np.arange(3.2, 4.9, 0.3)])
    grid += np.random.default_rng(0).uniform(-0.06, 0.06, grid.shape)
    deepest = [0.0]
    with PhysicsWorld() as world:
        pin = Pin(world, np.column_stack((grid, np.full(len(grid), RADIUS))), (2.2, 4.0, 0.0))
        start = pin.fuel.copy()

        def look():
            low = pin.fuel[pin.fuel[:, 2] < 1.5 * RADIUS]
            if len(low):
                gap = Footprint(*pin.robot.footprint).gap(low) - RADIUS
                deepest[0] = max(deepest[0], -float(gap.min()))

        pin.drive(speed, 3.5 / speed, look)
        assert pin.robot.pos[0] > 5.0, "the robot went through"
        assert float(np.linalg.norm(pin.fuel - start, axis=1).mean()) > 0.5
    assert 0.001 < deepest[0] < 0.065
