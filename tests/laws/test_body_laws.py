"""A robot as one rigid body against closed forms: loads, transfer, tipping, sliding, slopes, falls, other robots."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from simcore.match.motion import Motion
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.chassis_config import ChassisConfig, MassDistribution
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.swerve_drive import SwerveDrive
from simcore.testing.benches import DriveBench, LoneChassis
from simcore.units import GRAVITY, inches
from simcore.world.contact_law import BUMPER, POLYCARBONATE, WALL
from simcore.world.rotation import from_rpy, matrix, rotate
from simcore.world.shapes import Box, Hull
from simcore.world.world import PhysicsWorld

pytestmark = pytest.mark.engines("bullet")
BASE = 0.527
HELD = SwerveModuleConfig(x=0, y=0, rolling_resistance=0.0, drive_friction_volts=20.0)
"""Module whose wheel is locked, so that the wheel slides with mu N at any speed."""


def braked(cof, *, height=0.2, vx=4.0):
    """Return a bench whose robot slides on locked wheels."""
    module = replace(HELD, wheel_cof=cof)
    bench = DriveBench(SwerveDrive(SwerveConfig.square(BASE, module, height=height)))
    bench.reset(vx=vx)
    return bench


def energy(chassis):
    """Return the kinetic plus potential energy [J]."""
    mass, center, inertia = chassis.distribution
    z = chassis.pos[2] + rotate(chassis.quat, center)[2]
    spin = matrix(chassis.quat).T @ chassis.rate
    return 0.5 * mass * math.hypot(*chassis.vel) ** 2 + 0.5 * float(inertia @ spin**2) + mass * GRAVITY * z


def play(world, *robots, seconds, each=lambda: None):
    motion = Motion(world, robots=[LoneChassis(robot) for robot in robots])
    for _ in range(round(seconds / 0.02)):
        motion.tick()
        each()


def test_a_robot_at_rest_has_equal_wheel_loads_and_is_at_height_zero():
    bench = DriveBench(SwerveDrive(SwerveConfig.square(BASE, HELD)))
    bench.run(1.0)
    assert bench.loads == pytest.approx([55.0 * GRAVITY / 4.0] * 4, rel=1e-6)
    assert bench.chassis.pos == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    assert bench.chassis.roll_pitch_yaw == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


@pytest.mark.parametrize("share", [0.2, 0.4, 0.6])
def test_braking_transfers_m_a_h_over_the_wheelbase_to_the_front_wheels(share):
    bench = braked(share)
    bench.run(0.3)
    front = sum(bench.loads[:2])
    bench.run(0.005)
    assert bench.ax == pytest.approx(-share * GRAVITY, rel=0.01)
    expected = 0.5 * 55.0 * GRAVITY + 55.0 * share * GRAVITY * 0.2 / BASE
    assert front == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize(("share", "tips"), [(0.95, False), (1.05, True), (1.25, True)])
@pytest.mark.parametrize("height", [0.24, 0.4])
def test_a_braking_robot_tips_at_the_static_limit(share, tips, height):
    """Above mu h = half the wheelbase the rear wheels lift and do not come down again."""
    bench = braked(share * 0.5 * BASE / height, height=height)
    pitch = []
    bench.run(0.3, each=lambda: pitch.append(math.degrees(bench.chassis.roll_pitch_yaw[1])))
    assert max(pitch[20:]) > 0.3 if tips else max(pitch) < 0.15


@pytest.mark.parametrize("radius", [0.45, 0.55])
@pytest.mark.parametrize("height", [0.3, 0.7])
def test_a_robot_rocks_by_plastic_impacts_of_its_wheels(radius, height):
    """A robot dropped from 1.5 degrees onto its rear wheels rocks to ((k^2 - b^2) / (k^2 + b^2))^2 of 1.5 degrees.

    No spring returns energy: the landing wheels stop and the remaining motion turns about them. k: radius of gyration.
    Tolerance: wheels compress by 0.3 mm, which is a tenth of a degree.
    """
    config = ChassisConfig(height=1.0)
    half = config.wheel_positions[0][0]
    inertia = 55.0 * radius**2
    with PhysicsWorld() as world:
        chassis = ChassisSimulation(
            world, config, mass=MassDistribution(55.0, (0.0, 0.0, height), (inertia, inertia, 6.0))
        )
        quat = from_rpy(0.0, math.radians(1.5), 0.0)
        world.set_pose(chassis.row, (0.0, 0.0, -rotate(quat, (half, 0.0, 0.0))[2]), quat)
        chassis.read()
        pitch = []
        play(world, chassis, seconds=0.8, each=lambda: pitch.append(math.degrees(chassis.roll_pitch_yaw[1])))
    left = ((radius**2 - half**2) / (radius**2 + half**2)) ** 2
    assert -min(pitch) == pytest.approx(1.5 * left, abs=0.05)


def test_a_robot_that_tips_over_locked_wheels_keeps_its_energy():
    """The wheels roll on the carpet with the robot, without slip: static friction does no work.

    Tolerance: the wheels spring by 0.6 mm under 270 N each, 0.16 J together; treads creep by 1 % of the way.
    """
    places = ((0.2667, 0.2667), (0.2667, -0.2667), (-0.2667, 0.2667), (-0.2667, -0.2667))
    config = ChassisConfig(bumper_length=0.62, clearance=0.12, wheel_positions=places, center_of_mass_height=0.4)
    drive = SwerveDrive(SwerveConfig.square(2.0 * 0.2667, replace(HELD, wheel_cof=2.0), height=0.4))
    pitch, radius = math.radians(45.0), config.wheel_radius
    with PhysicsWorld() as world:
        chassis = ChassisSimulation(world, config, drivetrain=drive)
        lift = radius + 0.2667 * math.sin(pitch) - radius * math.cos(pitch)
        world.set_pose(chassis.row, (0.0, 0.0, lift), from_rpy(0.0, pitch, 0.0))
        chassis.read()
        start, energies, tilts = energy(chassis), [], []
        for _ in range(200):
            world.advance(0.005)
            chassis.read()
            energies.append(energy(chassis))
            tilts.append(chassis.roll_pitch_yaw[1])
            if tilts[-1] > math.radians(80.0):
                break
    assert max(tilts) > math.radians(80.0)
    assert max(energies) < start + 0.2
    assert min(energies) > start - 0.2 - 0.02 * 55.0 * GRAVITY * 0.2


@pytest.mark.parametrize(
    ("attitude", "axis"),
    [((math.pi / 2, 0.0), 0), ((math.pi, 0.0), 0), ((0.0, math.pi / 2), 1)],
    ids=["side", "back", "end"],
)
def test_friction_stops_a_fallen_sliding_robot(attitude, axis):
    """a = mu g with mu = 0.4; then it stays at rest."""
    config = ChassisConfig(center_of_mass_height=0.25)
    with PhysicsWorld() as world:
        chassis = ChassisSimulation(world, config)
        quat = from_rpy(*attitude, 0.0)
        corners = [(x, y, z) for x in (-0.4, 0.4) for y in (-0.4, 0.4) for z in (config.clearance, config.height)]
        lift = -min(rotate(quat, corner)[2] for corner in corners)
        world.set_pose(chassis.row, (0.0, 0.0, lift), quat)
        play(world, chassis, seconds=1.0)
        world.set_velocity(chassis.row, (1.5 * (axis == 0), 1.5 * (axis == 1), 0.0))
        chassis.read()
        play(world, chassis, seconds=0.1)  # the robot rocks for a moment
        before = chassis.vel[axis]
        play(world, chassis, seconds=0.2)
        assert before - chassis.vel[axis] == pytest.approx(0.2 * 0.4 * GRAVITY, rel=0.05)
        play(world, chassis, seconds=1.0)
        stopped = chassis.pos
        play(world, chassis, seconds=2.0)
        assert math.dist(chassis.pos, stopped) < 2e-4


def test_locked_wheels_hold_a_robot_on_a_slope_of_15_degrees():
    """The robot creeps by less than 0.1 mm/s."""
    bench = DriveBench(SwerveDrive(SwerveConfig.square(BASE, HELD)), slope=math.radians(15.0))
    bench.run(1.0)
    before = bench.x
    bench.run(4.0)
    assert abs(bench.x - before) < 4 * 1e-4


def bump(world):
    height, depth = inches(6.513), inches(44.4)
    points = np.array([(x, y, z) for y in (-5.0, 5.0) for x, z in ((-depth / 2, 0.0), (depth / 2, 0.0), (0.0, height))])
    world.add_static("bump", Hull(points), (0.0, 0.0, 0.0), surface=POLYCARBONATE, drivable=True)


@pytest.mark.parametrize("speed", [1.0, 2.0, 3.5])
@pytest.mark.parametrize("heading", [0.0, 0.5])
def test_a_robot_that_coasts_over_a_bump_gains_no_energy(speed, heading):
    with PhysicsWorld() as world:
        bump(world)
        chassis = ChassisSimulation(world, ChassisConfig(), pose=(-2.0, 0.0, heading))
        world.set_velocity(chassis.row, (speed, 0.0, 0.0))
        chassis.read()
        energies = [energy(chassis)]
        play(world, chassis, seconds=4.0 / speed, each=lambda: energies.append(energy(chassis)))
        assert max(energies) < energies[0] * 1.001 + 0.1
        assert min(energies) > 0.1 * energies[0]


def test_a_robot_stands_still_on_the_ridge_of_a_bump():
    with PhysicsWorld() as world:
        bump(world)
        chassis = ChassisSimulation(world, ChassisConfig(), pose=(0.0, 0.0, 0.3))
        play(world, chassis, seconds=2.0)
        before = chassis.pos
        play(world, chassis, seconds=5.0)
        assert math.dist(chassis.pos, before) < 2e-3


@pytest.mark.parametrize("roll", [0.0, 20.0, 80.0, 180.0])
@pytest.mark.parametrize("mass", [8.0, 55.0])
def test_a_falling_robot_gains_no_energy(roll, mass):
    with PhysicsWorld() as world:
        chassis = ChassisSimulation(world, ChassisConfig(mass=mass))
        world.set_pose(chassis.row, (0.0, 0.0, 1.2), from_rpy(math.radians(roll), 0.1, 0.0))
        chassis.read()
        energies = [energy(chassis)]
        play(world, chassis, seconds=3.0, each=lambda: energies.append(energy(chassis)))
        assert max(energies) < 1.0005 * energies[0]
        assert abs(chassis.vel[2]) < 0.01, "it lies, or rolls away"


@pytest.mark.parametrize("mass", [8.0, 60.0])
def test_a_robot_landing_on_a_side_far_from_its_center_of_mass_gains_no_energy(mass):
    """An overturned robot tips about one side at 2 rad/s; the other side has a sixth of its mass."""
    size, wheels = (0.5, 0.97, 0.33), ((0.15, 0.15), (0.15, -0.15), (-0.15, 0.15), (-0.15, -0.15))
    center, inertia = (0.15, 0.0, 0.3), (0.088 * mass, 0.03 * mass, 0.114 * mass)
    with PhysicsWorld() as world:
        config = ChassisConfig(
            mass=mass, bumper_length=size[0], bumper_width=size[1], height=size[2], wheel_positions=wheels
        )
        chassis = ChassisSimulation(world, config, mass=MassDistribution(mass, center, inertia))
        quat = from_rpy(0.0, math.pi - 0.005, 0.0)
        side = rotate(quat, (0.5 * size[0], 0.0, size[2]))
        arm = np.subtract(rotate(quat, center), side)
        world.set_pose(chassis.row, (0.0, 0.0, -side[2]), quat)
        world.set_velocity(chassis.row, (2.0 * arm[2], 0.0, -2.0 * arm[0]), (0.0, 2.0, 0.0))
        chassis.read()
        energies = [energy(chassis)]
        play(world, chassis, seconds=0.3, each=lambda: energies.append(energy(chassis)))
        assert max(energies) < 1.0005 * energies[0]


@pytest.mark.parametrize(("aside", "heading"), [(0.0, 0.0), (0.3, 0.0), (0.2, 0.6)])
def test_colliding_robots_conserve_momentum(aside, heading):
    with PhysicsWorld() as world:
        a = ChassisSimulation(world, ChassisConfig(), pose=(0.0, 0.0, 0.0), name="a")
        b = ChassisSimulation(world, ChassisConfig(mass=40.0), pose=(1.5, aside, heading), name="b")
        world.set_velocity(a.row, (3.0, 0.0, 0.0))
        a.read(), b.read()
        energies = [energy(a) + energy(b)]
        play(world, a, b, seconds=0.6, each=lambda: energies.append(energy(a) + energy(b)))
        momentum = [55.0 * u + 40.0 * v for u, v in zip(a.vel[:2], b.vel[:2], strict=True)]
        assert momentum == pytest.approx([165.0, 0.0], abs=1e-3)
        assert max(energies) < 1.0005 * energies[0]
        assert b.vel[0] > 0.5


def test_a_robot_placed_on_top_of_another_stays_there():
    with PhysicsWorld() as world:
        below = ChassisSimulation(world, ChassisConfig(), name="below")
        above = ChassisSimulation(world, ChassisConfig(), name="above")
        world.set_pose(above.row, (0.05, 0.0, 0.52), (0.0, 0.0, 0.0, 1.0))
        play(world, below, above, seconds=1.0)
        rests = above.pos
        assert rests[2] == pytest.approx(0.5, abs=0.01)
        play(world, below, above, seconds=3.0)
        assert math.dist(above.pos, rests) < 0.01


@pytest.mark.parametrize("speed", [1.0, 3.0])
def test_a_robot_bounces_off_a_wall_with_the_restitution_of_the_pair(speed):
    with PhysicsWorld() as world:
        world.add_static("wall", Box((0.3, 6.0, 1.0)), (1.15, 0.0, 0.5), surface=WALL)
        chassis = ChassisSimulation(world, ChassisConfig())
        world.set_velocity(chassis.row, (speed, 0.0, 0.0))
        chassis.read()
        play(world, chassis, seconds=0.6 / speed + 0.3)
        assert -chassis.vel[0] == pytest.approx(BUMPER.restitution * WALL.restitution * speed, abs=0.03 * speed)


@pytest.mark.parametrize("depth", [0.02, 0.1, 0.2])
@pytest.mark.parametrize("speed", [0.0, 2.0, 4.0])
def test_overlapping_robots_separate_without_gaining_energy(depth, speed):
    """A moving robot bounces as if from outside: momentum holds, energy does not rise, and both soon separate."""
    with PhysicsWorld() as world:
        a = ChassisSimulation(world, ChassisConfig(), pose=(-2.0, 0.0, 0.0), name="a")
        b = ChassisSimulation(world, ChassisConfig(), pose=(2.0, 0.0, 0.0), name="b")
        play(world, a, b, seconds=0.02)
        world.set_velocity(a.row, (speed, 0.0, 0.0))
        world.set_pose(b.row, (a.pos[0] + 0.8 - depth, 0.0, 0.0))
        a.read(), b.read()
        energies = [energy(a) + energy(b)]
        play(world, a, b, seconds=0.1, each=lambda: energies.append(energy(a) + energy(b)))
        assert b.pos[0] - a.pos[0] > 0.8 - 0.003
        assert a.vel[0] + b.vel[0] == pytest.approx(speed, abs=1e-6)
        assert abs(b.vel[0] - a.vel[0]) <= BUMPER.restitution**2 * speed + 0.02
        assert max(energies) < energies[0] + 0.01


def test_a_robot_placed_inside_a_wall_leaves_the_wall():
    with PhysicsWorld() as world:
        world.add_static("wall", Box((0.3, 6.0, 1.0)), (0.5, 0.0, 0.5), surface=WALL)
        chassis = ChassisSimulation(world, ChassisConfig())
        play(world, chassis, seconds=0.1)
        assert chassis.pos[0] < -0.047
        assert abs(chassis.vel[0]) < 0.01
