"""Mass and inertia of a robot include held pieces and raised mechanisms, at their positions."""

from __future__ import annotations

import math
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

from simcore.match.game import PieceSupply
from simcore.match.match import Match
from simcore.match.motion import Motion
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.launch import LaunchParameters
from simcore.robot.battery import BatteryConfig
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.chassis_config import ChassisConfig, MassDistribution, MovingMass
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.intake import IntakeConfig, IntakeZone
from simcore.robot.mechanisms import ElevatorConfig, FlywheelConfig
from simcore.robot.robot_config import RobotConfig
from simcore.robot.shooter import ShooterConfig
from simcore.robot.storage import StorageConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.swerve_drive import SwerveDrive
from simcore.testing.benches import LoneChassis
from simcore.typing import FloatArray
from simcore.units import GRAVITY, TICK
from simcore.world.linkage import Joint
from simcore.world.shapes import Sphere
from simcore.world.world import PhysicsWorld

pytestmark = pytest.mark.engines("bullet")

BALL = GamePieceConfig(name="Ball", shape=Sphere(0.1), mass=2.0)
FUEL = GamePieceConfig(name="Fuel", shape=Sphere(0.075), mass=0.215)
GEARBOX = GearboxConfig(motor=motor("Kraken X60"), gearing=50.0)
FREE = SwerveModuleConfig(
    x=0.0, y=0.0, rolling_resistance=0.0, drive_friction_volts=0.0, drive_efficiency=1.0, drive_supply_limit=math.inf
)
"""Module without losses: the force at the tread is the motor's, less the inertia of the wheels."""
SLIDING = replace(FREE, wheel_cof=0.0)
MASS, BASE = 55.0, 0.5
CARRIAGE, DRUM = 12.0, 0.05
LIFT = Joint(mechanism="lift", axis=(0.0, 0.0, 1.0), origin=(0.0, 0.0, 0.2), slides=True, ratio=DRUM)
SWING = Joint(mechanism="arm", axis=(0.0, 0.0, 1.0), origin=(0.0, 0.0, 0.2))
MECHANISMS = {
    "lift": ElevatorConfig(gearbox=GEARBOX, carriage_mass=CARRIAGE, drum_radius=DRUM, max_height=2.5, gravity=0.0),
    "wheels": FlywheelConfig(gearbox=replace(GEARBOX, gearing=1.5), inertia=10.0),
}


def robot(module: SwerveModuleConfig, **more) -> RobotConfig:
    return RobotConfig(
        drivetrain=SwerveConfig.square(BASE, module, mass=MASS),
        battery=BatteryConfig(resistance=0.0),
        mechanisms=MECHANISMS,
        moving_masses=(MovingMass(name="carriage", mass=CARRIAGE, joints=(LIFT,)),),
        **more,
    )


def raise_lift(match: Match, height: float) -> None:
    one = match.robots[0]
    one.mechanisms["lift"].reset(height / DRUM)
    match.tick()
    assert one.chassis.distribution.center[2] == pytest.approx(0.2 + CARRIAGE * height / MASS, abs=0.002)


def push(match: Match, vx: float, omega: float = 0.0) -> None:
    """Set the velocity of the robot."""
    chassis = match.robots[0].chassis
    match.world.set_velocity(chassis.row, (vx, 0.0, 0.0), (0.0, 0.0, omega))
    chassis.read()


def accelerate(match: Match, amps: float) -> tuple[float, FloatArray]:
    """Drive at a stator current; return mean acceleration [m/s^2] and wheel loads [N] over 0.3 s."""
    one = match.robots[0]
    one.drive.set_volts([12.0] * 4, [0.0] * 4)
    match.play(5 * TICK)
    before = one.chassis.vel[0]
    loads = []
    for _ in range(15):
        match.tick()
        loads.append(one.drive.normal_loads)
    assert one.drive.motor_currents()["drive"] == pytest.approx([amps] * 4, rel=1e-3)
    return (one.chassis.vel[0] - before) / (15 * TICK), np.mean(loads, axis=0)


