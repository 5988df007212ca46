"""Balls against closed forms: flight, bounce, roll, friction, momentum, energy, walls, seams (run on one engine)."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from games.rebuilt.fuel import FUEL as REBUILT_FUEL
from simcore.loop.contact import foam_force
from simcore.loop.state import make_balls
from simcore.match.motion import Motion
from simcore.match.registry import find_game
from simcore.pieces.aerodynamics import Aerodynamics
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.piece_manager import GamePieceManager
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.chassis_config import ChassisConfig
from simcore.testing.benches import LoneChassis
from simcore.units import GRAVITY
from simcore.world.contact_law import (
    BUMPER,
    CARPET,
    FOAM_STIFFNESS,
    POLYCARBONATE,
    WALL,
    FoamStiffness,
    TerrainSurface,
)
from simcore.world.shapes import Box, Compound, Part, Sphere
from simcore.world.world import PhysicsWorld

pytestmark = pytest.mark.engines("bullet")
R = 0.075
FUEL = replace(REBUILT_FUEL, shape=Sphere(R), aerodynamics=None)
K1 = FUEL.foam[0]
INERTIA = 0.4 * FUEL.mass * R * R


class Scene:
    """Balls in a world that advances tick by tick."""

    def __init__(self, world: PhysicsWorld, places, *, kind: GamePieceConfig = FUEL, field=(60.0, 20.0)) -> None:
        self.world = world
        self.pieces = GamePieceManager(world, [(kind, len(places))], field_size=field)
        self.slots = self.pieces.spawn(kind.name, np.array(places, dtype=float))
        self.balls = world.balls.balls
        for slot in self.slots.tolist():
            self.pieces._wake(slot)

    def set(self, row: int, vel=(0.0, 0.0, 0.0), spin=(0.0, 0.0, 0.0)) -> None:
        self.balls.vel[row], self.balls.spin[row] = vel, spin

    def play(self, seconds: float, each=lambda: None) -> None:
        motion = Motion(self.world, pieces=self.pieces)
        for _ in range(round(seconds / 0.02)):
            motion.tick()
            each()

    def advance(self, seconds: float, h: float = 0.005, each=lambda: None) -> None:
        """Advance the ball loop alone; no ball falls asleep."""
        self.world.balls.begin_tick([], [])
        for _ in range(round(seconds / h)):
            self.world.advance(h)
            each()


# --- in the air -----------------------------------------------------------------------------------------------------


def test_a_ball_falls_exactly_on_the_parabola():
    """Drift-kick-drift is exact under constant acceleration at any step length."""
    with PhysicsWorld() as world:
        scene = Scene(world, [(2.0, 4.0, 20.0)])
        scene.set(0, (5.0, 1.0, 6.0))
        scene.play(1.0)
        assert scene.balls.pos[0] == pytest.approx([7.0, 5.0, 20.0 + 6.0 - 0.5 * GRAVITY], abs=1e-11)


@pytest.mark.parametrize(("speed", "elevation"), [(8.0, 60.0), (12.0, 50.0), (20.0, 30.0)])
@pytest.mark.parametrize("slope", [0.0, 1.0])
def test_a_flight_agrees_with_the_differential_equation(speed, elevation, slope):
    """Drag, lift by spin and fading spin; steps of 1 ms have a relative drag error of k v h / 2 = 0.02 %."""
    kind = replace(FUEL, aerodynamics=Aerodynamics(drag_coefficient=0.47, lift_slope=slope))
    air, angle = kind.air, math.radians(elevation)
    velocity = (speed * math.cos(angle), 0.0, speed * math.sin(angle))

    def motion(_t, y):
        v, w = y[3:6], y[6:9]
        v2, across = v @ v, np.cross(w, v)
        lift = air.lift * v2 / (v2 + air.lift_saturation * np.linalg.norm(across)) if slope else 0.0
        acc = -air.drag * math.sqrt(v2) * v + lift * across - (0.0, 0.0, GRAVITY)
        return [*v, *acc, *(-air.spin_drag * np.linalg.norm(w) * w)]

    start = [1.0, 4.0, 0.5, *velocity, 0.0, -40.0, 10.0]
    expected = solve_ivp(motion, (0.0, 1.0), start, rtol=1e-10, atol=1e-12).y[:, -1]
    with PhysicsWorld() as world:
        scene = Scene(world, [start[:3]], kind=kind)
        scene.set(0, velocity, start[6:])
        scene.play(1.0)
        assert scene.balls.pos[0] == pytest.approx(expected[:3], abs=0.002)
        assert scene.balls.spin[0] == pytest.approx(expected[6:], rel=1e-3)


# --- bounces --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("surface", [CARPET, WALL, BUMPER, POLYCARBONATE], ids=lambda s: s.name)
@pytest.mark.parametrize("speed", [0.3, 1.0, 3.0, 6.0, 10.0, 15.0])
def test_a_bounce_has_the_restitution_of_its_pair(surface, speed):
    """The restitution is within 0.03, wherever in a step the impact begins."""
    with PhysicsWorld(floor=surface, gravity=1e-9) as world:
        places = [(1.0 + k, 4.0, R + 0.02 + speed * 1e-3 * k / 8) for k in range(8)]
        scene = Scene(world, places)
        for k in range(8):
            scene.set(k, (0.0, 0.0, -speed))
        scene.advance(0.06 / speed + 0.15)
        out = scene.balls.vel[:, 2] / speed
        assert out == pytest.approx(np.full(8, FUEL.restitution * surface.restitution), abs=0.03)


@pytest.mark.parametrize("speed", [0.3, 1.0, 3.0, 8.0])
@pytest.mark.parametrize("restitution", [0.3, 0.5, 0.55, 0.75])
@pytest.mark.parametrize("stiffness", [FUEL.stiffness, FOAM_STIFFNESS], ids=["fuel", "dense"])
def test_two_balls_separate_with_the_restitution_of_their_pair(speed, restitution, stiffness):
    """The error is below 0.03 for restitutions of 0.09 to 0.56, in steps of 1 ms and of 0.25 ms."""
    kind = replace(FUEL, restitution=restitution, stiffness=stiffness)
    for h in (1e-3, 2.5e-4):
        with PhysicsWorld(floor=None, gravity=1e-9) as world:
            scene = Scene(world, [(2.0, 4.0, 1.0), (2.0 + 2 * R + 0.01, 4.0, 1.0)], kind=kind)
            scene.set(0, (speed, 0.0, 0.0))
            scene.advance(0.02 / speed + 0.15, h)
            u = scene.balls.vel[:, 0]
            assert (u[1] - u[0]) / speed == pytest.approx(restitution**2, abs=0.03)
            assert u.sum() == pytest.approx(speed, rel=1e-12)


def test_a_glancing_hit_of_spinning_balls_conserves_momentum_and_obeys_coulombs_law():
    """Linear and angular momentum hold to rounding; while balls slip, the tangential impulse is mu times the normal."""
    with PhysicsWorld(floor=None, gravity=1e-9) as world:
        kind = replace(FUEL, friction=0.3)
        scene = Scene(world, [(2.0, 4.0, 1.0), (2.15, 4.10, 1.02)], kind=kind)
        scene.set(0, (6.0, 0.0, 0.0), (0.0, 0.0, -90.0))
        b, m = scene.balls, kind.mass
        before = b.vel.copy()
        angular = lambda: (INERTIA * b.spin + m * np.cross(b.pos, b.vel)).sum(axis=0)  # noqa: E731
        start, seen, last = angular(), [], [b.vel[0].copy(), b.pos[0] - b.pos[1]]

        def look():
            away = b.pos[0] - b.pos[1]
            n = away + last[1]  # normal at the middle of the step
            n /= np.linalg.norm(n)
            push = (b.vel[0] - last[0]) @ n
            if push > 1e-4:
                seen.append((np.linalg.norm(b.vel[0] - last[0] - push * n), push))
            last[:] = b.vel[0].copy(), away

        scene.advance(0.15, h=0.001, each=look)
        assert (m * b.vel).sum(axis=0) == pytest.approx((m * before).sum(axis=0), rel=1e-12, abs=1e-9)
        assert angular() == pytest.approx(start, rel=1e-9, abs=1e-9)
        along, normal = np.sum(seen, axis=0)
        assert len(seen) > 7
        assert along / normal == pytest.approx(0.09, rel=0.05)


@pytest.mark.parametrize("spin", [120.0, -120.0])
def test_head_on_balls_with_equal_spin_deflect_by_mu_times_the_normal_impulse(spin):
    """The normal impulse is J = (1 + e) m v / 2, the tangential one mu J: the balls slip throughout the contact."""
    with PhysicsWorld(floor=None, gravity=1e-9) as world:
        kind = replace(FUEL, friction=0.3)
        scene = Scene(world, [(2.0, 4.0, 1.0), (2.0 + 2 * R + 0.01, 4.0, 1.0)], kind=kind)
        scene.set(0, (3.0, 0.0, 0.0), (0.0, 0.0, spin))
        scene.set(1, (0.0, 0.0, 0.0), (0.0, 0.0, spin))
        scene.advance(0.1)
        across = math.copysign(0.09 * 0.5 * (1.0 + FUEL.restitution**2) * 3.0, spin)
        assert scene.balls.vel[:, 1] == pytest.approx([-across, across], rel=0.05)


@pytest.mark.parametrize("spin", [90.0, -90.0])
def test_a_spinning_ball_gains_mu_times_its_normal_velocity_change_sideways(spin):
    """v_x = mu (1 + e) v_z: a ball with a backspin of 90 rad/s slips throughout the contact."""
    with PhysicsWorld(gravity=1e-9) as world:
        scene = Scene(world, [(2.0, 4.0, R + 0.02)])
        scene.set(0, (0.0, 0.0, -2.0), (0.0, spin, 0.0))
        scene.advance(0.1)
        mu, e = FUEL.friction * CARPET.friction, FUEL.restitution * CARPET.restitution
        sticks = 2.0 / 7.0 * abs(spin) * R  # if it sticks, it rolls off with 2/7 of its rim speed
        expected = math.copysign(min(mu * (1.0 + e) * 2.0, sticks), spin)
        assert scene.balls.vel[0, 0] == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("rate", [6.0, -6.0])
def test_a_ball_falling_on_a_turning_body_is_dragged_along_its_surface(rate):
    """The surface gives the ball mu (1 + e) v_z perpendicular to the radius; a body at rest gives it nothing."""
    with PhysicsWorld(floor=None, gravity=1e-9) as world:
        row = world.add_robot_body(
            "robot", Box((1.6, 1.6, 0.4)), mass=1000.0, surface=replace(BUMPER, friction=0.2),
            center_of_mass=(0.0, 0.0, 0.0), inertia=(1000.0, 1000.0, 1000.0), pos=(8.0, 4.0, 1.0),
        )  # fmt: skip
        world.set_velocity(row, (0.0, 0.0, 0.0), (0.0, 0.0, rate))
        scene = Scene(world, [(8.0, 4.6, 1.2 + R + 0.01)])
        scene.set(0, (0.0, 0.0, -2.0))
        scene.advance(0.05)
        across = 0.2 * FUEL.friction * (1.0 + FUEL.restitution * BUMPER.restitution) * 2.0
        vx, vy, vz = scene.balls.vel[0]
        assert vz > 0.0
        assert math.hypot(vx, vy) == pytest.approx(across, rel=0.05)
        assert vx == pytest.approx(-math.copysign(across, rate), rel=0.05)


@pytest.mark.parametrize("depth", [0.01, 0.07, 0.2])
def test_a_ball_placed_inside_an_element_leaves_the_element_without_gaining_energy(depth):
    """The ball comes out at 0.5 m/s, so after 2 s per meter of depth; one second later it rests on the element.

    A mass on a spring whose end moves at u is never faster than 2 u: v = u (1 - cos w t).
    """
    with PhysicsWorld() as world:
        world.add_static("box", Box((1.0, 1.0, 0.6)), (2.0, 4.0, 0.3), surface=WALL)
        scene = Scene(world, [(2.0, 4.0, 0.6 + R - depth)])
        fastest = []
        scene.advance(2.0 * depth + 1.0, each=lambda: fastest.append(np.linalg.norm(scene.balls.vel[0])))
        assert max(fastest) < 1.0
        squeeze = FUEL.mass * GRAVITY / K1
        assert scene.balls.pos[0] == pytest.approx([2.0, 4.0, 0.6 + R - squeeze], abs=0.5 * squeeze + 1e-4)


# --- on the floor ---------------------------------------------------------------------------------------------------


def test_air_drag_slows_a_rolling_ball_like_a_flying_ball():
    """1 / v = 1 / v0 + x / (1 + x) k t with x as in the next test: carpet friction returns 2/7 of the loss to drag."""
    kind = replace(FUEL, aerodynamics=Aerodynamics(drag_coefficient=0.47), rolling=0.0)
    with PhysicsWorld(floor=replace(CARPET, rolling=0.0)) as world:
        depth = FUEL.mass * GRAVITY / K1
        scene = Scene(world, [(2.0, 4.0, R - depth)], kind=kind)
        scene.set(0, (12.0, 0.0, 0.0), (0.0, 12.0 / (R - depth), 0.0))
        scene.balls.air[0, 1:] = 0.0  # no lift, and spin does not fade
        scene.advance(2.0)
        x = (R - depth) ** 2 / (0.4 * R * R)
        slowed = 1.0 / 12.0 + x / (1.0 + x) * kind.air.drag * 2.0
        assert 1.0 / scene.balls.vel[0, 0] == pytest.approx(slowed, rel=0.005)


def test_a_sliding_ball_ends_up_rolling_at_five_sevenths_of_its_speed():
    """v = v0 x / (1 + x) with x = m l^2 / I and l = r - m g / k1; 5/7 for a rigid ball."""
    with PhysicsWorld(floor=replace(CARPET, rolling=0.0)) as world:
        depth = FUEL.mass * GRAVITY / K1
        scene = Scene(world, [(2.0, 4.0, R - depth)])
        scene.set(0, (3.0, 0.0, 0.0))
        scene.advance(1.0)
        x = (R - depth) ** 2 / (0.4 * R * R)
        assert scene.balls.vel[0, 0] == pytest.approx(3.0 * x / (1.0 + x), rel=5e-4)
        assert scene.balls.vel[0, 0] == pytest.approx(3.0 * 5.0 / 7.0, rel=0.005)
        assert scene.balls.spin[0, 1] * (R - depth) == pytest.approx(scene.balls.vel[0, 0], rel=1e-4)


@pytest.mark.parametrize("heading", [0.0, 15.0, 45.0, 100.0, 210.0])
@pytest.mark.parametrize("speed", [0.5, 2.0])
def test_rolling_resistance_slows_a_rolling_ball(heading, speed):
    """x = v^2 / 2a along its heading with a = c g / (1.4 r), within 1 %: the weight changes r by that much."""
    rate = CARPET.rolling * FUEL.friction * GRAVITY / (1.4 * R)
    c, s = math.cos(math.radians(heading)), math.sin(math.radians(heading))
    with PhysicsWorld() as world:
        scene = Scene(world, [(20.0, 10.0, R)])
        scene.set(0, (speed * c, speed * s, 0.0), (-speed * s / R, speed * c / R, 0.0))
        scene.play(speed / rate + 1.0)
        x, y = scene.balls.pos[0, :2] - (20.0, 10.0)
        assert math.hypot(x, y) == pytest.approx(speed**2 / (2.0 * rate), rel=0.01)
        assert math.remainder(math.atan2(y, x) - math.radians(heading), math.tau) == pytest.approx(0.0, abs=1e-3)
        assert not len(scene.pieces.awake)


def tilted(world: PhysicsWorld, degrees: float, surface: TerrainSurface) -> tuple[np.ndarray, np.ndarray]:
    """Add a slope that falls along x; return its downhill direction and its normal."""
    a = math.radians(degrees)
    quat = (0.0, math.sin(0.5 * a), 0.0, math.cos(0.5 * a))
    world.add_static("slope", Box((8.0, 4.0, 0.4)), (4.0, 4.0, 2.0), surface=surface, quat=quat)
    return np.array([math.cos(a), 0.0, -math.sin(a)]), np.array([math.sin(a), 0.0, math.cos(a)])


def test_balls_against_a_stop_stay_at_rest_on_a_slope():
    """Nine balls lean on a stop on a slope of 20 degrees; once settled they creep by less than 0.1 mm in 5 s."""
    with PhysicsWorld(floor=None) as world:
        down, out = tilted(world, 20.0, CARPET)
        a = math.radians(20.0)
        middle = np.array([4.0, 4.0, 2.0]) + 0.2 * out
        quat = (0.0, math.sin(0.5 * a), 0.0, math.cos(0.5 * a))
        world.add_static("stop", Box((0.1, 4.0, 0.6)), tuple(middle + 1.05 * down), surface=WALL, quat=quat)
        places = [middle + (1.0 - R - 0.15 * i) * down + R * out + (0.0, 0.15 * (j - 1), 0.0)
                  for i in range(3) for j in range(3)]  # fmt: skip
        scene = Scene(world, places)
        scene.advance(2.0)
        before = scene.balls.pos.copy()
        scene.advance(5.0)
        assert np.abs(scene.balls.pos - before).max() < 1e-4
        assert np.abs(scene.balls.pos - places).max() < 0.02


def test_a_ball_squeezed_between_two_walls_is_held_by_friction():
    """Each wall overlaps the ball by 4 mm and bears half its weight; the friction springs stretch by less than 1 mm."""
    with PhysicsWorld(floor=None) as world:
        gap = 2.0 * (R - 0.004)
        for side in (-1.0, 1.0):
            world.add_static("wall", Box((0.2, 1.0, 1.0)), (4.0 + side * (0.5 * gap + 0.1), 4.0, 1.0), surface=CARPET)
        scene = Scene(world, [(4.0, 4.0, 1.0)])
        scene.advance(1.0)
        before = scene.balls.pos[0].copy()
        assert 0.0 < 1.0 - before[2] < 1e-3
        scene.advance(4.0)
        assert np.abs(scene.balls.pos[0] - before).max() < 1e-5


@pytest.mark.parametrize("degrees", [2.0, 8.0])
def test_a_ball_rolls_down_a_slope_that_exceeds_its_rolling_resistance(degrees):
    """The ball rolls if tan a > c / l, l = r - m g / k1, with a' = (sin a - c / l cos a) g / (1 + 0.4 r^2 / l^2)."""
    surface, lever = TerrainSurface(name="slope", friction=1.0, restitution=0.5, rolling=0.006), 0.006 * FUEL.friction
    with PhysicsWorld(floor=None) as world:
        down, out = tilted(world, degrees, surface)
        scene = Scene(world, [np.array([4.0, 4.0, 2.0]) - 2.0 * down + (0.2 + R - 4e-4) * out])
        scene.advance(0.5)
        start = scene.balls.vel[0] @ down
        scene.advance(1.0)
        a = math.radians(degrees)
        arm = R - FUEL.mass * GRAVITY / K1
        gained = max(0.0, (math.sin(a) - lever / arm * math.cos(a)) * GRAVITY / (1.0 + 0.4 * R * R / arm**2))
        assert scene.balls.vel[0] @ down - start == pytest.approx(gained, rel=0.01, abs=1e-4)


