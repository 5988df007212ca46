"""Actions of people on the field by Python and NetworkTables: in order, before a tick, without loss of pieces."""

from __future__ import annotations

import logging
import math
import struct
import time
from dataclasses import replace

import numpy as np
import pytest
from dashboard import Dashboard
from game_table import GAMES

from simcore.errors import ConfigError
from simcore.match.game import PieceSupply, RobotEntry
from simcore.match.match import Match
from simcore.pieces.kinds import GamePieceConfig
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.robot_config import RobotConfig
from simcore.robotcode.networktables.control_topics import ControlTopics
from simcore.world.shapes import Sphere

BALL = GamePieceConfig(name="Ball", shape=Sphere(0.08), mass=0.2)


def last(match: Match) -> tuple[bool, str]:
    result = match.control.results[-1]
    return result.is_done, result.text


@pytest.mark.parametrize("name", GAMES)
def test_a_field_reset_restores_pieces_score_and_start_pose(name):
    """Four seconds into an auto, a reset returns every piece to its seeded place and sets the score to zero."""
    game = GAMES[name]
    auto = next(iter(game.autos))
    with Match(game, seed=4) as match:
        match.control.start_auto(auto)  # the auto may begin with other preloads
        match.tick()
        begin, places = match.count, match.pieces.state.pos[match.pieces.on_field()].copy()
        match.play(4.0)
        assert match.pieces.awake.size or match.record.taken_in or match.record.shots or match.count.placed
        match.set_controller(0, None)
        match.control.place_at_start()  # away from pieces, as the intake may still run
        match.control.reset_field()
        match.tick()
        assert last(match)[0], last(match)
        assert match.count == begin and match.score.total == 0 and not match.record.shots
        x, y, _ = match.start_pose(0)
        now = match.pieces.state.pos[match.pieces.on_field()]
        away = np.hypot(*(places[:, :2] - (x, y)).T) > 1.5  # the robot now occupies this place
        assert np.abs(now[away] - places[away]).max() < 0.03
        assert math.dist(match.robots[0].chassis.pose[:2], (x, y)) < 0.1
        match.play(0.5)
        assert match.count.is_conserved and match.pieces.recovered == 0


def test_pieces_can_be_spawned_until_the_supply_is_empty():
    with Match.bare(pieces=[PieceSupply(BALL, 6)]) as match:
        match.control.spawn("Ball", [(2.0, 2.0), (6.0, 4.0), (6.0, 4.0), (6.0, 4.0)])  # the first is below the robot
        match.tick()
        assert last(match)[0] and match.count.staged == match.count.on_field == 4
        lie = match.pieces.state.pos[match.pieces.on_field()]
        gaps = [math.dist(a, b) for k, a in enumerate(lie.tolist()) for b in lie[:k].tolist()]
        assert min(gaps) > 0.16 and math.hypot(*(lie[0, :2] - 2.0)) > 0.4
        before = match.pieces.state.pos.copy()
        match.control.spawn("Ball", [(3.0, 3.0)] * 3)
        match.control.spawn("Bell", [(3.0, 3.0)])
        match.control.spawn("Ball", [(30.0, 3.0)])
        match.play(0.5)
        said = [result.text for result in list(match.control.results)[1:]]
        assert said[0].startswith("2 of the game's 6 Ball are neither on the field nor in a robot, got 3")
        assert said[1].startswith("no game piece type named 'Bell'. Did you mean 'Ball'?")
        assert said[2] == "a piece at (30, 3) m would lie outside of the field of 16 x 8 m"
        # on MuJoCo a piece placed on the carpet sinks by 0.02 mm
        assert np.abs(match.pieces.state.pos - before).max() < 1e-4 and match.count.staged == 4
        match.pieces.score(match.pieces.on_field()[:1])
        match.control.spawn("Ball", [(3.0, 3.0)] * 2)
        match.tick()
        assert (match.count.staged, match.count.scored) == (6, 1), "what has scored comes back last"
        match.control.spawn("Ball", [(3.0, 3.0)])
        match.tick()
        assert match.count.on_field == match.count.staged == 6 and match.count.is_conserved
        for bad in ([(1.0, math.nan)], [(1.0,)], [], ["ab"]):
            with pytest.raises(ConfigError, match="spawn"):
                match.control.spawn("Ball", bad)


