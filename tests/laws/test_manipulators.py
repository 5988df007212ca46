"""Intakes, placers, storage and shooters of a robot in a match on the engine, on an empty carpet."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from simcore.errors import ConfigError, UnknownNameError
from simcore.match.game import Game, PieceSupply, RobotEntry
from simcore.match.match import Match
from simcore.match.motion import Motion
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.launch import LaunchParameters
from simcore.pieces.piece_manager import Footprint, GamePieceManager
from simcore.pieces.pool import PieceStatus
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.intake import IntakeConfig, IntakeZone
from simcore.robot.mechanisms import ArmConfig, FlywheelConfig, RollerConfig
from simcore.robot.placer import PlacerConfig
from simcore.robot.robot_config import RobotConfig
from simcore.robot.shooter import ShooterConfig
from simcore.robot.storage import StorageConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.units import GRAVITY, TICK
from simcore.world.contact_law import WALL
from simcore.world.field import FieldElement
from simcore.world.linkage import Joint
from simcore.world.rotation import rpy
from simcore.world.shapes import Box, Sphere
from simcore.world.world import PhysicsWorld

DT, RADIUS = 0.02, 0.1
BALL = GamePieceConfig(name="Ball", shape=Sphere(RADIUS), mass=0.2)
CRATE = GamePieceConfig(name="Crate", shape=Box((0.3, 0.3, 0.2)), mass=1.0)
GEARBOX = GearboxConfig(motor=motor("Kraken X60"), gearing=50.0)
ARM = Joint(mechanism="arm", axis=(0.0, -1.0, 0.0), origin=(0.0, 0.0, 0.6))
ZONE = IntakeZone(x_min=0.45, x_max=0.65, y_min=-0.3, y_max=0.3, z_max=0.4)


def robot() -> RobotConfig:
    return RobotConfig(
        drivetrain=SwerveConfig.square(0.5, SwerveModuleConfig(x=0.0, y=0.0)),
        mechanisms={
            "arm": ArmConfig(gearbox=GEARBOX, inertia=0.5, min_angle=-1.0, max_angle=1.4, start_angle=0.2),
            "claw": RollerConfig(gearbox=replace(GEARBOX, gearing=8.0), inertia=0.002, radius=0.03),
            "wheels": FlywheelConfig(gearbox=replace(GEARBOX, gearing=1.5), inertia=10.0),
        },
        intakes=(IntakeConfig(zone=ZONE, kinds=("Ball",)),),
        storage=StorageConfig(capacity=2),
        shooters=(
            ShooterConfig(
                wheels=("wheels",), wheel_radius=0.1, exit_efficiency=0.5, elevation=1.0, shot_rate=4.0,
                launch=LaunchParameters(height=0.6), min_wheel_speed=100.0),
        ),
        placers=(
            PlacerConfig(
                joints=(ARM,), offset=(0.8, 0.0, 0.0), roller="claw", kinds=("Crate",),
                zone=IntakeZone(x_min=0.7, x_max=0.9, y_min=-0.1, y_max=0.1, z_max=0.1)),
        ),
    )  # fmt: skip


@pytest.fixture
def bare():
    game = Game.bare(pieces=(PieceSupply(BALL, 6), PieceSupply(CRATE, 2)), robot=robot)
    with Match(game, robots=(RobotEntry(start=(4.0, 4.0, 0.0)),)) as match:
        yield match


# --- intake ---------------------------------------------------------------------------------------------------------


def test_a_piece_that_crosses_the_intake_zone_between_two_ticks_is_taken(bare):
    """At 40 m/s a ball moves 0.8 m a tick, sideways through a zone 0.6 m wide in front of the robot.

    Starts are 0.2 m apart, so for at least one of the four no tick ends with the ball in the zone.
    """
    for offset in (0.0, 0.2, 0.4, 0.6):
        slot = bare.pieces.spawn("Ball", np.array([[4.55, 1.0 + offset, RADIUS]]))
        bare.pieces.push(slot, np.array([[0.0, 40.0, 0.0]]))
        for _ in range(6):
            bare.tick()
        assert bare.pieces.state.status[slot[0]] == PieceStatus.HELD
        bare.robots[0].storage.discard(int(slot[0]))


def test_a_piece_in_flight_is_not_taken_until_it_touches_something(bare):
    slot = bare.pieces.spawn("Ball", np.array([[4.55, 4.0, 0.35]]))
    bare.pieces.push(slot, np.array([[0.0, 0.0, 0.0]]), flying=True)
    bare.tick()
    assert bare.pieces.state.status[slot[0]] == PieceStatus.IN_FLIGHT
    bare.tick()
    assert bare.pieces.state.status[slot[0]] != PieceStatus.HELD, "in the zone, and flying"
    for _ in range(25):
        bare.tick()
    assert bare.pieces.state.status[slot[0]] == PieceStatus.HELD


def test_an_intake_takes_no_more_pieces_than_there_is_room_for(bare):
    """Three pieces are in the zone at once, with room for two."""
    slots = bare.pieces.spawn("Ball", np.array([[4.55, y, RADIUS] for y in (3.75, 4.0, 4.25)]))
    bare.play(0.2)
    assert (bare.pieces.state.status[slots] == PieceStatus.HELD).sum() == 2 == len(bare.robots[0].held)
    assert bare.robots[0].storage.room == 0 and bare.count.is_conserved
    bare.play(0.2)
    assert len(bare.robots[0].held) == 2


def test_an_intake_ignores_other_kinds_of_pieces(bare):
    bare.pieces.spawn("Crate", np.array([[4.6, 4.0, 0.1]]))
    bare.play(0.2)
    assert bare.robots[0].held == []


def test_every_intake_and_every_shooter_uses_its_own_storage():
    """Two balls in front and one behind; then only the wheels of the back shooter turn."""
    both = robot()
    back = replace(ZONE, x_min=-0.65, x_max=-0.45)
    shooter = both.shooters[0]
    both = replace(
        both,
        more_storages=(StorageConfig(name="back", capacity=3),),
        mechanisms={**both.mechanisms, "back wheels": both.mechanisms["wheels"]},
        intakes=(*both.intakes, IntakeConfig(zone=back, storage="back")),
        shooters=(shooter, replace(shooter, wheels=("back wheels",), storage="back")),
    )
    game = Game.bare(pieces=(PieceSupply(BALL, 6), PieceSupply(CRATE, 2)), robot=lambda: both)
    with Match(game, robots=(RobotEntry(start=(4.0, 4.0, 0.0)),)) as match:
        one = match.robots[0]
        front = match.pieces.spawn("Ball", np.array([[4.55, y, RADIUS] for y in (3.8, 4.1)])).tolist()
        behind = match.pieces.spawn("Ball", np.array([[3.45, 4.0, RADIUS]])).tolist()
        match.play(0.1)
        assert [storage.pieces for storage in one.storages] == [front, behind] and one.held == front + behind
        one.mechanisms["back wheels"].reset(velocity=200.0)
        match.play(0.1)
        assert [shot.slot for shot in match.record.shots] == behind and one.held == front
        assert match.count.is_conserved
    with pytest.raises(UnknownNameError, match="no storage \\(of intake\\) named 'bakc'"):
        replace(both, intakes=(IntakeConfig(zone=back, storage="bakc"),))
    with pytest.raises(ConfigError, match="storages need unique names"):
        replace(both, more_storages=(StorageConfig(),))


def test_an_intake_with_a_reversed_roller_is_active_while_the_roller_turns_backward():
    config = robot()
    config = replace(config, intakes=(replace(config.intakes[0], roller="claw", roller_reversed=True),))
    with Match(Game.bare(pieces=(PieceSupply(BALL, 1),), robot=lambda: config)) as match:
        intake, claw = match.robots[0].intakes[0], match.robots[0].mechanisms["claw"]
        for velocity, is_active in ((20.0, False), (-20.0, True)):
            claw.velocity = velocity
            assert intake.is_active is is_active


# --- placer ---------------------------------------------------------------------------------------------------------


def test_a_pass_through_placer_releases_its_piece_when_its_roller_restarts_forward():
    """The placer does not release a piece while taking it in, nor take it in while releasing it."""
    config = robot()
    (placer,) = config.placers
    config = replace(config, placers=(replace(placer, passes_through=True, take_speed=5.0, release_speed=5.0),))
    game = Game.bare(pieces=(PieceSupply(CRATE, 1),), robot=lambda: config)
    with Match(game, robots=(RobotEntry(start=(4.0, 4.0, 0.0)),)) as match:
        one = match.robots[0]
        place = [[4.0 + 0.8 * math.cos(0.2), 4.0, 0.6 + 0.8 * math.sin(0.2)]]
        slot = int(match.pieces.spawn("Crate", np.array(place))[0])
        for velocity, held in ((20.0, [slot]), (20.0, [slot]), (0.0, [slot]), (20.0, []), (20.0, []), (0.0, [])):
            one.mechanisms["claw"].reset(velocity=velocity)
            one.mechanisms["claw"].coast()
            match.tick()
            assert one.held == held, velocity
        assert match.count.is_conserved


def test_a_released_piece_has_the_velocity_and_attitude_of_the_gripper(bare):
    """v of the robot + omega x r + joint speed x lever arm, within gravity's change; the crate keeps its attitude."""
    one = bare.robots[0]
    slot = int(bare.pieces.spawn("Crate", np.array([[4.0 + 0.8 * math.cos(0.2), 4.0, 0.6 + 0.8 * math.sin(0.2)]]))[0])
    one.mechanisms["claw"].velocity = 20.0
    bare.tick()
    assert one.held == [slot] and one.placers[0].piece == slot
    one.mechanisms["claw"].velocity = 0.0
    for _ in range(40):
        one.drive.set_chassis_speeds(1.0, 0.3, 1.0)
        one.mechanisms["arm"].set_volts(1.0)
        bare.tick()
    shown = bare.snapshot().pose_arrays["Sim/Held/Crate"][0]
    one.mechanisms["claw"].velocity = -40.0
    one.mechanisms["claw"].set_volts(-12.0)
    bare.tick()
    assert one.held == [] and bare.pieces.state.status[slot] == PieceStatus.AWAKE
    state = one.part_in_field(one.placers[0].held_state())
    c = one.chassis
    assert np.linalg.norm(np.array(state.pos) - shown[:3]) < 0.06
    arm = one.mechanisms["arm"]
    yaw, angle, w = c.pose[2], arm.position, arm.velocity
    assert abs(w) > 0.5 and abs(c.rate[2]) > 0.5
    level, up = 0.8 * math.cos(angle), 0.8 * math.sin(angle)
    radial = -w * up
    expected = (
        c.origin_velocity[0] + (radial * math.cos(yaw)) - c.rate[2] * level * math.sin(yaw),
        c.origin_velocity[1] + (radial * math.sin(yaw)) + c.rate[2] * level * math.cos(yaw),
        w * level,
    )
    assert bare.pieces.state.vel[slot] == pytest.approx(expected, abs=0.02)
    w0, x, y, z = bare.pieces.attitudes(np.array([slot]))[0]
    assert rpy((x, y, z, w0)) == pytest.approx((0.0, -angle, yaw), abs=0.03)
    bare.tick()
    assert bare.pieces.state.vel[slot, 2] == pytest.approx(expected[2] - GRAVITY * DT, abs=0.15)
    assert bare.count.is_conserved