def test_a_ball_that_rolls_over_seams_keeps_its_path():
    """On a floor of tiles and on a single plate, positions agree within 0.2 mm and velocities within 2 mm/s.

    Each tile is a new contact without a history of foam and friction.
    """
    ends = []
    for tiles in (1, 16):
        with PhysicsWorld(floor=None) as world:
            for k in range(tiles):
                size = 4.0 / tiles
                for j in range(tiles):
                    place = (0.5 * size + k * size, 2.0 + 0.5 * size + j * size, -0.1)
                    world.add_static("tile", Box((size, size, 0.2)), place, surface=CARPET)
            scene = Scene(world, [(0.31, 2.4, R - 5e-4)])
            scene.set(0, (2.0, 0.7, 0.0), (-0.7 / R, 2.0 / R, 0.0))
            scene.advance(1.5)
            ends.append((scene.balls.pos[0].copy(), scene.balls.vel[0].copy()))
    assert ends[1][0] == pytest.approx(ends[0][0], abs=2e-4)
    assert ends[1][1] == pytest.approx(ends[0][1], abs=2e-3)


# --- with bodies ------------------------------------------------------------------------------------------------------


def test_a_robot_and_balls_conserve_momentum():
    """Among balls in zero gravity, linear momentum holds to rounding and angular momentum to 0.1 %."""
    rng = np.random.default_rng(5)
    with PhysicsWorld(floor=None, gravity=1e-12) as world:
        shape = Compound(
            (Part(Box((0.8, 0.8, 0.126)), (0.0, 0.0, -0.08)), Part(Box((0.6, 0.6, 0.5)), (0.0, 0.0, 0.15)))
        )
        row = world.add_robot_body(
            "robot", shape, mass=55.0, surface=BUMPER, center_of_mass=(0.0, 0.0, 0.0), inertia=(3.0, 3.0, 6.0),
            pos=(8.0, 4.0, 2.0),
        )  # fmt: skip
        world.set_velocity(row, (2.0, 0.3, 0.0), (0.0, 0.0, 1.5))
        places = [(8.9 + 0.16 * i, 3.6 + 0.16 * j, 1.9 + 0.05 * (i % 2)) for i in range(5) for j in range(5)]
        scene = Scene(world, places)
        for k in range(25):
            scene.set(k, rng.normal(0.0, 1.0, 3), rng.normal(0.0, 10.0, 3))
        b = scene.balls

        def momenta():
            body = world.bodies.of(row)[0]
            pos, axes, vel, rate = body["pos"], body["axes"], body["vel"], body["rate"]
            own = axes @ (np.array([3.0, 3.0, 6.0]) * (axes.T @ np.array(rate)))
            linear = 55.0 * np.array(vel) + (b.mass[:, None] * b.vel).sum(axis=0)
            angular = own + 55.0 * np.cross(pos, vel)
            angular = angular + (INERTIA * b.spin + b.mass[:, None] * np.cross(b.pos, b.vel)).sum(axis=0)
            return linear, angular

        before, given = momenta(), 0.0
        world.balls.begin_tick([], [])
        for _ in range(300):
            world.advance(0.005)
        after = momenta()
        given = 55.0 * np.linalg.norm(world.bodies.of(row)["vel"][0] - (2.0, 0.3, 0.0))
        assert given > 2.0, "they did meet"
        assert after[0] == pytest.approx(before[0], abs=1e-9)
        assert after[1] == pytest.approx(before[1], rel=0.001, abs=0.02)


