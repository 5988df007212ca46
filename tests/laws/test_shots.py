"""Shots of robots that move, stand at a wall, lie upside down or touch another robot."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from simcore.match.game import Game, PieceSupply, RobotEntry
from simcore.match.match import Match
from simcore.match.scoring import ScoreEvent
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.launch import LaunchParameters
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import FlywheelConfig
from simcore.robot.robot_config import RobotConfig
from simcore.robot.shooter import ShooterConfig
from simcore.robot.storage import StorageConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.units import GRAVITY, TICK
from simcore.world.field import box_element
from simcore.world.rotation import IDENTITY, from_rpy, rotate
from simcore.world.shapes import Cylinder, Sphere

pytestmark = pytest.mark.engines("bullet")

RADIUS = 0.075
BALL = GamePieceConfig(name="Ball", shape=Sphere(RADIUS), mass=0.2)
GEARBOX = GearboxConfig(motor=motor("Kraken X60"), gearing=1.5)
WHEEL_RADIUS, RATE = 0.05, 7.3
"""Shots are 137 ms apart, so each leaves at a different instant of its tick."""


def robot(*, forward=0.3, height=0.6, elevation=0.9, turret=False) -> RobotConfig:
    return RobotConfig(
        drivetrain=SwerveConfig.square(0.5, SwerveModuleConfig(x=0.0, y=0.0)),
        mechanisms={
            "wheels": FlywheelConfig(gearbox=GEARBOX, inertia=1e3),
            "turret": FlywheelConfig(gearbox=GEARBOX, inertia=1.0),
        },
        storage=StorageConfig(capacity=60),
        shooters=(
            ShooterConfig(
                wheels=("wheels",), wheel_radius=WHEEL_RADIUS, exit_efficiency=0.5, elevation=elevation,
                shot_rate=RATE, launch=LaunchParameters(height=height, forward=forward), min_wheel_speed=10.0,
                turret="turret" if turret else None),
        ),
    )  # fmt: skip


def match_with(config, *starts, elements=(), count=60, kind=BALL):
    game = Game.bare(pieces=(PieceSupply(kind, count),), robot=lambda: config, elements=elements)
    match = Match(game, robots=[RobotEntry(start=start) for start in starts])
    slots = match.pieces.stage(kind.name, count)
    match.pieces.hold(slots, 0)
    match.robots[0].storage.add(slots.tolist())
    return match


def spin_wheels(match, exit_speed) -> None:
    wheels = match.robots[0].mechanisms["wheels"]
    wheels.velocity = 2.0 * exit_speed / WHEEL_RADIUS
    wheels.coast()


def tick_and_find(match):
    """Advance one tick; return position and velocity at its end for each shot that it fired."""
    before = len(match.record.shots)
    match.tick()
    state = match.pieces.state
    return [(state.pos[shot.slot].copy(), state.vel[shot.slot].copy()) for shot in match.record.shots[before:]]


def traced_back(pos, velocity, chassis, muzzle):
    """Trace a shot back to the path of the muzzle; return time [s], gap [m], relative speed [m/s], heading [rad].

    Within a tick the robot moves uniformly, r(-t) = r - v t and yaw(-t) = yaw - w t; the shot follows its parabola.
    """
    (x, y, z), (vx, vy, _), w, yaw = chassis.pos, chassis.origin_velocity, chassis.rate[2], chassis.pose[2]

    def gap(t):
        c, s = math.cos(yaw - w * t), math.sin(yaw - w * t)
        at = np.array([x - vx * t + c * muzzle[0], y - vy * t + s * muzzle[0], z + muzzle[1]])
        return pos - velocity * t - (0.0, 0.0, 0.5 * GRAVITY * t * t) - at

    found = minimize_scalar(lambda t: float(np.linalg.norm(gap(t))), bounds=(-0.01, 0.03), method="bounded")
    t = float(found.x)
    arm = np.array([math.cos(yaw - w * t), math.sin(yaw - w * t)]) * muzzle[0]
    relative = velocity - np.array([vx - w * arm[1], vy + w * arm[0], -GRAVITY * t])
    turned = math.atan2(relative[1], relative[0]) - (yaw - w * t)
    return t, float(found.fun), float(np.linalg.norm(relative)), math.remainder(turned, math.tau)


@pytest.mark.parametrize("speeds", [(2.0, 0.0, 0.0), (0.0, 0.0, 4.0), (1.5, 0.0, 4.0), (-1.0, 1.5, -3.0)])
def test_a_shot_of_a_moving_robot_leaves_the_muzzle_at_its_scheduled_time(speeds):
    """Traced back, each shot meets the muzzle's path within 1 mm, with the direction and speed of the shooter.

    This holds at any part of a tick, and shots are one period apart.
    """
    with match_with(robot(), (4.0, 3.0, 0.0)) as match:
        one, shots = match.robots[0], []
        for tick in range(150):
            heading = one.chassis.pose[2]
            c, s = math.cos(heading), math.sin(heading)
            one.drive.set_chassis_speeds(
                c * speeds[0] + s * speeds[1], c * speeds[1] - s * speeds[0], speeds[2]
            )  # along one line of the field while turning
            if tick >= 50:
                spin_wheels(match, 9.0)
            for pos, velocity in tick_and_find(match):
                t, gap, speed, turned = traced_back(pos, velocity, one.chassis, (0.3, 0.6))
                assert gap < 0.001
                assert speed == pytest.approx(9.0, abs=0.03)
                assert turned == pytest.approx(0.0, abs=math.radians(0.3))
                shots.append((match.time - t, t))
    times, flown = np.array(shots).T
    assert len(times) == 15
    assert np.ptp(flown) > 0.015, "shots from all over the tick"
    assert np.diff(times) == pytest.approx(1.0 / RATE, abs=1e-4)


def test_a_turret_that_counters_the_robots_rotation_shoots_in_one_direction():
    """Robot at +4 rad/s, turret at -4 rad/s about the robot center: muzzle and direction are fixed in the field."""
    with match_with(robot(turret=True), (8.0, 4.0, 0.0)) as match:
        one, turret, headings = match.robots[0], match.robots[0].mechanisms["turret"], []
        for tick in range(150):
            one.drive.set_chassis_speeds(0.0, 0.0, 4.0)
            turret.position, turret.velocity = -one.chassis.pose[2], -one.chassis.rate[2]
            turret.coast()
            if tick >= 50:
                spin_wheels(match, 9.0)
            headings += [math.atan2(velocity[1], velocity[0]) for _, velocity in tick_and_find(match)]
        assert len(headings) == 15
        assert headings == pytest.approx([0.0] * 15, abs=math.radians(0.3))


@pytest.mark.parametrize(("attitude", "along"), [(from_rpy(0.0, 0.5 * math.pi, 0.0), 1.0), (IDENTITY, 0.0)])
def test_a_piece_other_than_a_ball_leaves_with_the_attitude_of_the_muzzle(attitude, along):
    """A tube stored along the robot leaves along its velocity, an upright one across it; both at 40 degrees."""
    tube = GamePieceConfig(name="Tube", shape=Cylinder(0.05, 0.2), mass=0.3)
    config = replace(robot(elevation=0.7), storage=StorageConfig(capacity=60, attitude=attitude))
    with match_with(config, (8.0, 4.0, 1.1), kind=tube, count=1) as match:
        spin_wheels(match, 9.0)
        ((_, velocity),) = tick_and_find(match)
        ((w, x, y, z),) = match.pieces.attitudes(np.array([0])).tolist()
    axis = rotate((x, y, z, w), (0.0, 0.0, 1.0))
    # within the tick gravity turns the velocity by g dt cos 40 deg / v = 1 degree
    assert np.dot(axis, velocity) / np.linalg.norm(velocity) == pytest.approx(along, abs=0.02)
    assert rotate((x, y, z, w), (0.0, 1.0, 0.0))[2] == pytest.approx(0.0, abs=1e-6), "it does not roll"


# --- blocked muzzles ------------------------------------------------------------------------------------------------


def play_shooting(match, seconds, exit_speed):
    """Play while shooting; return the lowest and highest coordinates of any piece on the field or in the air [m]."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for _ in range(round(seconds / TICK)):
        spin_wheels(match, exit_speed)
        match.tick()
        here = match.pieces.state.pos[match.pieces.on_field()]
        if len(here):
            low, high = np.minimum(low, here.min(axis=0)), np.maximum(high, here.max(axis=0))
    assert match.count.is_conserved
    return low, high