def test_a_full_placer_takes_no_second_piece(bare):
    one = bare.robots[0]
    place = np.array([[4.0 + 0.8 * math.cos(0.2), 4.0, 0.6 + 0.8 * math.sin(0.2)]])
    first = bare.pieces.spawn("Crate", place)
    one.mechanisms["claw"].velocity = 20.0
    bare.tick()
    bare.pieces.spawn("Crate", place)
    one.mechanisms["claw"].velocity = 20.0
    bare.tick()
    assert one.held == first.tolist() and bare.count.held == 1


# --- shooter --------------------------------------------------------------------------------------------------------


def test_a_shot_fired_mid_tick_flies_only_for_the_rest_of_the_tick(bare):
    """Shots 0.25 s apart leave 0 or 10 ms into a tick; both are on the parabola from the muzzle."""
    one = bare.robots[0]
    bare.pieces.hold(slots := bare.pieces.stage("Ball", 2), 0)
    one.storage.add(slots.tolist())
    for _ in range(14):
        one.mechanisms["wheels"].velocity = 160.0
        bare.tick()
    assert len(bare.record.shots) == 2
    up = 160.0 * 0.1 * 0.5 * math.sin(1.0)
    muzzle = one.chassis.pos[2] + 0.6
    for shot, flown in zip(bare.record.shots, (0.02, 0.01), strict=True):
        height = muzzle + up * flown - 0.5 * GRAVITY * flown**2
        assert shot.points[0][2] == pytest.approx(height, abs=0.02 * up * flown + 0.002)


