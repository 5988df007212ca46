"""Drivetrain model on the engine: both use the same forces."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

from simcore.match.motion import Motion
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.chassis_config import ChassisConfig
from simcore.robot.gyro import Gyro, gyro_config
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.swerve_drive import SwerveDrive
from simcore.testing.benches import LoneChassis
from simcore.units import GRAVITY, inches
from simcore.world.contact_law import FRICTIONLESS, POLYCARBONATE, WALL
from simcore.world.shapes import Box, Hull
from simcore.world.world import PhysicsWorld

pytestmark = pytest.mark.engines("bullet")

DT = 0.02
MODULE = SwerveModuleConfig(x=0.0, y=0.0)


@dataclass
class Robot:
    drive: SwerveDrive | None
    chassis: ChassisSimulation


def robot(world, pose=(0.0, 0.0, 0.0), *, name="robot", module=MODULE, chassis=None) -> Robot:
    body = chassis or ChassisConfig()
    modules = tuple(replace(module, x=x, y=y) for x, y in body.wheel_positions)
    config = SwerveConfig(
        modules=modules,
        mass=body.mass,
        yaw_inertia=body.inertia[2],
        center_of_mass=(0.0, 0.0, body.center_of_mass_height),
    )
    drive = SwerveDrive(config)
    return Robot(drive, ChassisSimulation(world, body, pose=pose, drivetrain=drive, name=name))


def advance(world, *robots, ticks=1, each=lambda: None):
    motion = Motion(world, robots=[LoneChassis(r.chassis) for r in robots])
    for _ in range(ticks):
        motion.tick()
        each()


def volts(r: Robot, value: float) -> None:
    r.drive.set_volts([value] * 4, [0.0] * 4)


def test_pushing_a_wall_spins_the_wheels_within_the_friction_circle():
    """12 V give 942 N a wheel and the tires hold 162 N: the wheels spin, the wall bears mu m g, and no robot climbs."""
    with PhysicsWorld() as world:
        world.add_static("wall", Box((0.3, 4.0, 1.0)), (0.75, 0.0, 0.5), surface=WALL)
        r = robot(world)
        volts(r, 12.0)
        advance(world, r, ticks=75)
        start, pushes = r.chassis.pos[0], []

        def look():
            total = np.hypot(*r.drive.wheel_forces.T)
            loads = np.array(r.chassis.normal_loads)
            assert (total <= 1.2 * loads * 1.02 + 0.5).all(), "always inside the circle"
            pushes.append(total.sum())

        advance(world, r, ticks=25, each=look)
        assert abs(r.chassis.pos[0] - start) / 0.5 < 0.05
        assert r.chassis.pos[0] + 0.4 < 0.6 + 0.01
        assert min(r.drive.wheel_speeds()) > 1.0, "they spin, those behind least: the wall pushes above the carpet"
        assert np.mean(pushes) == pytest.approx(1.2 * 55.0 * GRAVITY, rel=0.05)
        assert abs(r.chassis.roll_pitch_yaw[1]) < math.radians(2.0)


def test_pushing_a_wall_stalls_the_motors_at_their_current_limit():
    """40 A are too little to slip: the wheels stand still and each motor draws its limit, 52 W of heat."""
    with PhysicsWorld() as world:
        world.add_static("wall", Box((0.3, 4.0, 1.0)), (0.75, 0.0, 0.5), surface=WALL)
        r = robot(world, module=replace(MODULE, drive_stator_limit=40.0))
        volts(r, 12.0)
        advance(world, r, ticks=100)
        assert np.abs(r.drive.wheel_speeds()).max() < 0.1
        assert np.array(r.drive.drive_motors.current) == pytest.approx(40.0, rel=0.03)
        assert r.drive.supply_current / 4 == pytest.approx(4.37, rel=0.1)


@pytest.mark.parametrize(("treads", "expected"), [((1.2, 1.2), 0.0), ((1.2, 0.9), 0.5 * (1.2 - 0.9) * GRAVITY)])
def test_the_robot_with_more_grip_wins_a_pushing_match(treads, expected):
    """Head-on at 12 V with all wheels slipping: a = (mu1 - mu2) g / 2 at equal masses; with equal treads none moves."""
    with PhysicsWorld() as world:
        a = robot(world, (0.0, 0.0, 0.0), name="a", module=replace(MODULE, wheel_cof=treads[0]))
        b = robot(world, (0.81, 0.0, math.pi), name="b", module=replace(MODULE, wheel_cof=treads[1]))
        volts(a, 12.0)
        volts(b, 12.0)

        def pair():  # a single robot may be rebounding from the other's bumper
            return 0.5 * (a.chassis.vel[0] + b.chassis.vel[0])

        advance(world, a, b, ticks=10)
        speed, place = pair(), (a.chassis.pos[0], b.chassis.pos[0])
        advance(world, a, b, ticks=25)
        if expected == 0.0:  # bumpers rattle by millimeters, so the net motion counts
            for r, start in zip((a, b), place, strict=True):
                assert abs(r.chassis.pos[0] - start) / 0.5 < 0.05
        else:
            assert (pair() - speed) / 0.5 == pytest.approx(expected, rel=0.10)


def hit_of_two_squares(offset: float, speed: float, mass: float, inertia: float) -> tuple[float, float]:
    """Return speed and spin of a square hit flush by an equal square, without friction or bounce.

    The faces touch from y = offset - 0.4 to y = 0.4, relative to the hitter's center. Impulses J at both ends stop the
    approach there; an end that would need to pull has none.
    """
    ends = np.array([offset - 0.4, 0.4])
    arm_a, arm_b = ends, ends - offset
    # approach at an end: (v_a - w_a arm_a) - (v_b - w_b arm_b); J changes the speed by 1/m and arm^2 / I of both
    give = 2.0 / mass + (np.outer(arm_a, arm_a) + np.outer(arm_b, arm_b)) / inertia
    impulse = np.linalg.solve(give, [speed, speed])
    if impulse.min() < 0.0:
        only = int(np.argmax(impulse))
        impulse = np.zeros(2)
        impulse[only] = speed / give[only, only]
    return float(impulse.sum() / mass), float(-(arm_b * impulse).sum() / inertia)


@pytest.mark.parametrize("offset", [0.1, 0.3, 0.5])
def test_a_robot_hit_off_center_turns_as_angular_momentum_requires(offset):
    """Without tires: linear and angular momentum hold within 2 %, spin and speed match the closed form within 5 %."""
    smooth = ChassisConfig(surface=FRICTIONLESS, bumper_friction=0.0)
    with PhysicsWorld() as world:
        a = ChassisSimulation(world, smooth, pose=(0.0, 0.0, 0.0), name="a")
        b = ChassisSimulation(world, smooth, pose=(1.2, offset, 0.0), name="b")
        world.set_velocity(a.row, (3.0, 0.0, 0.0))
        a.read()
        inertia, mass = a.config.inertia[2], a.config.mass

        def momentum():
            total = np.zeros(3)
            for r in (a, b):
                (x, y, _), (vx, vy, _) = r.pos, r.vel
                total += (mass * vx, mass * vy, inertia * r.rate[2] + mass * (x * vy - y * vx))
            return total

        before = momentum()
        advance(world, Robot(None, a), Robot(None, b), ticks=8)
        assert momentum() == pytest.approx(before, rel=0.02, abs=0.5)
        speed, spin = hit_of_two_squares(offset, 3.0, mass, inertia)
        assert b.vel[0] == pytest.approx(speed, rel=0.05)
        assert b.rate[2] == pytest.approx(spin, rel=0.05)


@pytest.mark.parametrize("speed", [1.0, 2.0, 3.0])
def test_a_robot_driven_by_voltage_crosses_the_bump(speed):
    """Wheels in the air spin up and odometry counts their turns; the gyro measures slopes; the robot lands upright."""
    height, depth = inches(6.513), inches(44.4)
    slope = math.degrees(math.atan2(height, depth / 2))
    with PhysicsWorld() as world:
        ends = [(-depth / 2, 0.0), (depth / 2, 0.0), (0.0, height)]
        points = np.array([(x, y, z) for y in (-2.0, 2.0) for x, z in ends])
        world.add_static("bump", Hull(points), (0.0, 0.0, 0.0), surface=POLYCARBONATE, drivable=True)
        r = robot(world, (-2.0, 0.0, 0.0))
        gyro = Gyro(gyro_config("ideal"), np.random.default_rng(0))
        volts(r, 12.0 * speed / 4.747 + 0.1)
        pitches, airborne, fastest_in_air, ground = [], 0, 0.0, []

        def look():
            nonlocal airborne, fastest_in_air
            roll, pitch, yaw = r.chassis.roll_pitch_yaw
            gyro.step(DT, yaw, pitch, roll, r.chassis.robot_rate)
            pitches.append(math.degrees(gyro.pitch))
            ground.append(r.chassis.vel[0])
            loads = np.array(r.chassis.normal_loads)
            in_air = loads == 0.0
            airborne += int(in_air.any())
            if in_air.any():
                fastest_in_air = max(fastest_in_air, float(np.array(r.drive.wheel_speeds())[in_air].max()))

        advance(world, r, ticks=int(5.5 / speed / DT), each=look)
        assert r.chassis.pos[0] > 1.0, "across"
        assert abs(r.chassis.pos[2]) < 0.01, "and down"
        assert min(pitches) == pytest.approx(-slope, abs=6.0)
        assert max(pitches) > 0.5 * slope
        assert airborne > 0, "some wheel lifts"
        assert fastest_in_air > min(ground), "a wheel without load runs ahead of the ground"
        driven = np.mean(r.drive.wheel_distances())
        travelled = r.chassis.pos[0] + 2.0
        assert driven > travelled, "odometry counts the spinning and the way up and down"
        assert r.chassis.vel[0] == pytest.approx(speed, rel=0.1), "drives on"