def test_a_muzzle_inside_the_alliance_wall_holds_fire_until_the_robot_backs_off(caplog):
    """The muzzle is 0.1 m ahead of the bumpers, so a ball center would be 0.09 m inside the wall."""
    with match_with(robot(forward=0.5), (0.41, 4.0, math.pi)) as match:
        play_shooting(match, 1.0, 9.0)
        assert match.count.held == 60 and match.record.shots == []
        assert caplog.text.count("boundary_blue is in front of a muzzle") == 1
        match.robots[0].drive.set_chassis_speeds(-1.5, 0.0, 0.0)
        low, _ = play_shooting(match, 1.0, 9.0)
        assert 4 <= len(match.record.shots) <= 8 and low[0] > 0.0


@pytest.mark.parametrize("exit_speed", [6.0, 12.0, 25.0])
@pytest.mark.parametrize("yaw", [0.0, 0.6])
def test_a_robot_cannot_shoot_through_a_thin_wall(exit_speed, yaw):
    """A wall of 0.05 m at the bumpers; shots from any instant fly up to 0.5 m in their first tick and stay in front."""
    wall = box_element("thin", (8.0, 0.0, 0.0), (8.05, 8.0, 3.0))
    half = 0.4 * (math.cos(yaw) + math.sin(yaw))
    with match_with(robot(elevation=0.2), (8.0 - half - 0.01, 4.0, yaw), elements=(wall,)) as match:
        _, high = play_shooting(match, 2.0, exit_speed)
        assert len(match.record.shots) == 15
        assert high[0] < 8.0, "no center beyond the face"
        assert high[0] > 8.0 - RADIUS - 0.03, "they do meet it"