def test_a_sleeping_piece_wakes_before_a_robot_reaches_it():
    """A robot that creeps up to a crate wakes it before they touch; a crate far away stays asleep."""
    with PhysicsWorld() as world:
        pieces = GamePieceManager(world, [(CRATE, 2)], field_size=(16.0, 8.0))
        near, far = pieces.spawn("Crate", np.array([[5.60, 4.0, 0.1], [12.0, 4.0, 0.1]])).tolist()
        motion = Motion(world, pieces=pieces)
        for x in (4.90, 4.95, 4.97, 4.99, 5.0):
            motion.tick(others=[Footprint(x=x, y=4.0, yaw=0.0, half_length=0.4, half_width=0.4, speed=1.0)])
            gap = 5.60 - CRATE.bounding_radius - x - 0.4
            assert (pieces.state.status[near] == PieceStatus.AWAKE) == (gap < 0.05 + 1.0 * TICK)
        assert pieces.state.status[far] == PieceStatus.ASLEEP


def crate_before_post(aside: float) -> tuple[Game, np.ndarray]:
    """Return a game with a post at the height of the claw, and the position of a crate in the claw.

    The robot is at (4, 4, 0).

    Args:
        aside: Offset of the post from the crate, to the left [m].
    """
    game = Game.bare(pieces=(PieceSupply(CRATE, 1),), robot=robot)
    at = np.array([4.0 + 0.8 * math.cos(0.2), 4.0, 0.6 + 0.8 * math.sin(0.2)])
    post = FieldElement(
        name="post", shape=Box((0.1, 0.1, 0.5)), position=at + np.array([0.0, aside, 0.0]), surface=WALL
    )
    return replace(game, field=replace(game.field, elements=(*game.field.elements, post))), at


def test_a_placer_keeps_a_piece_inside_a_wall_and_releases_it_outside():
    game, at = crate_before_post(0.15)
    with Match(game, robots=(RobotEntry(start=(4.0, 3.7, 0.0)),)) as match:
        one = match.robots[0]
        slot = int(match.pieces.spawn("Crate", at[None] - np.array([0.0, 0.3, 0.0]))[0])
        one.mechanisms["claw"].velocity = 20.0
        match.tick()
        assert one.held == [slot]
        for y, held in ((4.0, [slot]), (3.8, [])):
            one.carry_to((4.0, y, 0.0))
            one.mechanisms["claw"].velocity = -40.0
            one.mechanisms["claw"].set_volts(-12.0)
            match.tick()
            assert one.held == held
        assert match.count.is_conserved