def test_a_robot_placed_among_pieces_overlaps_nothing(caplog):
    """Commands of a tick run in order; a refused command changes nothing and names a free place."""
    game = GAMES["rebuilt"]
    heard = []
    with Match(game, seed=1) as match, caplog.at_level(logging.INFO, "simcore.match.field_control"):
        match.control.placed.append(lambda robot, pose: heard.append((robot, pose)))
        goal = (8.27, 4.03, 0.5)  # in the middle of the neutral zone's fuel
        numbers = [match.control.place_robot(pose) for pose in (goal, (99.0, 4.0, 0.0), (4.6, 4.03, 0.0))]
        numbers.append(match.control.place_robot(goal, 3))
        assert numbers == [1, 2, 3, 4] and match.control.count == 0
        start = match.robots[0].chassis.pose
        match.tick()
        assert match.control.count == 4 and heard == [(0, goal)]
        said = [str(result) for result in match.control.results]
        assert said[0] == "1 done: robot 0 stands at (8.27, 4.03) m, 29 deg"
        assert said[1].startswith("2 refused: ") and "outside of the field of 16.541 x 8.069 m" in said[1]
        assert "inside of a field element" in said[2] and "m is free" in said[2]
        assert said[3] == "4 refused: there are robots 0 to 0, got 3"
        assert [record.levelname for record in caplog.records] == ["INFO", *["WARNING"] * 3]
        chassis = match.robots[0].chassis
        assert math.dist(chassis.pose[:2], goal[:2]) < 0.01 and match.count.is_conserved
        x, y = (match.pieces.state.pos[match.pieces.on_field(), :2] - goal[:2]).T
        c, s = math.cos(goal[2]), math.sin(goal[2])
        inside = (np.abs(c * x + s * y) < 0.4) & (np.abs(c * y - s * x) < 0.4)
        assert len(x) == 448 and not inside.any()
        match.play(0.5)
        assert math.dist(chassis.pose[:2], goal[:2]) < 0.02  # nothing pushes the robot away
        match.control.place_at_start()
        match.tick()
        assert chassis.pose == pytest.approx(start, abs=1e-3) and heard[-1] == (0, None)
        with pytest.raises(ConfigError, match="a pose is 3 finite numbers"):
            match.control.place_robot((1.0, 2.0))


def test_a_dashboard_controls_the_field_over_networktables():
    """The dashboard has buttons, numbers, a chooser and a Pose2d; retained values are no commands."""
    folder = "/Sim/Control/"
    with Dashboard() as board, Match(GAMES["rebuilt"], seed=2) as match:
        client = board.client
        kept = client.get_boolean_topic(folder + "ResetField").publish()
        kept.set(True)
        board.connect(folder)
        topics = ControlTopics(match, board.server)
        status = client.get_string_topic(folder + "Status").subscribe("")
        count = client.get_integer_topic(folder + "Count").subscribe(-1)

        def done(number: int) -> str:
            """Play until this many commands are done and the dashboard has received the results."""
            board.until(match, lambda: count.get() == number)
            assert match.control.count == number
            return str(status.get())

        assert done(0) == "0 ready"
        x, y = (client.get_double_topic(folder + name).publish() for name in "XY")
        x.set(6.5), y.set(6.0)
        button = client.get_boolean_topic(folder + "PlaceRobot").get_entry(False)
        button.set(True)
        assert done(1) == "1 done: robot 0 stands at (6.50, 6.00) m, 0 deg"
        board.until(match, lambda: not button.get())  # the button is released
        pose = client.get_raw_topic(folder + "RobotPose").publish("struct:Pose2d")
        pose.set(struct.pack("<3d", 3.0, 2.5, 1.0))
        assert done(2) == "2 done: robot 0 stands at (3.00, 2.50) m, 57 deg"
        pose.set(struct.pack("<3d", -3.0, 2.5, 1.0))
        assert done(3).startswith("3 refused: ") and match.robots[0].chassis.pose[0] == pytest.approx(3.0, abs=0.01)
        drop = client.get_boolean_topic(folder + "SpawnPiece").publish()
        drop.set(True)
        assert done(4).startswith("4 done: 1 Fuel put down at (6.5")
        spawn = client.get_double_array_topic(folder + "Spawn/Fuel").publish()
        spawn.set([3.0, 6.0, 3.5])
        assert "pairs x, y [m]; got 3 numbers" in done(5)
        spawn.set([3.0, 6.0, 3.5, 6.0])
        assert done(6) == "6 done: 2 Fuel put down starting at (3.00, 6.00) m"
        assert client.get_string_topic(folder + "Auto/.type").subscribe("").get() == "String Chooser"
        assert client.get_string_array_topic(folder + "Auto/options").subscribe([]).get() == list(match.game.autos)
        selected = client.get_string_topic(folder + "Auto/selected").publish()
        selected.set("neutral")
        go = client.get_boolean_topic(folder + "StartAuto").publish()
        go.set(True)
        assert done(7) == "7 done: auto 'neutral' begins"
        assert match.timer.time < 5.0 and match.count.staged == 504 and match.count.held == 8
        match.play(2.0)
        assert match.robots[0].chassis.pose[0] > match.start_pose(0)[0] + 0.2
        topics.close()
        button.set(True)
        time.sleep(0.2)
        match.play(0.1)
        assert match.control.count == 7


@pytest.mark.parametrize("name", ["rebuilt", "reefscape"])
def test_an_auto_for_the_games_own_robot_is_refused_for_another_robot(name):
    game = GAMES[name]
    entry = RobotEntry(start=(2.0, 2.0, 0.0), config=RobotConfig(drivetrain=TankConfig()), preload=0)
    with Match(game, robots=[entry]) as match:
        for auto in game.autos:
            match.control.start_auto(auto)
            match.play(0.1)
            result = match.control.results[-1]
            assert not result.is_done and "is for the game's own robot, and robot 0 has no " in result.text
        assert match.entries == (entry,) and match.field_resets == 0


def test_the_match_continues_after_an_auto_raises_an_error():
    """The match reports the error as the result of the auto."""

    def fail(robot, time):
        raise IndexError("list index out of range")

    game = GAMES["rebuilt"]
    auto = replace(game.auto("depot"), controller=lambda match, alliance: fail)
    with Match(replace(game, autos={"depot": auto})) as match:
        match.control.start_auto("depot")
        match.play(0.1)
        begun, ended = list(match.control.results)[-2:]
        assert begun.is_done and not ended.is_done and ended.text == "IndexError: list index out of range"