def test_fifty_fuel_in_the_hopper_slow_the_acceleration():
    """At equal current a falls by M / (M + m) within 1 %; M includes the inertia of wheels and rotors over r^2."""
    module = replace(FREE, drive_stator_limit=20.0)
    found = []
    for count in (0, 50):
        with Match.bare(robot(module, storage=StorageConfig(capacity=50)), pieces=(PieceSupply(FUEL, 60),)) as match:
            one = match.robots[0]
            for number in range(count):
                match.pieces.spawn("Fuel", (4.0 + 0.2 * (number % 10), 5.0 + 0.2 * (number // 10), 0.075))
            slots = match.pieces.on_field("Fuel")
            match.pieces.hold(slots, 0)
            one.storage.add(slots.tolist())
            match.tick()
            assert one.chassis.distribution.mass == pytest.approx(MASS + 0.215 * count)
            found.append(accelerate(match, 20.0)[0])
    inert = MASS + 4.0 * FREE.drive_inertia / FREE.wheel_radius**2
    assert found[1] / found[0] == pytest.approx(inert / (inert + 50 * 0.215), rel=0.01)


@pytest.mark.parametrize("height", (0.0, 2.0))
def test_a_raised_elevator_moves_load_to_the_rear_wheels(height):
    """m a h / L moves from the front axle to the rear axle, within 2 %."""
    with Match.bare(robot(replace(FREE, drive_stator_limit=15.0))) as match:
        raise_lift(match, height)
        accel, loads = accelerate(match, 15.0)
        front, rear = loads[:2].sum(), loads[2:].sum()
        h = 0.2 + CARRIAGE * height / MASS
        assert front + rear == pytest.approx(MASS * GRAVITY, rel=0.01)
        assert (rear - front) / 2.0 == pytest.approx(MASS * accel * h / BASE, rel=0.02)
        assert (rear - front) / 2.0 > 40.0


@pytest.mark.parametrize("share", [0.8, 1.05])
def test_a_robot_with_a_raised_elevator_tips_at_the_static_limit(share):
    """Sliding tires brake with mu g. The rear wheels lift just above g b / (2 h) and stay down just below it."""
    height = 2.5
    tipping = BASE / 2.0 / (0.2 + CARRIAGE * height / MASS)  # [g]
    with Match.bare(robot(replace(FREE, wheel_cof=share * tipping))) as match:
        one = match.robots[0]
        raise_lift(match, height)
        match.play(0.2)
        push(match, 3.5)
        one.drive.set_volts([-12.0] * 4, [0.0] * 4)
        pitch = []
        while one.chassis.vel[0] > 0.5:
            match.tick()
            pitch.append(math.degrees(one.chassis.roll_pitch_yaw[1]))
        assert len(pitch) > 30
        assert max(pitch) > 1.0 if share > 1.0 else max(map(abs, pitch)) < 0.2


def test_taking_in_a_piece_at_rest_slows_the_robot():
    """Momentum is conserved: v M / (M + m); energy does not grow."""
    zone = IntakeZone(x_min=0.45, x_max=0.75, y_min=-0.3, y_max=0.3, z_max=0.4)
    config = robot(SLIDING, intakes=(IntakeConfig(zone=zone),), storage=StorageConfig(capacity=2))
    with Match.bare(config, pieces=(PieceSupply(BALL, 1),)) as match:
        one = match.robots[0]
        match.pieces.spawn("Ball", (3.5, 2.0, 0.1))
        match.play(0.1)
        push(match, 1.0)
        match.play(0.3)
        assert one.chassis.vel[0] == pytest.approx(1.0, abs=1e-6) and not one.held
        match.play(0.7)
        assert one.held
        assert one.chassis.vel[0] == pytest.approx(MASS / (MASS + 2.0), rel=1e-3)


@contextmanager
def shot_from_rest(launch: LaunchParameters):
    """Shoot the only ball of a robot at rest; yield the robot one tick later, and the ball's speed along x [m/s]."""
    shooter = ShooterConfig(
        wheels=("wheels",), wheel_radius=0.1, exit_efficiency=0.5, elevation=0.5, shot_rate=4.0, min_wheel_speed=50.0,
        launch=launch,
    )  # fmt: skip
    config = robot(SLIDING, shooters=(shooter,), storage=StorageConfig(capacity=1))
    with Match.bare(config, pieces=(PieceSupply(BALL, 1),)) as match:
        one = match.robots[0]
        match.pieces.spawn("Ball", (8.0, 2.0, 0.1))
        slots = match.pieces.on_field("Ball")
        match.pieces.hold(slots, 0)
        one.storage.add(slots.tolist())
        match.play(0.1)
        one.mechanisms["wheels"].velocity = 120.0
        while one.held:
            match.tick()
        speed = float(match.pieces.state.vel[slots[0], 0])
        match.tick()
        yield one, speed


def test_the_recoil_of_a_shot_pushes_the_robot():
    """The total momentum of robot and piece stays 0."""
    with shot_from_rest(LaunchParameters(height=0.6)) as (one, speed):
        assert speed > 4.0
        assert MASS * one.chassis.vel[0] == pytest.approx(-2.0 * speed, rel=0.01)


@pytest.mark.parametrize("aside", [0.25, -0.25])
def test_an_off_center_shot_turns_the_robot(aside):
    """Angular momentum stays 0: I omega = aside m v.

    The 2 kg ball was held in the middle and leaves at the muzzle, so the center of the rest is 9 mm to the side.
    """
    with shot_from_rest(LaunchParameters(height=0.6, pivot_y=aside)) as (one, speed):
        inertia = one.chassis.distribution.inertia[2]
        assert inertia * one.chassis.robot_rate[2] == pytest.approx(aside * 2.0 * speed, rel=0.08)


def test_extending_an_arm_slows_the_rotation():
    """I omega is constant on wheels without grip, and energy falls; the arm extends to both sides along x."""
    out = [
        Joint(mechanism="lift", axis=(sign, 0.0, 0.0), origin=(0.0, 0.0, 0.2), slides=True, ratio=DRUM)
        for sign in (1.0, -1.0)
    ]
    parts = tuple(MovingMass(name=f"arm {n}", mass=5.0, joints=(joint,)) for n, joint in enumerate(out))
    with Match.bare(replace(robot(SLIDING), moving_masses=parts), start=(4.0, 4.0, 0.0)) as match:
        one = match.robots[0]
        push(match, 0.0, 2.0)
        match.play(0.1)
        inertia = one.chassis.distribution.inertia[2]
        one.mechanisms["lift"].reset(0.5 / DRUM)
        match.play(0.1)
        assert one.chassis.distribution.inertia[2] == pytest.approx(inertia + 10.0 * 0.25)
        assert one.chassis.rate[2] == pytest.approx(2.0 * inertia / (inertia + 2.5), rel=1e-3)


def test_releasing_a_carried_piece_changes_no_velocity_of_the_robot():
    """The piece leaves with the velocity of its place, so no force acts on the robot."""
    with Match.bare(robot(SLIDING, storage=StorageConfig(capacity=1)), pieces=(PieceSupply(BALL, 1),)) as match:
        one = match.robots[0]
        match.pieces.spawn("Ball", (8.0, 2.0, 0.1))
        slots = match.pieces.on_field("Ball")
        match.pieces.hold(slots, 0)
        one.storage.add(slots.tolist())
        match.tick()
        push(match, 1.0, 3.0)
        match.tick()
        one.storage.pieces.clear()
        before, rate = one.chassis.origin_velocity, one.chassis.rate[2]
        one.balance.update(match.pieces.mass, match.pieces.radius)
        assert one.chassis.distribution.mass == MASS
        assert one.chassis.origin_velocity == pytest.approx(before, abs=1e-9)
        assert one.chassis.rate[2] == pytest.approx(rate, rel=1e-3)


@pytest.mark.parametrize("lift", (0.0, 1e-6, 800.0))
def test_a_free_robot_turns_about_its_center_of_mass(lift):
    """The origin circles the center of mass whether the loop or the engine integrates the robot, and in the air.

    p(t) = c(t) - R(w t) r, within 2 mm and 1 mrad.
    """
    offset, speed, rate = (-0.1, 0.04), 0.5, 2.0
    with PhysicsWorld() as world:
        mass = MassDistribution(MASS, (*offset, 0.2), (3.0, 3.0, 5.0))
        chassis = ChassisSimulation(world, ChassisConfig(), pose=(4.0, 4.0, 0.0), mass=mass)
        world.set_velocity(chassis.row, (speed, 0.0, 0.0), (0.0, 0.0, rate))
        chassis.read()
        chassis.apply_forces((0.0, 0.0, lift))
        motion = Motion(world, robots=[LoneChassis(chassis)])
        for tick in range(1, 76):
            motion.tick()
            t = tick * TICK
            c, s = math.cos(rate * t), math.sin(rate * t)
            x = 4.0 + offset[0] + speed * t - c * offset[0] + s * offset[1]
            y = 4.0 + offset[1] - s * offset[0] - c * offset[1]
            assert chassis.pose[:2] == pytest.approx((x, y), abs=2e-3)
            assert math.remainder(chassis.pose[2] - rate * t, math.tau) == pytest.approx(0.0, abs=1e-3)
        assert (chassis.pos[2] > 1.0) is (lift > 1.0)


def test_gripping_tires_turn_a_robot_about_its_wheel_center_wherever_its_mass_is():
    """The tires supply m w^2 r, so the middle stays in place; with prescribed velocities it stays as well."""
    ways = []
    for config in (None, robot(FREE)):
        with PhysicsWorld() as world:
            mass = MassDistribution(MASS, (-0.1, 0.04, 0.2), (3.0, 3.0, 5.0))
            drive = None if config is None else SwerveDrive(config.drivetrain)
            chassis = ChassisSimulation(world, ChassisConfig(), pose=(4.0, 4.0, 0.0), mass=mass, drivetrain=drive)
            lone = LoneChassis(chassis)
            motion = Motion(world, robots=[lone])
            for _ in range(100):
                if drive is None:
                    lone.follow(0.0, 0.0, 2.0)
                else:
                    drive.set_chassis_speeds(0.0, 0.0, 2.0)
                motion.tick()
                ways.append(math.dist(chassis.pose[:2], (4.0, 4.0)))
            assert chassis.rate[2] == pytest.approx(2.0, rel=0.03)
            assert math.hypot(*chassis.vel) == pytest.approx(chassis.rate[2] * math.hypot(0.1, 0.04), rel=0.02)
    assert max(ways) < 0.02
