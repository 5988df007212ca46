"""Robots are placed only where they fit, and pieces keep one owner, for requests in any order."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from games.rebuilt.dimensions import HUB_CENTER
from simcore.errors import SimcoreError
from simcore.match.game import Game, RobotEntry
from simcore.match.match import Match
from simcore.match.registry import find_game
from simcore.match.starts import StartError, free_place
from simcore.pieces.piece_manager import Footprint
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.robot_config import RobotConfig

GAMES = ("rebuilt", "reefscape")
_DEEPEST = 0.020  # [m]


def ways_to_place(match):
    """Return all calls that place the first robot exactly; only `reset` restarts the gyro."""
    robot = match.robots[0]

    def by_command(pose):
        match.control.place_robot(pose)
        match.control.before_tick()
        if not match.control.results[-1].is_done:
            raise SimcoreError(match.control.results[-1].text)

    return [lambda pose: match.carry_to(0, pose), robot.reset, robot.carry_to, by_command]


def require_clear(match, pose):
    """Check that the placed robot overlaps nothing."""
    engine, robot = match.world.engine, match.robots[0]
    assert engine.depth(robot.chassis.row) < _DEEPEST, pose
    footprint = Footprint(*robot.chassis.footprint)
    pieces, radii = match.pieces.on_field(), match.pieces.radius
    pieces = pieces[match.pieces.state.pos[pieces, 2] < robot.chassis.config.bumper_top]
    gaps = footprint.gap(match.pieces.state.pos[pieces]) - radii[pieces]
    assert gaps.min(initial=0.0) > -_DEEPEST, pose


@pytest.mark.parametrize("name", GAMES)
def test_a_placed_robot_overlaps_nothing_and_reports_its_pose(name, whole):
    rng = np.random.default_rng(11)
    with Match(find_game(name), robots=(RobotEntry(), RobotEntry(alliance="red")), seed=1) as match:
        length, width = match.game.field.size
        robot, placed = match.robots[0], 0
        ways = ways_to_place(match)
        for number in range(5000 if whole else 150):
            if number % 250 == 249:
                match.reset_field()
            pose = (rng.uniform(-1.0, length + 1.0), rng.uniform(-1.0, width + 1.0), rng.uniform(-math.pi, math.pi))
            way, before = ways[number % len(ways)], (robot.chassis.pose, robot.gyro.yaw, robot.odometry.pose)
            try:
                way(pose)
            except SimcoreError:
                assert (robot.chassis.pose, robot.gyro.yaw, robot.odometry.pose) == before, "refused, and nothing moved"
                continue
            placed += 1
            assert 0.0 <= pose[0] <= length and 0.0 <= pose[1] <= width
            require_clear(match, pose)
            for found in (robot.chassis.pose, robot.odometry.pose):  # on an edge the robot turns a little as it settles
                assert found[:2] == pytest.approx(pose[:2], abs=1e-4)
                assert found[2] == pytest.approx(pose[2], abs=2e-3)
            assert robot.gyro.yaw == pytest.approx(pose[2] if way == robot.reset else before[1], abs=1e-9)
            soles, ground = robot.chassis.wheel_ground()
            assert (soles[:, 2] > ground - 0.001).all(), pose  # no wheel is inside the ground
            last = match.record.robots[0].placements[-1]
            assert last.pose == robot.chassis.pose and last.reason == ("reset" if way == robot.reset else "carried")
        assert placed > 40 and match.record.robots[0].distance == 0.0


@pytest.mark.parametrize("name", GAMES)
def test_pieces_can_be_placed_where_a_robot_stood_before_it_was_moved(name):
    """Even within a tick, a robot occupies only its last pose."""
    kind = find_game(name).pieces[0].kind
    with Match(find_game(name)) as match:
        for x in (3.0, 6.0):
            match.carry_to(0, (x, 5.8, 0.0))
        slots = match.pieces.spare(kind.name, 1)
        match.pieces.put_down(slots, np.array([[3.0, 5.8]]))
        assert match.pieces.state.pos[slots[0], :2] == pytest.approx((3.0, 5.8))


def test_a_robot_placed_on_a_bump_stands_tilted_and_stays_there():
    with Match(find_game("rebuilt")) as match:
        match.carry_to(0, (4.2, 2.5, 0.0))
        z, pitch = match.robots[0].chassis.pos[2], match.robots[0].chassis.roll_pitch_yaw[1]
        assert z > 0.03 and pitch < math.radians(-8.0)
        match.play(0.5)
        assert match.robots[0].chassis.pos[2] == pytest.approx(z, abs=0.005)


@pytest.mark.parametrize("place", [(0.21, 2.2, 0.0), (2.0, 0.22, 0.0), (4.44, 7.03, 0.0)])
def test_the_error_for_a_robot_placed_in_a_wall_suggests_a_free_pose(place):
    with Match(find_game("rebuilt")) as match:
        before = match.robots[0].chassis.pose
        for way in (lambda pose: match.carry_to(0, pose), match.robots[0].reset, match.robots[0].carry_to):
            with pytest.raises(SimcoreError, match=r"inside of a field element.*is free"):
                way(place)
            with pytest.raises(SimcoreError, match="outside of the field"):
                way((-3.0, 2.0, 0.0))
        assert match.robots[0].chassis.pose == before


def test_a_human_player_throws_only_algae_that_are_still_in_stock():
    with Match(find_game("reefscape"), seed=2) as match:
        algae = np.array([int(match.pieces.on_field("Algae")[0])])
        match.pieces.score(algae)
        match.rules.human_players.take_algae("blue", int(algae[0]))
        assert match.rules.human_players.waiting_algae["red"] == 1
        match.pieces.put_down(algae, np.array([[3.0, 3.0]]))  # people take it
        assert match.rules.human_players.waiting_algae["red"] == 0


def test_coral_placed_by_hand_is_taken_from_the_station_stock():
    with Match(find_game("reefscape")) as match:
        before = sum(match.rules.human_players.stock.values())
        match.pieces.put_down(match.pieces.spare("Coral", before), np.full((before, 2), 4.0))
        assert sum(match.rules.human_players.stock.values()) == 0


BARE = RobotConfig(drivetrain=TankConfig())
PUT_ENGINES = pytest.mark.parametrize("engine", ["bullet", "mujoco"])


@PUT_ENGINES
def test_a_robot_that_changes_sides_stands_next_to_a_robot_at_its_start(engine, caplog):
    entries = [RobotEntry(start=(2.6, 5.3, 0.0), preload=0), RobotEntry(start=(2.0, 2.0, 0.0), preload=0)]
    with Match(find_game("rebuilt"), robots=entries, engine=engine) as match:
        taken = find_game("rebuilt").field.symmetry.flip_pose(2.6, 5.3, 0.0)
        match.carry_to(1, taken)
        match.set_alliance(0, "red")
        match.play(0.5)
        assert match.robots[1].chassis.pose == pytest.approx(taken, abs=2e-3)
        assert math.dist(match.robots[0].chassis.pose[:2], taken[:2]) == pytest.approx(0.8, abs=0.05)
        assert max(robot.chassis.speed for robot in match.robots) < 0.05
    assert "its start is occupied" in caplog.text


@PUT_ENGINES
def test_two_robots_can_swap_alliances_in_the_same_tick(engine, caplog):
    game = find_game("rebuilt")
    with Match(game, robots=[RobotEntry(preload=0), RobotEntry(alliance="red", preload=0)], engine=engine) as match:
        before = [robot.chassis.pose for robot in match.robots]
        match.set_alliance(0, "red")
        match.set_alliance(1, "blue")
        match.tick()
        after = [robot.chassis.pose[:2] for robot in match.robots]
        assert after[0] == pytest.approx(before[1][:2], abs=1e-3) and after[1] == pytest.approx(before[0][:2], abs=1e-3)
    assert "taken" not in caplog.text


@PUT_ENGINES
def test_a_robot_cannot_be_placed_at_a_cage_and_stays_at_every_accepted_pose(engine):
    with Match(find_game("reefscape"), robots=[RobotEntry(start=(7.2, 2.0, 0.0), config=BARE)], engine=engine) as match:
        robot, taken = match.robots[0], 0
        for x in np.arange(8.0, 9.5, 0.25):
            for y in (0.8, 1.6, 2.4):
                try:
                    robot.reset((float(x), y, 0.0))
                except StartError:
                    continue
                taken += 1
                match.play(0.3)
                assert math.dist(robot.chassis.pose[:2], (x, y)) < 0.03, f"put at ({x:.2f}, {y:.2f}) m"
        assert 3 < taken < 18


def test_a_robot_cannot_be_placed_where_another_robot_will_be_in_the_next_tick():
    """The other robot drives at 4 m/s: 80 mm in 20 ms."""
    entries = [RobotEntry(start=(x, 4.0, 0.0), config=BARE) for x in (2.0, 12.0)]
    with Match(replace(Game.bare(), robots=2), robots=entries) as match:
        driver, other = match.robots
        match.play(1.5, controllers=[lambda robot, time: robot.drive.set_chassis_speeds(4.0, 0.0)])
        x, y, _ = driver.chassis.pose
        assert driver.chassis.speed > 2.5
        with pytest.raises(StartError, match="robot 1 starts inside of robot 0"):
            other.reset((x + 0.83, y, 0.0))
        other.reset((x + 1.0, y, 0.0))
        match.tick()
        driven, put = (robot.distance for robot in match.record.robots)
        assert driven == pytest.approx(x - 2.0, abs=0.15) and put < 0.01, "to be put somewhere is not to drive there"


def test_a_suggested_free_pose_is_never_on_a_ramp():
    """The requested pose is next to REBUILT's hub, on the bump, which is no obstacle."""
    game = find_game("rebuilt")
    with Match(game, robots=[RobotEntry(preload=0)]) as match:
        pose = (HUB_CENTER[0], HUB_CENTER[1] + 0.9, 0.0)
        x, y, _ = free_place(match.world, match.robots[0], pose, game.field.size)
        assert math.dist(pose[:2], (x, y)) > 0.2 and match.world.is_flat(x, y, 0.5 * math.hypot(0.8, 0.8))


def test_a_robot_cannot_be_placed_where_a_turning_robot_will_reach_in_the_next_tick():
    """At 10 rad/s, 0.2 rad in 20 ms: a side at 0.4 m reaches 0.4 (cos a + sin a) = 0.47 m."""
    entries = [RobotEntry(start=(x, 4.0, 0.0), config=BARE) for x in (2.0, 12.0)]
    with Match(replace(Game.bare(), robots=2), robots=entries) as match:
        driver, other = match.robots
        match.world.set_velocity(driver.chassis.row, (0.0, 0.0, 0.0), (0.0, 0.0, 10.0))
        driver.chassis.read()
        with pytest.raises(StartError, match="robot 1 starts inside of robot 0"):
            other.reset((2.0 + 0.4 + 0.4 + 0.03, 4.0, 0.0))
        other.reset((2.0 + 0.4 + 0.4 + 0.06, 4.0, 0.0))