@pytest.mark.parametrize("speed", [1.0, 2.5, 4.0])
@pytest.mark.parametrize("is_asleep", [False, True])
def test_a_ball_gains_the_momentum_that_a_robot_loses(speed, is_asleep):
    """A coasting robot pushes a sleeping or awake fuel that lies on ice; momentum holds within 1 %."""
    ice = TerrainSurface(name="ice", friction=0.0, restitution=0.0)
    with PhysicsWorld(floor=ice) as world:
        pieces = GamePieceManager(world, [(FUEL, 1)], field_size=(16.0, 8.0))
        (slot,) = pieces.spawn("Fuel", np.array([[4.6, 4.0, R]])).tolist()
        chassis = ChassisSimulation(world, ChassisConfig(surface=replace(BUMPER, friction=0.0)), pose=(4.0, 4.0, 0.0))
        world.set_velocity(chassis.row, (speed, 0.0, 0.0))
        if not is_asleep:
            pieces._wake(slot)
        motion = Motion(world, robots=[LoneChassis(chassis)], pieces=pieces)
        for _ in range(20):
            motion.tick()
        gained = FUEL.mass * world.balls.balls.vel[slot, 0]
        assert gained > 0.1
        assert 55.0 * (speed - chassis.vel[0]) == pytest.approx(gained, rel=0.01)