def test_a_shot_at_a_wall_bounces_back_within_its_first_tick():
    """12 m/s from a muzzle 0.21 m away from the wall: the shot hits after 11 ms and rebounds."""
    wall = box_element("wall", (8.0, 0.0, 0.0), (8.3, 8.0, 3.0))
    with match_with(robot(elevation=0.0), (8.0 - 0.51, 4.0, 0.0), elements=(wall,), count=1) as match:
        spin_wheels(match, 12.0)
        ((pos, velocity),) = tick_and_find(match)
        assert 7.8 < pos[0] < 8.0 - 0.1 * RADIUS and -12.0 < velocity[0] < 0.0


def test_an_overturned_robot_holds_fire_until_it_stands_again():
    """No shot leaves below the carpet, and all pieces stay in storage."""
    with match_with(robot(), (8.0, 4.0, 0.0)) as match:
        row = match.robots[0].chassis.row
        match.world.set_pose(row, (8.0, 4.0, 0.52), from_rpy(math.pi, 0.0, 0.0))
        match.robots[0].chassis.read()
        match.play(0.4)
        play_shooting(match, 1.0, 9.0)
        assert match.count.held == 60
        match.robots[0].reset((8.0, 4.0, 0.0))
        low, _ = play_shooting(match, 1.0, 9.0)
        assert len(match.record.shots) == 8 and low[2] > 0.0


def test_a_robot_does_not_shoot_into_the_body_of_another(caplog):
    """The muzzle is 0.1 m ahead of the bumpers, at the height of the other robot's frame."""
    config = robot(forward=0.5, height=0.4)
    with match_with(config, (4.0, 4.0, 0.0), (4.81, 4.0, 0.0)) as match:
        play_shooting(match, 0.5, 9.0)
        assert match.count.held == 60
        assert caplog.text.count("robot 1 is in front of a muzzle") == 1
        match.robots[1].reset((8.0, 6.0, 0.0))
        play_shooting(match, 0.5, 9.0)
        assert len(match.record.shots) == 4


@pytest.mark.parametrize("exit_speed", [1.0, 2.0])
def test_no_shot_overlaps_the_previous_shot(exit_speed, caplog):
    """Slow wheels let a ball fall back on the shooter and block it; shots overlap by no more than foam compresses."""
    with match_with(robot(forward=0.0, height=0.62, elevation=1.5), (8.0, 4.0, 0.0), count=8) as match:
        deepest, free = 0.0, match.pieces.on_field()
        for _ in range(150):
            spin_wheels(match, exit_speed)
            found = tick_and_find(match)
            for pos, _ in found:
                others = match.pieces.state.pos[free]
                if len(others):
                    gap = float(np.linalg.norm(others - pos, axis=1).min())
                    deepest = max(deepest, 2.0 * RADIUS - gap)
            free = match.pieces.on_field()
        assert deepest < 0.16 * 2.0 * RADIUS, "a tenth for foam, and what both move within the tick"
        assert "another Ball is in front of a muzzle" in caplog.text


@pytest.mark.parametrize("blocked", [0, 1])
def test_a_piece_at_one_muzzle_blocks_only_its_own_barrel(blocked, caplog):
    """Two muzzles 0.4 m apart, a ball at rest at one of them: only the other barrel shoots in this tick."""
    sides, config = (0.2, -0.2), robot(forward=0.0, height=0.62, elevation=1.2)
    (shooter,) = config.shooters
    config = replace(config, shooters=(replace(shooter, launch=replace(shooter.launch, barrels=sides)),))
    with match_with(config, (8.0, 4.0, 0.0), count=8) as match:
        (slot,) = match.robots[0].storage.in_turn[:1]
        match.robots[0].storage.discard(slot)
        match.pieces.launch(0, (8.0, 4.0 + sides[blocked], 0.62), (0.0, 0.0, 0.0), slot=slot, flying=False)
        spin_wheels(match, 9.0)
        match.tick()
        assert [shot.points[0][1] for shot in match.record.shots] == pytest.approx([4.0 + sides[1 - blocked]], abs=0.01)
        match.record.shots.clear()
        match.pieces.release(np.array([slot]), np.array([[3.0, 4.0, RADIUS]]))
        play_shooting(match, 0.3, 9.0)
        places = {round(shot.points[0][1] - 4.0, 1) for shot in match.record.shots}
        assert places == set(sides), "both, once the ball has gone"


@pytest.mark.parametrize(("height", "hits"), [(0.4, 1), (0.0, 0)])
def test_a_shot_that_rests_above_the_carpet_can_still_score(height, hits):
    """A ball that rolls in a goal for over 2 s may still score; a ball on the carpet has missed."""
    table = box_element("table", (8.0, 5.0, 0.0), (10.0, 7.0, 0.4))
    with match_with(robot(), (3.0, 2.0, 0.0), elements=(table,), count=1) as match:
        play_shooting(match, 0.5, 8.0)
        slot = match.record.shots[0].slot
        place = (9.0, 6.0, height + 0.3) if height else (6.0, 6.0, 0.3)
        match.pieces.release(np.array([slot]), np.array([place]))
        match.play(6.0)
        match.record.note_scored(ScoreEvent(match.time, "zone", "blue", 1, slot))
        assert match.record.hits == hits