@pytest.mark.parametrize("seed", range(4))
def test_balls_among_walls_never_gain_energy(seed):
    """Kinetic, potential and stored foam energy: no tick adds more than the friction springs can store."""
    rng = np.random.default_rng(seed)
    speed = float(rng.uniform(0.5, 8.0))
    with PhysicsWorld() as world:
        for x, y, size in ((-0.1, 1.0, (0.2, 2.4, 40.0)), (2.1, 1.0, (0.2, 2.4, 40.0)), (1.0, -0.1, (2.4, 0.2, 40.0)),
                           (1.0, 2.1, (2.4, 0.2, 40.0))):  # fmt: skip
            world.add_static("wall", Box(size), (x, y, 1.0), surface=WALL)
        places = [(0.2 + 0.4 * i, 0.2 + 0.4 * j, 0.1 + 0.3 * k) for i in range(5) for j in range(5) for k in range(2)]
        scene = Scene(world, places)
        for k in range(50):
            scene.set(k, rng.normal(0.0, speed, 3), rng.normal(0.0, 20.0, 3))
        b, foam = scene.balls, FUEL.foam
        depths = np.linspace(0.0, 0.07, 1401)
        stored = np.concatenate(([0.0], np.cumsum([foam_force(d, *foam) for d in depths[1:]]) * (depths[1])))

        def energy():
            d = [
                np.maximum(R - b.pos[:, 2], 0.0),
                np.maximum(R - b.pos[:, :2], 0.0),
                np.maximum(b.pos[:, :2] - 2.0 + R, 0.0),
            ]
            walls = sum(np.interp(each, depths, stored).sum() for each in d)
            away = np.linalg.norm(b.pos[:, None] - b.pos[None], axis=2)[np.triu_indices(50, 1)]
            pairs = 2.0 * np.interp(np.maximum(2 * R - away, 0.0) / 2.0, depths, stored).sum()
            moving = 0.5 * FUEL.mass * (b.vel**2).sum() + 0.5 * INERTIA * (b.spin**2).sum()
            return moving + FUEL.mass * GRAVITY * b.pos[:, 2].sum() + walls + pairs

        levels = [energy()]
        scene.advance(3.0, each=lambda: levels.append(energy()))
        rises = np.diff(levels)
        assert rises.max() < 0.01 * levels[0]
        assert np.maximum.accumulate(levels[::-1])[::-1][1:] == pytest.approx(levels[1:], abs=0.02 * levels[0])
        assert levels[-1] < 0.5 * levels[0] or speed < 1.0


# --- tunneling --------------------------------------------------------------------------------------------------------


def sphere_points(count: int) -> np.ndarray:
    k = np.arange(count) + 0.5
    z, turn = 1.0 - 2.0 * k / count, math.pi * (1.0 + math.sqrt(5.0)) * k
    flat = np.sqrt(1.0 - z * z)
    return np.column_stack([flat * np.cos(turn), flat * np.sin(turn), z])


@pytest.mark.parametrize("game", ["rebuilt", "reefscape"])
def test_no_ball_at_forty_meters_per_second_enters_a_field_element(game, whole):
    """Aimed at the middle of each part from 500 directions, no ball center enters a solid (60 without --whole)."""
    definition = find_game(game)
    kind = next(supply.kind for supply in definition.pieces if isinstance(supply.kind.shape, Sphere))
    radius, inside = kind.bounding_radius, 0
    with PhysicsWorld() as world:
        world.add_field(definition.field.load().elements)
        solids = world.solids
        middles = 0.5 * (solids.box[:, :3] + solids.box[:, 3:])
        reach = 0.5 * np.linalg.norm(solids.box[:, 3:] - solids.box[:, :3], axis=1)
        ways = sphere_points(500 if whole else 60)
        starts = (middles[:, None] + (reach[:, None] + radius + 0.05)[..., None] * ways[None]).reshape(-1, 3)
        vels = np.tile(-40.0 * ways, (len(middles), 1))
        free = np.array([p[2] > radius and world.balls.depth(tuple(p), radius) == 0.0 for p in starts.tolist()])
        n = int(free.sum())
        assert n > 0.3 * len(free)
        balls = make_balls(np.full(n, 3, np.uint8), starts[free], vels[free])
        balls.is_ball[:], balls.radius[:], balls.mass[:] = 1, radius, kind.mass
        balls.foam[:], balls.surface[:] = kind.foam, (kind.friction, kind.restitution, kind.rolling)
        for _ in range(60):
            world.balls.fly(balls, 0.0005)
            tight = [world.balls.depth(tuple(p), 0.02) > 0.02 - 1e-9 for p in balls.pos.tolist()]
            inside += int(np.count_nonzero(tight))
        assert inside == 0
        assert np.isfinite(balls.pos).all() and balls.is_touched.any()


def test_a_negative_foam_stiffness_is_refused():
    from simcore.errors import ConfigError

    with pytest.raises(ConfigError, match="linear"):
        FoamStiffness(linear=-1.0, cubic=0.0)
